"""No archive of a stranger opens a door into its reader's own files: by links or by variables."""

from __future__ import annotations

from pathlib import Path

import pytest

from hostile.doors import LINKS, MANIFEST, Reader, lay, link, reader, texts
from hostile.sandbox import TOKEN, XMLNS
from twistarm import Arm, load_arm
from twistarm.cli.application import run
from twistarm.description.companions.companion_files import files_beside
from twistarm.description.expansion.expand import expand_xacro
from twistarm.description.packages import package_index
from twistarm.description.urdf import read_description
from twistarm.support.errors import DescriptionError, InputError
from urdf_text import joint, write
from xacro_text import as_xacro

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


@pytest.mark.parametrize("named", ["~/ros_ws/src", "../../../ros_ws/src", "@HOME/ros_ws"])
def test_an_arm_file_opens_no_package_far_from_it_but_its_meshes(named: str, victim: Reader) -> None:
    """Whoever wrote the archive knows where packages usually stand; a mesh is drawn, and cannot be quoted."""
    cube = victim.secret / "meshes" / "cube.stl"
    lay(victim.secret, {"meshes/cube.stl": "solid"})
    mesh = '<visual><geometry><mesh filename="$(find secret)/meshes/cube.stl"/></geometry></visual>'
    links = f'<link name="base">{mesh}</link><link name="tip"/>{joint("a", "base", "tip")}'
    robot = f'<robot name="arm" {XMLNS}>{{}}{links}</robot>'
    key = '<xacro:include filename="$(find secret)/urdf/key.xacro"/>'
    folders = f'package_dirs = ["{named.replace("@HOME", str(victim.home))}"]'
    path = victim.archive / "arm" / "arm.toml"

    def loaded(text: str, **options: object) -> Arm:
        lay(path.parent, {"arm.toml": f'source = "arm.xacro"\n{folders}', "arm.xacro": text})
        return load_arm(path, **options)  # type: ignore[arg-type]

    description = loaded(robot.format("")).description
    assert description is not None
    assert description.links["base"].visuals[0].mesh == cube
    for reading, text in texts(victim.secret):
        with pytest.raises(DescriptionError) as caught:
            loaded(text)
        assert TOKEN not in str(caught.value), reading
    with pytest.raises(DescriptionError, match="which the arm.toml alone names: .* pass package_dirs"):
        loaded(robot.format(key))
    with pytest.raises(DescriptionError, match=f"two root links|{TOKEN}"):  # whoever names it himself opens it
        loaded(robot.format(key), package_dirs=[victim.home / "ros_ws" / "src"])


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


OBJECTS = ("sin", "math", "python.type(1)")
AS_TEXT = (
    *("@", "str(@)", "'%s' % @", "[@]", "str([1, dict(a=@)])", "'a'.join(map(str, [@]))", "dict(a=1)[@]", "[1][@]"),
    *("dict(a=1).get('b', @)", "xacro.fatal('see', @)", "'a' + str(dict(a=@))", "str(dict(a=@).items())"),
)


@pytest.mark.parametrize("thing", OBJECTS)
def test_no_object_of_the_program_becomes_text(thing: str, tmp_path: Path) -> None:
    """Its text would tell where it lies in memory."""
    path = tmp_path / "arm.xacro"
    for expression in AS_TEXT:
        written = expression.replace("@", thing)
        for text in (f"${{{written}}}", f"a ${{{written}}}"):
            path.write_text(f'<robot name="{text}" {XMLNS}/>')
            answer = read(path)
            assert "no value, nor text" in answer, text
            assert " at 0x" not in answer
            assert "<" not in answer.replace("<robot name=", "")


@pytest.mark.parametrize("asking", ["$(optenv CANARY no)", "$(env CANARY)", "$(optenv ${'CAN' + 'ARY'})"])
def test_a_variable_that_nobody_allows_counts_as_not_set(
    asking: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "arm.xacro"
    path.write_text(f'<robot name="r{asking}" {XMLNS}/>')

    def asked(env: tuple[str, ...]) -> tuple[str, list[str]]:
        try:
            text, noted, _ = expand_xacro(path, package_index(path), env_vars=env)
        except DescriptionError as error:
            return str(error), []
        return text, [f"{one.code}: {one.what}; {one.remedy}" for one in noted]

    monkeypatch.delenv("CANARY", raising=False)
    unset = asked(("OTHER",))
    monkeypatch.setenv("CANARY", TOKEN)
    assert asked(("OTHER",)) == unset
    text, noted = unset
    if "optenv" in asking:
        assert noted[0].startswith("environment-kept: it asks for the environment variable 'CANARY', and was answered")
        assert noted[0].endswith("pass env_vars=['CANARY'] if it may know it")
    else:
        assert "environment variable 'CANARY' is not set for it; pass env_vars=[...] if it may know it" in text
    text, noted = asked(("CANARY",))
    assert f'{TOKEN}"' in text
    assert not any("'CANARY'" in one for one in noted)


def test_who_may_allow_a_variable(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The caller, in Python and on the command line; no arm.toml."""
    monkeypatch.setenv("CANARY", TOKEN)
    path = write(tmp_path, as_xacro("").replace('name="tiny"', 'name="$(optenv CANARY arm)"'), "arm.xacro")
    assert load_arm(path, tip="tool0").name == "arm"
    assert load_arm(path, tip="tool0", env_vars="CANARY").name == TOKEN
    with pytest.raises(
        InputError, match="env_vars takes names of environment variables, without their values; got 'CANARY=1'"
    ):
        load_arm(path, env_vars=["CANARY=1"])
    toml = write(tmp_path, 'source = "arm.xacro"\ntip = "tool0"\nenv = ["CANARY"]', "arm.toml")
    with pytest.raises(DescriptionError, match="unknown entry 'env'|'env'"):
        load_arm(toml)
    assert run(["info", str(path), "--tip", "tool0"]) == 0
    told = capsys.readouterr().out
    assert "--env CANARY if it may know it" in " ".join(told.replace("│", " ").split())
    assert TOKEN not in told
    assert run(["info", str(path), "--tip", "tool0", "--env", "CANARY"]) == 0
    assert TOKEN in capsys.readouterr().out


def test_no_path_of_the_machine_gets_into_the_text(victim: Reader, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever is made of `$(find …)` and its like, a name or a part of one, tells the package; its files are found."""
    paths = "$(find secret)", "$(find arm)", "$(cwd)", "${xacro.abs_filename('x')}", "${abs_filename('.')[:40]}"
    meshes = (
        "file://$(find arm)/m.stl",
        "$(find arm)/m.stl",
        "${xacro.abs_filename('m.stl')}",
        "file://${abs_filename('m.stl')}",
    )
    drawn = "".join(f'<visual><geometry><mesh filename="{mesh}"/></geometry></visual>' for mesh in meshes)
    inside = f'<link name="a">{drawn}</link>' + "".join(f'<b c="{path}"/>' for path in paths)
    folder = victim.home / "arm"
    loads = "<b c=\"${xacro.load_yaml(xacro.abs_filename('a.yaml'))} ${xacro.load_yaml('$(find arm)/a.yaml')['a']}\"/>"
    text = f'<robot name="{"".join(paths)}" {XMLNS}>{inside}{loads}</robot>'
    lay(folder, {"package.xml": MANIFEST("arm"), "arm.xacro": text, "m.stl": "", "a.yaml": "a: here"})
    monkeypatch.chdir(victim.home)
    written = read(folder / "arm.xacro", victim.secret.parent)
    assert "reader" not in written
    assert written.count("here") == 2
    description = read_description(folder / "arm.xacro")
    assert [shape.mesh for shape in description.links["a"].visuals] == [folder / "m.stl"] * len(meshes)
