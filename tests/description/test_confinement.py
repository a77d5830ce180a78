"""Which files a xacro description opens: its own package's and those of packages it is given; no device, no giant."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from hostile.sandbox import TOKEN, XMLNS, Sandbox
from hostile.sandbox import place as place
from twistarm.description.expansion.confinement import MAX_BYTES, Confinement
from twistarm.description.expansion.expand import expand_xacro
from twistarm.description.expansion.work import Refused
from twistarm.description.packages import package_index, package_name
from twistarm.support.errors import DescriptionError
from xacro_text import MANIFEST, lay

PART = f'<robot {XMLNS}><link name="part"/></robot>'
OUTSIDE = "lies outside the folders that may be read"


def include(filename: str, more: str = "") -> str:
    return f'<xacro:include filename="{filename}" {more}/>'


def load(filename: str) -> str:
    return f"<link name=\"${{xacro.load_yaml('{filename}')}}\"/>"


HOSTILE = {
    "an absolute include": (include("@SECRET"), OUTSIDE),
    "up and over": (include("../outside/secret.xacro"), OUTSIDE),
    "through a package": (include("$(find arm)/../outside/secret.xacro"), OUTSIDE),
    "through a property": ('<xacro:property name="f" value="@SECRET"/>' + include("${f}"), OUTSIDE),
    "through the environment": (include("$(env CANARY_FOLDER)/secret.xacro"), "is not set for it"),
    "through an optional variable": (include("$(optenv NO_SUCH_VARIABLE @SECRET)"), OUTSIDE),
    "optional all the same": (include("../outside/secret.xacro", 'optional="true"'), OUTSIDE),
    "by abs_filename": ("<link name=\"${xacro.load_yaml(xacro.abs_filename('../outside/secret.yaml'))}\"/>", OUTSIDE),
    "in a macro's default": (
        '<xacro:macro name="m" params="c:=${load_yaml(\'@SECRET\')}"><link name="${c}"/></xacro:macro><xacro:m/>',
        OUTSIDE,
    ),
    "through a link": (include("link.xacro"), OUTSIDE),
    "through a linked folder": (include("linked/secret.xacro"), OUTSIDE),
    "from an included file": (include("deeper.xacro"), OUTSIDE),
    "wildcards through a link": (include("linked/*.xacro"), OUTSIDE),
    "wildcards that find a link": (include("lin*.xacro"), OUTSIDE),
    "wildcards in folders": (include("*/../*/../*/../*/../*/secret.xacro"), "wildcards in the folder"),
    "a URI": (include("file://@SECRET"), "is a URI; only files of packages are opened"),
    "a package URI": (include("package://arm/parts.xacro"), "No such file or directory"),
    "a folder": (include("."), "is no regular file"),
    "a pipe": (include("pipe"), "is no regular file"),
    "zeros without end": (load("/dev/zero"), OUTSIDE),
    "a giant": (include("giant.xacro"), "has 50,000,000 bytes; at most 10,000,000 are read"),
    "itself in circles": (include("arm.xacro"), "refers to itself without end"),
    "a link to itself": (include("loop.xacro"), "xacro cannot expand it"),
    "a name without an encoding": (load("\\ud800"), "is no path"),
    "an endless name": (load("a" * 5000), "xacro cannot expand it: File name too long"),
    "a missing file": (include("absent.xacro"), "No such file or directory"),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_nothing_outside_is_opened(case: str, place: Sandbox, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CANARY_FOLDER", str(place.secret.parent))
    monkeypatch.chdir(place.folder)
    inside, message = HOSTILE[case]
    place.write(
        {"package.xml": MANIFEST("arm"), "deeper.xacro": f"<robot {XMLNS}>{include('../outside/secret.xacro')}</robot>"}
    )
    arm = place.folder / "arm"
    (arm / "link.xacro").symlink_to(place.secret.with_suffix(".xacro"))
    (arm / "linked").symlink_to(place.secret.parent)
    (arm / "loop.xacro").symlink_to("loop.xacro")
    os.mkfifo(arm / "pipe")
    with open(arm / "giant.xacro", "wb") as giant:
        giant.truncate(50_000_000)
    found = place.refuse(place.fill(inside))
    assert message in found
    if message == OUTSIDE:
        assert str(arm) in found
        assert found.endswith("pass package_dirs=[...] (the folder that holds its package)")


def test_the_canary_sings(place: Sandbox) -> None:
    """The tests above can fail: what reads the secret or runs a command is noticed, here with xacro as it is."""
    import xacro

    for text in (load("@SECRET"), "<a b=\"${(lambda: load_yaml('@SECRET'))()}\"/>"):
        place.write({"arm.xacro": f"<robot {XMLNS}>{text}</robot>"})
        with place.watched():
            xacro.process_file(str(place.folder / "arm" / "arm.xacro"), verbosity=0)
        with pytest.raises(AssertionError):
            place.untouched()
        place.events.clear()


ENTITIES = '<!DOCTYPE robot [<!ENTITY s SYSTEM "file://@SECRET"><!ENTITY a "aaaa">{}]>'
LAUGHS = "".join(f'<!ENTITY l{i + 1} "{f"&l{i};" * 10}">' for i in range(12))


@pytest.mark.parametrize("where", ["the file", "an included file"])
@pytest.mark.parametrize(
    "head",
    [
        ENTITIES.format(""),
        ENTITIES.format('<!ENTITY l0 "ha">' + LAUGHS),
        '<!DOCTYPE robot SYSTEM "file://@SECRET">',
        "<!DOCTYPE robot>",
    ],
)
def test_document_types_are_refused_in_every_file(where: str, head: str, place: Sandbox) -> None:
    body = f'{head}<robot {XMLNS}><link name="a">&s;&l12;</link></robot>'
    if where == "the file":
        place.write({"arm.xacro": body})
        with pytest.raises(Exception, match="a document type .* is not allowed; remove it") as caught:
            place.expand_file()
        message = place.check(caught.value)  # type: ignore[arg-type]
        assert "arm.xacro:1: " in message
    else:
        message = place.refuse(include("part.xacro"), {"part.xacro": body})
        assert "part.xacro:1: a document type (<!DOCTYPE robot>) is not allowed; remove it" in message


def test_a_manifest_with_entities_or_a_giant_one_names_no_package(tmp_path: Path) -> None:
    manifest = tmp_path / "package.xml"
    bomb = '<!DOCTYPE package [<!ENTITY l0 "arm">' + LAUGHS + "]>"
    for text in (f"{bomb}<package><name>&l12;</name></package>", "<!DOCTYPE package><package><name>a</name></package>"):
        manifest.write_text(text)
        assert package_name(tmp_path) is None
    manifest.write_text(f"<package>{' ' * 2_000_000}<name>arm</name></package>")
    assert package_name(tmp_path) is None
    manifest.write_text("<package><name> arm </name></package>")
    assert package_name(tmp_path) == "arm"
    manifest.unlink()
    os.mkfifo(manifest)
    assert package_name(tmp_path) is None


def opened(folder: Path, file: str, package_dirs: tuple[Path, ...] = ()) -> str:
    path = folder / file
    return expand_xacro(path, package_index(path, package_dirs))[0]


def main(*filenames: str) -> str:
    return f'<robot name="r" {XMLNS}>{"".join(map(include, filenames))}</robot>'


def test_its_own_package_is_open_to_a_description(tmp_path: Path) -> None:
    lay(
        tmp_path,
        {
            "ws/arm/package.xml": MANIFEST("arm"),
            "ws/arm/urdf/arm.xacro": main(
                "../parts/a.xacro", "$(find arm)/parts/b.xacro", str(tmp_path / "ws/arm/c.xacro")
            ),
            **{f"ws/arm/{name}.xacro": PART for name in ("parts/a", "parts/b", "c")},
        },
    )
    assert opened(tmp_path, "ws/arm/urdf/arm.xacro").count("part") >= 3


@pytest.mark.parametrize("folder", ["urdf", "models"])
def test_without_a_package_a_folder_called_urdf_belongs_to_the_one_above(folder: str, tmp_path: Path) -> None:
    lay(tmp_path, {f"tree/{folder}/arm.xacro": main("../meshes/a.xacro"), "tree/meshes/a.xacro": PART})
    assert 'name="part"' in opened(tmp_path, f"tree/{folder}/arm.xacro")
    lay(tmp_path, {"tree/other/arm.xacro": main("../meshes/a.xacro")})
    with pytest.raises(Exception, match=OUTSIDE):
        opened(tmp_path, "tree/other/arm.xacro")


def test_a_named_folder_opens_the_packages_in_it_and_no_loose_file(tmp_path: Path) -> None:
    """Whoever names it: an arm.toml from elsewhere would otherwise open /etc."""
    lay(
        tmp_path,
        {
            "arm/arm.xacro": main("../one/deep/a.xacro", "$(find two)/a.xacro"),
            "one/deep/a.xacro": PART,
            "other/two/a.xacro": PART,
            "other/two/package.xml": MANIFEST("two"),
        },
    )
    folders = (tmp_path / "one", tmp_path / "other")
    with pytest.raises(Exception, match=f"one/deep/a.xacro {OUTSIDE}"):
        opened(tmp_path, "arm/arm.xacro", folders)
    lay(tmp_path, {"one/deep/package.xml": MANIFEST("one")})
    assert opened(tmp_path, "arm/arm.xacro", folders).count('"part"') == 2


def test_a_name_opens_no_other_folder_of_that_name(tmp_path: Path) -> None:
    """A package that takes another's name opens itself, not its namesake elsewhere on the disk."""
    lay(
        tmp_path,
        {
            "download/arm/package.xml": MANIFEST("arm"),
            "download/arm/arm.xacro": main("../../home/team/secret/a.xacro"),
            "download/impostor/package.xml": MANIFEST("secret"),
            "home/team/secret/package.xml": MANIFEST("secret"),
            "home/team/secret/a.xacro": PART,
        },
    )
    with pytest.raises(DescriptionError, match=OUTSIDE):
        opened(tmp_path, "download/arm/arm.xacro", (tmp_path / "download",))
    assert '"part"' in opened(tmp_path, "download/arm/arm.xacro", (tmp_path / "home",))


def test_packages_that_the_index_finds_are_open(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lay(
        tmp_path,
        {
            "ws/arm/package.xml": MANIFEST("arm"),
            "ws/arm/arm.xacro": main("$(find beside)/a.xacro", "$(find ament)/a.xacro", "$(find ros)/a.xacro"),
            "ws/folder_of_another_name/package.xml": MANIFEST("beside"),
            "prefix/share/ament/package.xml": MANIFEST("ament"),
            "stack/deeper/ros/package.xml": MANIFEST("ros"),
            **{f"{f}/a.xacro": PART for f in ("ws/folder_of_another_name", "prefix/share/ament", "stack/deeper/ros")},
        },
    )
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "prefix"))
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "stack"))
    assert opened(tmp_path, "ws/arm/arm.xacro").count('"part"') == 3


def test_a_workspace_of_links_works(tmp_path: Path) -> None:
    """`colcon build --symlink-install`: share/<package> holds links into the sources."""
    sources = lay(
        tmp_path / "ws" / "src" / "group" / "deeper",
        {
            "arm/package.xml": MANIFEST("arm"),
            "arm/urdf/arm.xacro": main("$(find gripper)/urdf/gripper.xacro", "$(find arm)/urdf/part.xacro"),
            "arm/urdf/part.xacro": PART,
            "gripper/package.xml": MANIFEST("gripper"),
            "gripper/urdf/gripper.xacro": PART,
        },
    )
    for name in ("arm", "gripper"):
        share = tmp_path / "ws" / "install" / name / "share" / name
        (share / "urdf").mkdir(parents=True)
        (share / "package.xml").symlink_to(sources / name / "package.xml")
        for file in (sources / name / "urdf").iterdir():
            (share / "urdf" / file.name).symlink_to(file)
    install = tmp_path / "ws" / "install"
    text = opened(install, "arm/share/arm/urdf/arm.xacro", (install / "gripper" / "share", install / "arm" / "share"))
    assert text.count('"part"') == 2


def test_the_home_folder_is_never_open_as_a_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    (tmp_path / ".ssh").mkdir()
    (tmp_path / ".ssh" / "key.yaml").write_text(f"key: {TOKEN}")
    text = f'<robot name="r" {XMLNS}>{load(str(tmp_path / ".ssh" / "key.yaml"))}</robot>'
    lay(tmp_path, {"arm.xacro": text, "urdf/arm.xacro": text, "package.xml": MANIFEST("all")})
    for file in ("arm.xacro", "urdf/arm.xacro"):
        for package_dirs in ((), (tmp_path,), (Path("/"),), (tmp_path.parent,)):
            roots = Confinement(tmp_path / file, package_index(tmp_path / file, package_dirs)).roots
            assert not any(tmp_path.is_relative_to(root) for root in roots)
            with pytest.raises(Exception, match=OUTSIDE):
                opened(tmp_path, file, package_dirs)


def test_a_description_in_the_home_folder_itself_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    lay(tmp_path, {"alone.xacro": PART, "arm.xacro": main("alone.xacro")})
    assert 'name="part"' in opened(tmp_path, "alone.xacro")
    with pytest.raises(Exception, match=OUTSIDE):
        opened(tmp_path, "arm.xacro")


def test_a_file_up_to_the_size_is_read(tmp_path: Path) -> None:
    lay(tmp_path, {"arm.xacro": "", "a.yaml": "a: 1"})
    guard = Confinement(tmp_path / "arm.xacro", package_index(tmp_path / "arm.xacro"))
    with open(tmp_path / "a.yaml", "wb") as file:
        file.truncate(MAX_BYTES)
    assert guard.read(str(tmp_path / "a.yaml"))[0] == (tmp_path / "a.yaml").resolve()
    with open(tmp_path / "a.yaml", "wb") as file:
        file.truncate(MAX_BYTES + 1)
    with pytest.raises(Refused):
        guard.read(str(tmp_path / "a.yaml"))


def test_wildcards_match_as_in_xacro(tmp_path: Path) -> None:
    names = ("one.xacro", "two.xacro", ".hidden.xacro", "three.txt")
    lay(tmp_path, {"arm [2]/arm.xacro": main("parts/*.xacro"), **{f"arm [2]/parts/{name}": PART for name in names}})
    assert opened(tmp_path, "arm [2]/arm.xacro").count('"part"') == 2
    lay(tmp_path, {"arm [2]/arm.xacro": main("parts/none*.xacro", "parts/[ot]*.xacro", "parts/t?o.xacro")})
    assert opened(tmp_path, "arm [2]/arm.xacro").count('"part"') == 3
