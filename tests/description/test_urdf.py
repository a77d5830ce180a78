"""URDF into the tree: what is refused, in which words; what is repaired, and that it is said."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pinocchio
import pytest

from twistarm import diagnose, load_arm
from twistarm.description.coupling import resolve_couplings
from twistarm.description.urdf import read_description
from twistarm.support.errors import DescriptionError
from urdf_text import joint, robot, two_joints, write

REFUSED = {
    "not XML": ("this is no robot", "not well-formed XML: syntax error: line 1, column 0; is it a URDF or xacro file?"),
    "not a robot": ("<sdf/>", "its root element is <sdf>, not <robot>"),
    "no links": ("<robot name='r'/>", "it has no links; is it a robot description?"),
    "two roots": (
        robot(joint("a", "base_link", "upper")),
        "2 root links: 'base_link', 'tool0'; a robot has one: join them with fixed joints",
    ),
    "a cycle": (
        robot(
            joint("a", "base_link", "upper"),
            joint("b", "tool0", "tip"),
            joint("c", "tip", "tool0"),
            links=("base_link", "upper", "tool0", "tip"),
        ),
        "the joints of 'tool0', 'tip' form a cycle; a URDF is a tree: remove one of its joints",
    ),
    "all in a cycle": (
        robot(joint("b", "tool0", "tip"), joint("c", "tip", "tool0"), links=("tool0", "tip")),
        "the joints of 'tool0', 'tip' form a cycle",
    ),
    "an undefined link": (
        robot(joint("a", "base_link", "uper"), joint("b", "upper", "tool0")),
        "arm.urdf:2: joint 'a': its child link 'uper' is not defined; define it, or correct the name; closest: 'upper'",
    ),
    "a link with two parents": (
        robot(joint("a", "base_link", "upper"), joint("b", "upper", "tool0"), joint("c", "base_link", "tool0")),
        "joint 'c': link 'tool0' has two parents: joint 'b' moves it too; remove one joint",
    ),
    "a duplicate link": (
        robot(joint("a", "base_link", "upper"), links=("base_link", "upper", "upper")),
        "link 'upper': the name is used by 2 links; rename one",
    ),
    "a duplicate joint": (
        robot(joint("a", "base_link", "upper"), joint("a", "upper", "tool0")),
        "joint 'a': the name is used by 2 joints; rename one",
    ),
    "a nameless joint": (robot(joint("", "base_link", "upper")), "it has no name; every link and joint needs one"),
    "a zero axis on a moving joint": (
        two_joints(inside='<axis xyz="0 0 0"/>'),
        "joint 'a': a moving joint with a zero axis; give the axis it moves along or about",
    ),
    "an axis that is none": (two_joints(inside='<axis xyz="0 0 z"/>'), "joint 'a': its <axis> is malformed"),
    "an origin of two numbers": (two_joints(xyz="0 0"), "joint 'a': its <origin> is malformed: 3 finite numbers"),
    "a limit in words": (
        two_joints(inside='<limit lower="-pi/2" upper="1" velocity="1" effort="1"/>'),
        "joint 'a': its limit lower='-pi/2' is not a number; write it in digits, with a point",
    ),
    "a limit with a comma": (
        two_joints(inside='<limit lower="-1,57" upper="1" velocity="1" effort="1"/>'),
        "its limit lower='-1,57' is not a number",
    ),
    "a limit that is NaN": (
        two_joints(inside='<limit lower="nan" upper="1" velocity="1" effort="1"/>'),
        "its limit lower='nan' is not a number",
    ),
    "swapped limits": (
        two_joints(inside='<limit lower="1" upper="-1" velocity="1" effort="1"/>'),
        "joint 'a': its limits are swapped: lower 1 > upper -1; exchange them",
    ),
    "one bound beyond 0": (
        two_joints(inside='<limit lower="1" velocity="1" effort="1"/>'),
        "joint 'a': its limits are swapped: lower 1 > upper 0; upper is not written, which is 0; write both",
    ),
    "a soft limit in words": (
        two_joints(inside='<safety_controller soft_lower_limit="low" k_velocity="1"/>'),
        "joint 'a': its limit soft_lower_limit='low' is not a number",
    ),
    "an unknown joint type": (
        robot(joint("a", "base_link", "upper", kind="hinge"), joint("b", "upper", "tool0")),
        "joint 'a': joint type 'hinge' is unknown; URDF has revolute, continuous, prismatic, fixed, planar, floating",
    ),
    "a bound beyond all places": (
        two_joints(inside='<limit lower="inf" velocity="1" effort="1"/>'),
        "joint 'a': its limits lower inf, upper 0 leave no place to stand; give finite bounds",
    ),
    "a mimic of nothing": (
        two_joints(inside='<mimic joint="bb"/>'),
        "arm.urdf:2: joint 'a': it mimics 'bb', which does not exist; correct the name; closest: 'b'",
    ),
    "mimics in a circle": (
        robot(
            joint("a", "base_link", "upper", inside='<mimic joint="b"/>'),
            joint("b", "upper", "tool0", inside='<mimic joint="a"/>'),
        ),
        "joints mimic each other in a circle: a, b",
    ),
    "a mimic of a planar joint": (
        robot(
            joint("a", "base_link", "upper"),
            joint("b", "upper", "tool0", inside='<mimic joint="p"/>'),
            joint("p", "base_link", "pad", kind="planar"),
            links=("base_link", "upper", "tool0", "pad"),
        ),
        "arm.urdf:2: joint 'b': it mimics 'p', which is planar: its motion is not one number; let it mimic another",
    ),
    "an origin out of this world": (
        two_joints(xyz="1e200 0 0"),
        "its <origin> is malformed: 3 finite numbers expected",
    ),
    "xacro without its namespace": (
        two_joints(inside="<xacro:thing/>"),
        "the prefix of 'xacro:thing' is not declared; add xmlns:xacro=",
    ),
    "a floating joint in the chain": (
        robot(joint("a", "base_link", "upper", kind="floating"), joint("b", "upper", "tool0")),
        "arm.urdf:2: joint 'a': between 'base_link' and 'tool0' it is floating: its motion is not one number per joint",
    ),
    "nothing moves": (
        robot(joint("a", "base_link", "upper", kind="fixed"), joint("b", "upper", "tool0", kind="fixed")),
        "no joint moves between base 'base_link' and tip 'tool0'",
    ),
    "a document type": (
        '<!DOCTYPE robot [<!ENTITY e "x">]><robot/>',
        "a document type (<!DOCTYPE robot>) is not allowed",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused_in_one_line(case: str, tmp_path: Path) -> None:
    text, message = REFUSED[case]
    path = write(tmp_path, text)
    with pytest.raises(DescriptionError) as caught:
        load_arm(path, tip="tool0")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    assert "arm.urdf" in str(caught.value)


def test_a_chain_too_deep_is_refused_before_pinocchio_sees_it(tmp_path: Path) -> None:
    links = tuple(f"l{i}" for i in range(1500))
    joints = [joint(f"j{i}", links[i], links[i + 1]) for i in range(len(links) - 1)]
    with pytest.raises(DescriptionError, match="a chain of more than 1000 links; is it generated"):
        load_arm(write(tmp_path, robot(*joints, links=links)))


def test_elements_nested_without_end_are_refused(tmp_path: Path) -> None:
    text = two_joints(inside="<limit>" + "<a>" * 5000 + "</a>" * 5000 + "</limit>")
    with pytest.raises(DescriptionError, match="arm.urdf:2: elements are nested more than 100 deep"):
        load_arm(write(tmp_path, text))


def findings(path: Path) -> dict[str, str]:
    return {finding.code: str(finding) for finding in read_description(path).findings}


def test_an_incomplete_limit_is_unbounded_and_said(tmp_path: Path) -> None:
    path = write(tmp_path, two_joints(inside='<limit velocity="1" effort="1"/>'))
    arm = load_arm(path)
    assert np.isneginf(arm.limits.lower[0])
    assert np.isposinf(arm.limits.upper[0])
    assert (
        "joint 'a': a <limit> without lower and upper; taken as unbounded both ways"
        in findings(path)["limit-incomplete"]
    )


@pytest.mark.parametrize("given", ['lower="-1"', 'upper="0.7"', 'lower="0"', 'upper="0"'])
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_one_bound_alone_has_0_for_the_other(given: str, kind: str, tmp_path: Path) -> None:
    path = write(tmp_path, two_joints(kind=kind, inside=f'<limit {given} velocity="1" effort="1"/>'))
    model = pinocchio.buildModelFromXML(path.read_text())
    limits = load_arm(path).limits
    assert (limits.lower[0], limits.upper[0]) == (model.lowerPositionLimit[0], model.upperPositionLimit[0])
    absent = "upper" if "lower" in given else "lower"
    assert f"a <limit> without {absent}; URDF reads it as 0" in findings(path)["limit-incomplete"]


def test_zero_and_negative_rates_mean_not_given(tmp_path: Path) -> None:
    path = write(tmp_path, two_joints(inside='<limit lower="-1" upper="1" velocity="0" effort="-1"/>'))
    arm = load_arm(path)
    assert np.isinf(arm.limits.velocity[0])
    assert np.isinf(arm.limits.effort[0])
    assert arm.limits.velocity[1] == 2.0
    said = findings(path)
    assert "velocity limit absent or 0 on a: taken as not given" in said["velocity-not-given"]
    assert "effort limit -1 on a: taken as not given" in said["effort-not-given"]


def test_a_long_axis_is_normalised_and_said(tmp_path: Path) -> None:
    path = write(tmp_path, two_joints(inside='<axis xyz="0 0 5"/>'))
    assert np.allclose(load_arm(path).screws[3:, 0], [0, 0, 1])
    assert "its axis 0 0 5 has length 5; only the direction counts" in findings(path)["axis-not-unit"]


def test_an_origin_in_degrees_is_hinted_at(tmp_path: Path) -> None:
    said = findings(write(tmp_path, two_joints(rpy="90 0 -45")))["origin-looks-like-degrees"]
    assert 'rpy="90 0 -45" rad goes beyond a whole turn' in said
    assert 'write rpy="1.5708 0 -0.785398"' in said


def test_a_zero_axis_on_a_fixed_joint_is_ignored(tmp_path: Path) -> None:
    fixed = joint("f", "upper", "tool0", kind="fixed", inside='<axis xyz="0 0 0"/>')
    arm = load_arm(write(tmp_path, robot(joint("a", "base_link", "upper"), fixed)))
    assert arm.joint_names == ("a",)
    assert arm.findings == ()


def test_a_mass_that_is_no_number_is_said(tmp_path: Path) -> None:
    inertial = '<inertial><mass value="1kg"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    text = two_joints().replace('<link name="upper"/>', f'<link name="upper">{inertial}</link>')
    assert "link 'upper': its <inertial> is malformed" in findings(write(tmp_path, text))["inertial-unusable"]


def test_missing_meshes_are_one_warning(tmp_path: Path) -> None:
    visual = '<visual><geometry><mesh filename="package://nowhere/{}.stl"/></geometry></visual>'
    text = two_joints().replace(
        '<link name="upper"/>', f'<link name="upper">{visual.format(1)}{visual.format(2)}</link>'
    )
    said = findings(write(tmp_path, text))
    assert "2 mesh files not found: 'package://nowhere/1.stl', 'package://nowhere/2.stl'" in said["mesh-missing"]


def test_meshes_are_found_by_every_kind_of_uri(tmp_path: Path) -> None:
    (tmp_path / "pkg" / "meshes").mkdir(parents=True)
    mesh = tmp_path / "pkg" / "meshes" / "a b.stl"
    mesh.write_bytes(b"solid\nendsolid\n")
    (tmp_path / "pkg" / "package.xml").write_text("<package><name>my_arm</name></package>")
    uris = ["package://my_arm/meshes/a%20b.stl", "$(find my_arm)/meshes/a b.stl", "../meshes/a b.stl", f"file://{mesh}"]
    shapes = "".join(f'<visual><geometry><mesh filename="{uri}"/></geometry></visual>' for uri in uris)
    (tmp_path / "pkg" / "urdf").mkdir()
    text = two_joints().replace('<link name="upper"/>', f'<link name="upper">{shapes}</link>')
    description = read_description(write(tmp_path / "pkg" / "urdf", text))
    assert [shape.mesh for shape in description.links["upper"].visuals] == [mesh] * 4


@pytest.mark.parametrize("encoding", ["utf-8-sig", "latin-1", "utf-16"])
def test_encodings_line_ends_and_names(encoding: str, tmp_path: Path) -> None:
    text = robot(
        joint("Schulter/ä 1", "base_link", "Schulter/ä 1"),
        joint("b", "Schulter/ä 1", "tool0"),
        links=("base_link", "Schulter/ä 1", "tool0"),
    ).replace(">", ">\r\n")
    path = tmp_path / "arm.urdf"
    path.write_bytes(text.encode(encoding))
    arm = load_arm(path)
    assert arm.joint_names == ("Schulter/ä 1", "b")
    assert "Schulter/ä 1" in arm.poses(np.zeros(2))


def test_a_long_line_of_mimics_is_followed_to_its_end(tmp_path: Path) -> None:
    links = tuple(f"l{i}" for i in range(900))
    text = '<mimic joint="j{}"/>'
    joints = [joint(f"j{i}", links[i], links[i + 1], inside=text.format(i + 1)) for i in range(898)]
    path = write(tmp_path, robot(*joints, joint("j898", links[898], links[899]), links=links))
    couplings = resolve_couplings(read_description(path), {})
    assert {(affine.master, affine.multiplier) for affine in couplings.values()} == {("j898", 1.0)}
    with pytest.raises(DescriptionError, match="899 moving joints; at most 150"):
        load_arm(path, tip="l899")


def test_a_planar_joint_beside_the_chain_stands_still(tmp_path: Path) -> None:
    parts = joint("a", "base_link", "upper"), joint("b", "upper", "tool0"), joint("p", "upper", "pad", kind="planar")
    arm = load_arm(write(tmp_path, robot(*parts, links=("base_link", "upper", "tool0", "pad"))))
    assert arm.joint_names == ("a", "b")
    assert np.allclose(arm.pose([0.3, 0], "pad")[:3, 3], [0, 0, 1.0])


def test_every_unusable_joint_is_reported_at_once(tmp_path: Path) -> None:
    text = robot(
        joint("a", "base_link", "upper", inside='<axis xyz="0 0 0"/>'),
        joint("b", "upper", "tool0", inside='<limit lower="2" upper="1" velocity="1" effort="1"/>'),
    )
    with pytest.raises(DescriptionError, match="zero axis.*and 1 more: twistarm doctor lists them") as refused:
        read_description(write(tmp_path, text))
    assert [finding.code for finding in refused.value.findings] == ["axis-zero", "limits-swapped"]
    assert [finding.place.name for finding in refused.value.findings] == ["a", "b"]


FOREIGN = {
    "on a link": two_joints().replace('<link name="upper"/>', '<link name="upper" foo:bar="1"/>'),
    "on the robot": two_joints().replace("<robot ", '<robot foo:bar="1" '),
    "a namespace of its own": two_joints().replace("<robot ", '<robot xmlns="http://example.org/robot" '),
    "a prefix in the XML's own way": two_joints().replace("<robot ", '<robot xmlns:foo="" '),
    "an element among inertias": two_joints().replace(
        '<link name="upper"/>',
        '<link name="upper"><inertial><foo:m/><mass value="2" foo:u="kg"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>',
    ),
    "an element in an origin": two_joints().replace('rpy="0 0 0"/>', 'rpy="0 0 0" foo:x="1"><foo:y/></origin>'),
}


@pytest.mark.parametrize("where", FOREIGN)
def test_prefixes_that_nobody_declared_change_nothing(where: str, tmp_path: Path) -> None:
    arm, plain = load_arm(write(tmp_path, FOREIGN[where])), load_arm(write(tmp_path, two_joints(), "plain.urdf"))
    assert np.array_equal(arm.screws, plain.screws)
    assert np.array_equal(arm.fk([0.1, 0.2]), plain.fk([0.1, 0.2]))
    assert "error" not in {one.severity for one in diagnose(arm)}
    assert "error" not in {one.severity for one in diagnose(tmp_path / "arm.urdf")}
    mass = sum(body.mass for body in arm.pinocchio.model.inertias)
    assert mass == (2.0 if "inertias" in where else 0.0)


def test_a_file_beyond_all_descriptions_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    with path.open("wb") as file:
        file.truncate(3 << 30)
    with pytest.raises(DescriptionError) as caught:
        load_arm(path)
    assert str(caught.value) == (
        f"{path}: it has 3,221,225,472 bytes; at most 20,000,000 are read; is it the right file?"
    )
    assert [one.code for one in caught.value.findings] == ["file-too-large"]


def test_thousands_of_mistakes_take_no_longer_than_thousands_of_names(tmp_path: Path) -> None:
    n = 3000
    joints = (joint(f"j{i}", "base", f"x{i}", "fixed") for i in range(n))
    path = write(tmp_path, robot(*joints, links=("base", *(f"l{i}" for i in range(n)))))
    start = time.process_time()
    with pytest.raises(DescriptionError, match="closest: 'l0'.*more: twistarm doctor lists them"):
        load_arm(path)
    assert time.process_time() - start < 6.0


def test_what_is_not_ours_is_left_out_in_no_time_however_much_it_is(tmp_path: Path) -> None:
    path = write(tmp_path, two_joints().replace("</robot>", '<gazebo x="1"/>' * 120_000 + "</robot>"))
    start = time.process_time()
    assert load_arm(path).n == 2
    assert time.process_time() - start < 3.0
    path = write(tmp_path, two_joints().replace("</robot>", '<gazebo x="1"/>' * 130_000 + "</robot>"))
    with pytest.raises(DescriptionError, match="more than 250,000 elements and attributes; leave out"):
        load_arm(path)


def test_a_robot_without_a_name_takes_the_files(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, two_joints().replace(' name="tiny"', "")))
    assert arm.name == "arm"
    assert [finding.code for finding in arm.findings] == ["robot-unnamed"]
