"""Who may read what is not yet written."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest

from twistarm.support.files import write_whole


@pytest.fixture
def permissions(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """The permissions that each file had when it was made, with nothing taken away by the umask."""
    seen: list[int] = []
    opened = os.open

    def noting(name: str, flags: int, mode: int = 0o777, **rest: int) -> int:
        descriptor = opened(name, flags, mode, **rest)
        if flags & os.O_CREAT:
            seen.append(stat.S_IMODE(os.fstat(descriptor).st_mode))
        return descriptor

    before = os.umask(0)
    monkeypatch.setattr(os, "open", noting)
    yield seen
    os.umask(before)


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o444, 0o664])
def test_the_temporary_file_has_the_permissions_of_what_it_replaces(
    mode: int, tmp_path: Path, permissions: list[int]
) -> None:
    path = tmp_path / "token"
    path.write_text("old")
    path.chmod(mode)
    permissions.clear()
    write_whole(path, "new")
    assert permissions == [0o600], "until it has the group of what it replaces"
    assert (path.read_text(), stat.S_IMODE(path.stat().st_mode)) == ("new", mode)


def test_a_group_that_cannot_be_given_gets_no_permission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: int) -> None:
        raise PermissionError

    path = tmp_path / "a"
    path.write_text("old")
    path.chmod(0o664)
    monkeypatch.setattr(os, "fchown", refused)
    write_whole(path, "new")
    assert stat.S_IMODE(path.stat().st_mode) == 0o604


def test_a_long_name_of_long_characters_can_be_written(tmp_path: Path) -> None:
    assert write_whole(tmp_path / ("🦾" * 60), "x").read_text() == "x"
