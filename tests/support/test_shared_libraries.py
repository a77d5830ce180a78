"""Which libraries stand before a wheel's own, and in which order the own ones are to be loaded."""

from __future__ import annotations

from pathlib import Path

import pytest

from twistarm.support import shared_libraries


@pytest.fixture(autouse=True)
def _no_shell(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(shared_libraries.SEARCHED_FIRST, raising=False)


def prefixed(folder: Path) -> Path:
    """The site-packages of a wheel that keeps its libraries in <prefix>/lib."""
    return folder / "cmeel.prefix" / "lib" / "python3.x" / "site-packages"


def libraries(folder: Path, **needed: str) -> None:
    """Files that name what they are linked against, as a string table does."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, others in needed.items():
        strings = b"\0".join(other.encode() for other in others.split())
        (folder / f"{name}.so").write_bytes(b"\x7fELF\0" + strings + b"\0")


def test_strangers_in_the_order_of_the_linkage(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    site = prefixed(tmp_path)
    own = site.parents[1]
    libraries(own, libtop="libmiddle.so libm.so.6", libmiddle="libbase.so", libbase="", libunused="")
    libraries(site / "engine", extension="libtop.so libbase.so")
    libraries(tmp_path / "ros", libbase="", libtop="", libunused="", libother="")
    libraries(tmp_path / "later", libbase="", libmiddle="")
    package_file = site / "engine" / "__init__.py"
    assert shared_libraries.shadowed(package_file) == ()
    folders = (tmp_path / "missing", tmp_path / "ros", tmp_path / "later")
    monkeypatch.setenv(shared_libraries.SEARCHED_FIRST, ":".join(map(str, folders)))
    assert shared_libraries.shadowed(package_file) == (
        (tmp_path / "ros" / "libbase.so", own / "libbase.so"),
        (tmp_path / "later" / "libmiddle.so", own / "libmiddle.so"),
        (tmp_path / "ros" / "libtop.so", own / "libtop.so"),
    )


def test_the_wheels_own_folder_is_no_stranger(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    site = prefixed(tmp_path)
    libraries(site.parents[1], libtop="")
    libraries(site / "engine", extension="libtop.so")
    libraries(tmp_path / "ros", libtop="")
    monkeypatch.setenv(shared_libraries.SEARCHED_FIRST, f"{site.parents[1]}:{tmp_path / 'ros'}")
    assert shared_libraries.shadowed(site / "engine" / "__init__.py") == ()


def test_an_empty_entry_is_the_current_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    site = prefixed(tmp_path)
    libraries(site.parents[1], libtop="")
    libraries(site / "engine", extension="libtop.so")
    libraries(tmp_path / "here", libtop="")
    monkeypatch.chdir(tmp_path / "here")
    monkeypatch.setenv(shared_libraries.SEARCHED_FIRST, f"{tmp_path / 'nothing'}:")
    assert [own.name for _, own in shared_libraries.shadowed(site / "engine" / "__init__.py")] == ["libtop.so"]


def test_other_packages_have_no_libraries_of_their_own(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    site = tmp_path / "lib" / "python3.x" / "site-packages"
    libraries(site.parents[1], libtop="")
    libraries(site / "engine", extension="libtop.so")
    libraries(tmp_path / "ros", libtop="")
    monkeypatch.setenv(shared_libraries.SEARCHED_FIRST, str(tmp_path / "ros"))
    assert shared_libraries.shadowed(site / "engine" / "__init__.py") == ()
