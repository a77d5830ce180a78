"""xacro without ROS: packages, arguments, includes, and every raw error in one line that helps."""

from __future__ import annotations

import os
from pathlib import Path
from xml.etree.ElementTree import canonicalize

import pytest
import xacro.substitution_args

from hostile.sandbox import XMLNS, Sandbox
from hostile.sandbox import place as place
from twistarm import load_arm
from twistarm.description.expansion.expand import expand_xacro, is_xacro
from twistarm.description.packages import package_index
from twistarm.support.errors import DescriptionError, InputError
from urdf_text import joint, write
from xacro_text import ARM, MANIFEST, as_xacro, lay


def package(folder: Path, name: str, files: dict[str, str] | None = None) -> Path:
    return lay(folder, {"package.xml": MANIFEST(name), **(files or {})})


FAILS = {
    '<xacro:include filename="$(find elsewhere)/a.xacro"/>': "package 'elsewhere' not found; searched",
    '<xacro:arg name="size" default="2"/><xacro:property name="m" value="$(arg ar_model)"/><link name="${m}"/>': (
        "has no default; the others have values: size ('2'); pass xacro_args={'ar_model': ...}"
    ),
    '<link name="$(arg name)"/><xacro:arg name="name" default="ur"/>': (
        "uses name above the line that gives it its default, 'ur', and xacro reads from top to bottom; pass "
        "xacro_args={'name': 'ur'}"
    ),
    "<link name=\"${xacro.arg('side')}\"/>": "uses side, which has no default; pass xacro_args={'side': ...}",
    "<gazebo><sim:thing/></gazebo>": "the prefix of 'sim:thing' is not declared; add xmlns:sim=\"…\" to <robot>",
    "<gazebo xmlns:p='urn:x' xmlns:q='urn:x' p:a='1' q:a='2'/>": "an attribute is given twice, by two prefixes",
    "<robot": "not well-formed XML",
    "<xacro:arm_of_mine/>": "xacro cannot expand it: unknown macro name: xacro:arm_of_mine",
    '<link name="${nothing}"/>': "name 'nothing' is not defined",
    '<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>': "refers to itself without end",
    '<xacro:arg name="h"/>': "a <xacro:arg> has no default=",
    '<xacro:macro name="m" params="a"><link name="${a}"/></xacro:macro><xacro:m a="1" sim="2"/>': (
        "macro 'm': xacro cannot expand it: Invalid parameter \"sim\": the macro has none of that name; add"
    ),
    '<property name="h" value="1"/><link name="l${h}"/>': 'write <xacro:property name="h" …>',
    "${xacro.fatal('wrong', 'arm')}": "xacro cannot expand it: wrong arm when",
    '<link name="${a"/>': "xacro cannot expand it: invalid expression: ${a",
}
MACROS = '<xacro:macro name="arm"><link name="l"/></xacro:macro>'
WHOLE = {
    ARM.replace("</robot>", '<xacro:property name="a" value="1"/></robot>'): "add xmlns:xacro=",
    f'<robot name="m" {XMLNS}>{MACROS}</robot>': "it defines macros ('arm') and calls none that makes one",
}


@pytest.mark.parametrize(
    ("text", "message"), [*((as_xacro(inside), FAILS[inside]) for inside in FAILS), *WHOLE.items()]
)
def test_fails_in_one_line(text: str, message: str, tmp_path: Path) -> None:
    path = write(tmp_path, text, "arm.urdf.xacro")
    with pytest.raises(DescriptionError) as caught:
        load_arm(path)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    assert "arm.urdf.xacro" in str(caught.value)


PREFIXED = {
    "an attribute before its namesake": '<link cad:name="x" name="l"/>',
    "one of another namespace": '<link name="l" cad:name="x" sim:name="y"/>',
    "a made element with attributes": '<xacro:element xacro:name="link" name="l"/>',
    "a made element of a prefix": '<xacro:element xacro:name="cad:part" name="p" xacro:on="1"/>',
    "a made attribute": '<link><xacro:attribute name="name" value="l"/></link>',
    "a made attribute of a prefix": '<link name="l"><xacro:attribute name="cad:name" value="x"/></link>',
    "a namespace declared inside": '<link xmlns:own="urn:own" own:name="x" name="l"/>',
    "one of a macro": '<xacro:macro name="m" xmlns:o="urn:o"><link o:name="x" name="l"/></xacro:macro><xacro:m/>',
}


@pytest.mark.parametrize("case", PREFIXED)
def test_prefixed_names_come_out_as_from_xacro(case: str, tmp_path: Path) -> None:
    text = f'<robot name="r" {XMLNS} xmlns:cad="urn:cad" xmlns:sim="urn:sim">{PREFIXED[case]}</robot>'
    path = write(tmp_path, text, "arm.xacro")
    ours = expand_xacro(path, package_index(path)).text
    assert canonicalize(ours) == canonicalize(xacro.process_file(str(path)).documentElement.toxml())


def test_an_argument_is_missed_where_it_is_used(tmp_path: Path) -> None:
    """The file that wants it may be one that the description includes."""
    write(tmp_path, f'<robot {XMLNS}><link name="$(arg side)"/></robot>', "part.xacro")
    include = '<xacro:include filename="part.xacro"/>'
    path = write(tmp_path, as_xacro(f'{include}<xacro:arg name="side" default="left"/>'), "arm.xacro")
    late = "argument side: part.xacro uses side above the line that gives it its default, 'left'"
    with pytest.raises(DescriptionError, match=late):
        load_arm(path)
    path = write(tmp_path, as_xacro(include), "arm.xacro")
    with pytest.raises(DescriptionError, match="missing xacro argument side: part.xacro uses side"):
        load_arm(path)


EMPTY = '<xacro:arg name="dof" default=""/><xacro:arg name="kind" default="gen3"/>'
PATHS = {
    "an empty argument": ("arms/$(arg dof)dof/arm.xacro", "'dof' in {}, but '6dof', '7dof'", "dof (''); pass", "dof"),
    "a wrong file": (
        "arms/7dof/$(arg kind).xacro",
        "'gen3.xacro' in {}/7dof, but 'arm.xacro'",
        "kind ('gen3')",
        "kind",
    ),
}


@pytest.mark.parametrize("case", PATHS)
def test_a_path_that_ends_nowhere_names_the_argument_to_pass(case: str, tmp_path: Path) -> None:
    name, there, argument, wanted = PATHS[case]
    for folder in ("6dof", "7dof"):
        (tmp_path / "arms" / folder).mkdir(parents=True)
        write(tmp_path / "arms" / folder, "<robot/>", "arm.xacro")
    path = write(tmp_path, as_xacro(f'{EMPTY}<xacro:include filename="{name}"/>'), "arm.xacro")
    with pytest.raises(DescriptionError) as caught:
        load_arm(path)
    assert f"there is no {there.format(tmp_path / 'arms')}; it may come from the xacro argument {argument}" in str(
        caught.value
    )
    assert str(caught.value).endswith(f"pass xacro_args={{'{wanted}': ...}}")


@pytest.mark.parametrize("encoding", ["latin-1", "utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("declared", ["", ' encoding="iso-8859-1"', ' encoding="utf-8"'])
def test_files_of_any_origin(encoding: str, declared: str, tmp_path: Path) -> None:
    part = f'<?xml version="1.0"{declared}?>\r\n<robot {XMLNS}><!-- für Möbel -->\r\n<link name="stück"/></robot>'
    (tmp_path / "part.xacro").write_bytes(part.encode(encoding))
    inside = '<xacro:include filename="part.xacro"/><a b="${xacro.load_yaml(\'a.yaml\').größe}"/>'
    text = as_xacro(inside).replace('<?xml version="1.0"?>', f'<?xml version="1.0"{declared}?>\r\n<!-- für -->')
    (tmp_path / "arm.xacro").write_bytes(text.encode(encoding))
    (tmp_path / "a.yaml").write_bytes("größe: 3\r\n".encode(encoding))
    path = tmp_path / "arm.xacro"
    expanded = expand_xacro(path, package_index(path)).text
    assert 'name="stück"' in expanded
    assert 'b="3"' in expanded


def test_units_and_dots_of_yaml(place: Sandbox) -> None:
    yaml = "joint: {limit: {upper: !degrees 180, lower: !radians -pi/2, reach: !millimeters 3*100}, list: [{a: 1}]}"
    text = place.expand(
        '<xacro:property name="c" value="${xacro.load_yaml(\'a.yaml\')}"/>'
        "<a b=\"${c.joint.limit.upper - pi} ${c['joint']['limit']['lower'] + pi/2} ${c.joint.limit.reach}"
        ' ${c.joint.list[0].a}"/>',
        {"a.yaml": yaml},
    )
    assert '<a b="0.0 0.0 0.3 1"/>' in text


def test_deeply_nested_yaml_is_said_to_be_that(place: Sandbox) -> None:
    message = place.refuse("<link name=\"${xacro.load_yaml('a.yaml')}\"/>", {"a.yaml": "[" * 2000 + "]" * 2000})
    assert "the YAML is nested too deeply (in ${xacro.load_yaml('a.yaml')}); write it flatter" in message


PARAMETERS = [
    ("a", {"a": "1"}),
    ("a:=2", {"a": "2"}),
    ("a:='x y' b=3", {"a": "x y", "b": "3"}),
    ("a:=${1 + 1} b:=^|${2 * 2}", {"a": "2", "b": "4"}),
    ("a:=${1 + 1}_${2 + 2}", {"a": "2_4"}),
    ("a:=$(arg side)", {"a": "left"}),
    ("a:=''", {"a": ""}),
]


@pytest.mark.parametrize(("params", "values"), PARAMETERS)
def test_defaults_of_parameters_are_read_as_by_xacro(params: str, values: dict[str, str], place: Sandbox) -> None:
    shown = "|".join(f"${{{name}}}" for name in values)
    call = '<xacro:m a="1"/>' if params == "a" else "<xacro:m/>"
    inside = (
        '<xacro:arg name="side" default="left"/>'
        f'<xacro:macro name="m" params="{params}"><x y="{shown}"/></xacro:macro>{call}'
    )
    assert f'<x y="{"|".join(values.values())}"/>' in place.expand(inside)
    plain = xacro.process_file(str(place.folder / "arm" / "arm.xacro"), verbosity=0).toxml()
    assert f'<x y="{"|".join(values.values())}"/>' in plain


def test_backslashes_and_two_slashes_lead_where_slashes_do(tmp_path: Path) -> None:
    package(tmp_path / "parts", "parts", {"a.xacro": f'<robot {XMLNS}><link name="one"/></robot>'})
    for name in (r"..\parts\a.xacro", "$(find parts)//a.xacro", r"$(find parts)\a.xacro"):
        own = package(tmp_path, "own", {"arm.xacro": as_xacro(f'<xacro:include filename="{name}"/>')})
        (own / "arm").mkdir(exist_ok=True)
        path = (own / "arm.xacro").rename(own / "arm" / "arm.xacro")
        assert 'name="one"' in expand_xacro(path, package_index(path))[0]


def test_a_package_that_is_nearly_named_is_offered(tmp_path: Path) -> None:
    package(tmp_path / "parts", "my_parts")
    path = write(tmp_path, as_xacro('<xacro:include filename="$(find My_Parts)/a.xacro"/>'), "arm.xacro")
    with pytest.raises(DescriptionError, match="correct the name; closest: 'my_parts', or pass package_dirs="):
        load_arm(path)


def test_an_unknown_package_matters_only_where_a_file_of_it_is_opened(tmp_path: Path) -> None:
    path = write(tmp_path, as_xacro("<gazebo><a>$(find absent)/config.yaml</a></gazebo>"), "arm.xacro")
    arm = load_arm(path)
    assert [finding.code for finding in arm.findings] == ["package-not-found"]
    assert "$(find absent): package not found" in arm.findings[0].what


def test_packages_are_found_by_the_name_in_package_xml(tmp_path: Path) -> None:
    package(
        tmp_path / "ws" / "folder_of_another_name",
        "my_parts",
        {"p.xacro": f"<robot {XMLNS}><link name='extra'/></robot>"},
    )
    include = '<xacro:include filename="$(find my_parts)/p.xacro"/>'
    extra = joint("f", "upper", "extra", kind="fixed")
    text = as_xacro(include).replace("</robot>", f"{extra}</robot>")
    beside = write(package(tmp_path / "ws" / "arm", "arm"), text, "arm.xacro")
    assert "extra" in load_arm(beside).frame_names
    far = write(package(tmp_path / "a" / "b" / "c" / "d" / "e" / "f" / "g" / "h" / "i", "far"), text, "arm.xacro")
    with pytest.raises(DescriptionError, match="package 'my_parts' not found"):
        load_arm(far)
    assert "extra" in load_arm(far, package_dirs=[tmp_path / "ws"]).frame_names


@pytest.mark.parametrize("variable", ["ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"])
def test_packages_of_the_environment(variable: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    inside = tmp_path / "prefix" / ("share/x" if variable == "AMENT_PREFIX_PATH" else "x")
    folder = package(inside, "named")
    monkeypatch.setenv(variable, os.pathsep.join(["nowhere", str(tmp_path / "prefix")]))
    (tmp_path / "file" / "deep").mkdir(parents=True)
    index = package_index(tmp_path / "file" / "deep" / "arm.urdf")
    assert index.find("named") == folder
    assert index.find("other") is None


def test_arguments_given_defaulted_and_misspelt(tmp_path: Path) -> None:
    text = as_xacro('<xacro:arg name="deck" default="one"/><xacro:property name="d" value="$(arg deck)"/>').replace(
        "</robot>", f'<link name="${{d}}"/>{joint("f", "base_link", "${d}", kind="fixed")}</robot>'
    )
    path = write(tmp_path, text, "arm.xacro")
    assert "one" in load_arm(path).frame_names
    assert "two" in load_arm(path, xacro_args={"deck": "two"}).frame_names
    with pytest.raises(InputError, match="no xacro argument 'dek'; closest: 'deck' \\(its arguments: deck\\)"):
        load_arm(path, xacro_args={"dek": "two"})
    with pytest.raises(DescriptionError, match="it is plain URDF and takes no xacro arguments"):
        load_arm(write(tmp_path, ARM), xacro_args={"deck": 1})


def test_what_counts_as_xacro(tmp_path: Path) -> None:
    assert is_xacro(write(tmp_path, as_xacro('<xacro:property name="a" value="1"/>'), "hidden.urdf"))
    assert not is_xacro(write(tmp_path, as_xacro(""), "only_the_namespace.urdf"))
    assert not is_xacro(write(tmp_path, ARM, "plain.urdf"))
    late = as_xacro('<xacro:property name="a" value="1"/>').replace("<robot", f"<!--{' ' * 8000}--><robot")
    assert is_xacro(write(tmp_path, late, "late.urdf"))


def test_package_dirs_must_exist(tmp_path: Path) -> None:
    path = write(tmp_path, ARM)
    with pytest.raises(InputError, match="package_dirs: .*nowhere is not a folder"):
        load_arm(path, package_dirs=[tmp_path / "nowhere"])
