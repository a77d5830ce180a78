"""What a write leaves behind when it is killed, and who may read what is not yet written."""

from __future__ import annotations

import fcntl
import os
import signal
import stat
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from twistarm.support.files import write_whole
from twistarm.support.temporaries import LEFT_AFTER, TEMPORARY

KILLED = """
import os, signal, sys
from twistarm.support.files import write_whole
os.fsync = lambda descriptor: os.kill(os.getpid(), signal.SIGKILL)
write_whole(sys.argv[1], "x" * 1000)
"""


def left_by_a_kill(folder: Path) -> Path:
    """The temporary file of a process that was killed while it wrote, an hour ago."""
    done = subprocess.run([sys.executable, "-c", KILLED, str(folder / "motion.csv")], check=False, timeout=60)
    assert done.returncode == -signal.SIGKILL
    (left,) = folder.iterdir()
    assert left.name.endswith(TEMPORARY)
    return left


def aged(path: Path) -> Path:
    os.utime(path, (0, path.stat().st_mtime - 2 * LEFT_AFTER))
    return path


def test_a_killed_process_s_leftovers_go_with_the_next_write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    left = left_by_a_kill(tmp_path)
    write_whole(tmp_path / "other.csv", "")
    assert left.exists(), "too young to tell it from one that is just being made"
    aged(left)
    with monkeypatch.context() as another:
        another.setattr(os, "geteuid", lambda: left.stat().st_uid + 1)
        write_whole(tmp_path / "other.csv", "")
    assert left.exists(), "another user's"
    write_whole(tmp_path / "other.csv", "")
    assert sorted(os.listdir(tmp_path)) == ["other.csv"]


def test_nothing_else_is_swept(tmp_path: Path) -> None:
    ours = f".motion.csv.0123456789ab{TEMPORARY}"
    (tmp_path / "held").mkdir()
    held = aged(Path(write_whole(tmp_path / "held" / "a", "")).rename(tmp_path / ours))
    strangers = [f"motion.csv.0123456789ab{TEMPORARY}", ".motion.csv.0123456789ab.part", f".a.0123456789xy{TEMPORARY}"]
    for name in strangers:
        (tmp_path / name).write_text("")
        aged(tmp_path / name)
    (tmp_path / f".link.0123456789ab{TEMPORARY}").symlink_to(tmp_path / strangers[0])
    (tmp_path / f".folder.0123456789ab{TEMPORARY}").mkdir()
    os.mkfifo(tmp_path / f".pipe.0123456789ab{TEMPORARY}")
    before = sorted(os.listdir(tmp_path))
    with held.open() as file:
        fcntl.flock(file, fcntl.LOCK_EX)  # as a slow writer does, in another process or thread
        write_whole(tmp_path / "held" / "a", "")
        write_whole(tmp_path / "new", "")
        assert sorted(os.listdir(tmp_path)) == sorted([*before, "new"])
    write_whole(tmp_path / "new", "")
    assert sorted(os.listdir(tmp_path)) == sorted({*before, "new"} - {ours})


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
