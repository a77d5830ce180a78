"""No archive of a stranger opens a door into its reader's own files: by links, by swapped folders, by variables."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import pytest

from hostile.doors import LINKS, MANIFEST, Reader, lay, link, reader, swapping, texts
from hostile.sandbox import TOKEN, XMLNS
from twistarm.description.beside import files_beside
from twistarm.description.expansion.confinement import confinement
from twistarm.description.expansion.expand import expand_xacro
from twistarm.description.expansion.work import Refused
from twistarm.description.packages import package_index
from twistarm.errors import DescriptionError

PART = f'<robot {XMLNS}><link name="part"/></robot>'


@pytest.fixture
def victim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Reader:
    made = reader(tmp_path.resolve())
    monkeypatch.setenv("HOME", str(made.home))
    return made


def read(path: Path, *package_dirs: Path) -> str:
    """What the description expands to, or why it does not."""
    try:
        return expand_xacro(path, package_index(path, package_dirs))[0]
    except DescriptionError as error:
        return str(error)


@pytest.mark.parametrize("case", LINKS)
def test_no_link_of_an_archive_opens_what_it_points_at(case: str, victim: Reader) -> None:
    lay(victim.archive, {"arm/arm.xacro": ""})
    link(victim.archive, LINKS[case](victim.secret))
    path = victim.archive / "arm" / "arm.xacro"
    for reading, text in texts(victim.secret):
        path.write_text(text)
        for package_dirs in ((), (victim.archive,), (victim.archive / "arm", victim.archive)):
            assert TOKEN not in read(path, *package_dirs), reading


def test_whoever_names_the_workspace_or_has_sourced_it_opens_its_packages(
    victim: Reader, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The tests above can fail, and a workspace built with links still works, its file anywhere."""
    path = victim.home / "arm" / "arm.xacro"
    text = f'<robot name="arm" {XMLNS}><xacro:include filename="$(find secret)/urdf/key.xacro"/></robot>'
    lay(path.parent, {"arm.xacro": text})
    workspace = victim.home / "ros_ws"
    assert "package 'secret' not found" in read(path)
    for folder in (workspace, workspace / "src", workspace / "install", workspace / "install/secret/share"):
        assert TOKEN in read(path, folder)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(workspace / "install" / "secret"))
    assert TOKEN in read(path)


def test_a_sourced_workspace_whose_sources_are_links(victim: Reader, monkeypatch: pytest.MonkeyPatch) -> None:
    lay(victim.home, {"repos/part/package.xml": MANIFEST("part"), "repos/part/urdf/part.xacro": PART})
    source, installed = victim.home / "ros_ws/src", victim.home / "ros_ws/install/part"
    link(source, {"part": victim.home / "repos" / "part"})
    link(installed / "share/part", {name: source / "part" / name for name in ("package.xml", "urdf/part.xacro")})
    text = f'<robot name="arm" {XMLNS}><xacro:include filename="$(find part)/urdf/part.xacro"/></robot>'
    lay(source, {"arm/package.xml": MANIFEST("arm"), "arm/urdf/arm.xacro": text})
    path = source / "arm" / "urdf" / "arm.xacro"
    assert "part.xacro lies outside the folders that may be read" in read(path)
    assert 'name="part"' in read(path, victim.home / "repos")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(installed))
    assert 'name="part"' in read(path)


def test_an_srdf_that_is_a_link_is_none_that_stands_beside(victim: Reader) -> None:
    lay(victim.secret, {"arm.srdf": "<robot name='arm'/>"})
    lay(victim.archive, {"arm.urdf": "<robot name='arm'/>", "config/arm.srdf": "<robot name='arm'/>"})
    link(victim.archive, {"arm.srdf": victim.secret / "arm.srdf", "srdf": victim.secret})
    assert files_beside(victim.archive / "arm.urdf", "*.srdf") == (victim.archive / "config" / "arm.srdf",)


def swapped_reads(victim: Reader, tries: int) -> tuple[int, int, int]:
    """How often a folder was swapped for a link into the secret meanwhile, and what was read: ours, the secret."""
    lay(victim.archive, {"arm.xacro": PART, "config/key.yaml": "key: open"})
    guard = confinement(victim.archive / "arm.xacro", package_index(victim.archive / "arm.xacro"))
    ours = secrets = 0
    with swapping(victim.archive / "config", victim.secret / "config") as swaps:
        for _ in range(tries):
            with suppress(Refused, OSError):
                text = guard.read(str(victim.archive / "config" / "key.yaml"))[1]
                ours += text == "key: open"
                secrets += TOKEN in text
            with suppress(Refused, OSError):
                secrets += "secret.yaml" in guard.entries(victim.archive / "config")
    return swaps[0], ours, secrets


def test_a_folder_that_is_swapped_for_a_link_opens_nothing(victim: Reader) -> None:
    lay(victim.secret, {"config/secret.yaml": TOKEN})
    swaps, ours, secrets = swapped_reads(victim, 2000)
    assert min(swaps, ours) > 20
    assert secrets == 0


@pytest.mark.slow
def test_tens_of_thousands_of_tries_open_nothing(victim: Reader) -> None:
    lay(victim.secret, {"config/secret.yaml": TOKEN})
    swaps, ours, secrets = swapped_reads(victim, 70_000)
    print(f"\na folder swapped for a link {swaps} times in 140,000 tries: {ours} files read, {secrets} secrets")
    assert secrets == 0
