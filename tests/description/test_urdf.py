"""URDF of every version into the tree: what is refused; what is repaired, and that it is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio
import pytest
from scipy.spatial.transform import Rotation

from twistarm import crosscheck, diagnose, load_arm
from twistarm.description.findings import Finding
from twistarm.description.urdf import read_description
from twistarm.support.errors import DescriptionError
from urdf_text import joint, robot, two_joints, write

LIMIT = '<limit {} velocity="1" effort="1"/>'
REFUSED = {
    "all in a cycle": (
        robot(joint("b", "tool0", "tip"), joint("c", "tip", "tool0"), links=("tool0", "tip")),
        "the joints of 'tool0', 'tip' form a cycle",
    ),
    "an undefined link": (robot(joint("a", "base_link", "uper"), joint("b", "upper", "tool0")), "closest: 'upper'"),
    "swapped limits": (two_joints(inside=LIMIT.format('lower="1" upper="-1"')), "lower 1 > upper -1; exchange them"),
    "one bound beyond 0": (two_joints(inside=LIMIT.format('lower="1"')), "upper is missing, which counts as 0"),
    "a soft limit in words": (
        two_joints(inside='<safety_controller soft_lower_limit="low" k_velocity="1"/>'),
        "soft_lower_limit",
    ),
    "a bound beyond all places": (two_joints(inside=LIMIT.format('lower="inf"')), "allow no position"),
    "a mimic of nothing": (two_joints(inside='<mimic joint="bb"/>'), "arm.urdf:2: joint 'a': it mimics 'bb'"),
    "an origin out of this world": (two_joints(xyz="1e200 0 0"), "its <origin> is malformed"),
    "elements without end": (
        two_joints(inside="<limit>" + "<a>" * 5000 + "</a>" * 5000 + "</limit>"),
        "arm.urdf:2: elements are nested more than 100 deep",
    ),
    "a missing end tag": (two_joints().replace("</robot>", ""), "the file ends inside <robot>"),
    "another kind of file": ("print(1 & 2)", "is it a URDF, xacro or MJCF file"),
    "xacro without its namespace": (two_joints(inside="<xacro:thing/>"), "xmlns:xacro="),
}
"""What `finding_cases` has no input for: another way into a finding, or a hint that must name the right thing."""


@pytest.mark.parametrize("case", REFUSED)
def test_refused_in_one_line(case: str, tmp_path: Path) -> None:
    text, telling = REFUSED[case]
    with pytest.raises(DescriptionError) as caught:
        load_arm(write(tmp_path, text), tip="tool0")
    assert telling in str(caught.value)
    assert "arm.urdf" in str(caught.value)


def findings(path: Path) -> dict[str, Finding]:
    return {finding.code: finding for finding in read_description(path).findings}


def test_what_is_not_given_is_unbounded_and_an_axis_normalised(tmp_path: Path) -> None:
    text = two_joints(inside='<axis xyz="0 0 5"/><limit velocity="0" effort="-1"/>')
    arm = load_arm(write(tmp_path, text))
    limits = arm.limits
    assert [limits.lower[0], limits.upper[0]] == [-np.inf, np.inf]
    assert [limits.velocity[0], limits.effort[0], limits.velocity[1]] == [np.inf, np.inf, 2.0]
    assert np.allclose(arm.screws[3:, 0], [0, 0, 1])


@pytest.mark.parametrize("given", ['lower="-1"', 'upper="0.7"', 'lower="0"', 'upper="0"'])
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_one_bound_alone_has_0_for_the_other(given: str, kind: str, tmp_path: Path) -> None:
    path = write(tmp_path, two_joints(kind=kind, inside=LIMIT.format(given)))
    model = pinocchio.buildModelFromXML(path.read_text())
    limits = load_arm(path).limits
    assert (limits.lower[0], limits.upper[0]) == (model.lowerPositionLimit[0], model.upperPositionLimit[0])
    assert "limit-incomplete" in findings(path)


def test_a_zero_axis_on_a_fixed_joint_is_ignored(tmp_path: Path) -> None:
    fixed = joint("f", "upper", "tool0", kind="fixed", inside='<axis xyz="0 0 0"/>')
    arm = load_arm(write(tmp_path, robot(joint("a", "base_link", "upper"), fixed)))
    assert arm.joint_names == ("a",)
    assert arm.findings == ()


def test_every_unusable_joint_is_reported_at_once(tmp_path: Path) -> None:
    text = robot(
        joint("a", "base_link", "upper", inside='<axis xyz="0 0 0"/>'),
        joint("b", "upper", "tool0", inside='<limit lower="2" upper="1" velocity="1" effort="1"/>'),
    )
    with pytest.raises(DescriptionError, match="zero axis.*and 1 more: twistarm doctor lists them") as refused:
        read_description(write(tmp_path, text))
    assert [finding.code for finding in refused.value.findings] == ["number-malformed", "limits-swapped"]
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


UNREAD = {
    '<origin xzy="0 0 1"/>': "xzy",
    '<origin quat_xyzw="0 0 0 1"/>': "quat_xyzw",
    '<orgin xyz="0 0 1"/>': "'origin'",
    "<axis/>": "xyz",
    '<Axis xyz="0 1 0"/>': "<Axis>",
    '<limit lower="0" upper="1" velocity="1" efort="1"/>': "'effort'",
    '<child link="upper"/>': "<child>",
}
"""The culprit, or the word that is meant."""


@pytest.mark.parametrize("inside", UNREAD)
def test_what_nobody_reads_is_said(inside: str, tmp_path: Path) -> None:
    text = robot(joint("a", "base_link", "upper", inside=inside), joint("b", "upper", "tool0"))
    noted = [one for one in read_description(write(tmp_path, text)).findings if one.code == "word-unread"]
    assert any(UNREAD[inside] in f"{one.what} {one.remedy}" for one in noted)


@pytest.mark.parametrize("inside", ['<dynamics damping="1"/>', "<physics/>", '<safety_controller k_velocity="1"/>'])
def test_other_tools_words_are_left_alone(inside: str, tmp_path: Path) -> None:
    text = robot(joint("a", "base_link", "upper", inside=inside), joint("b", "upper", "tool0"))
    assert read_description(write(tmp_path, text)).findings == ()


QUATERNION = "0.2 -0.4 0.5 1.2"


def text_of(version: str, origin: str, limit: str = "") -> str:
    """The two-joint arm with another origin of joint a, and more in its limit."""
    text = two_joints().replace('<origin xyz="0 0 0.5" rpy="0 0 0"/>', f"<origin {origin}/>", 1)
    text = text.replace('effort="3"', f'effort="3" {limit}', 1)
    return text.replace("<robot ", f'<robot version="{version}" ') if version else text


def by_pinocchio(text: str) -> np.ndarray:
    model = pinocchio.buildModelFromXML(text)
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, pinocchio.neutral(model))
    home: np.ndarray = data.oMf[model.getFrameId("tool0", pinocchio.FrameType.BODY)].homogeneous
    return home


def told(path: Path, code: str) -> list[str]:
    return [finding.what for finding in read_description(path).findings if finding.code == code]


@pytest.mark.parametrize("version", ["", "1.0", "1.1", "1.2"])
@pytest.mark.parametrize("quaternion", [QUATERNION, "0 0.70710678 0 0.70710678"])
def test_a_quaternion_counts_from_1_1_on(version: str, quaternion: str, tmp_path: Path) -> None:
    path = write(tmp_path, text_of(version, f'xyz="0 0.1 0.5" quat_xyzw="{quaternion}"'))
    arm = load_arm(path)
    np.testing.assert_allclose(arm.home, by_pinocchio(path.read_text()), atol=1e-14)
    assert crosscheck(arm, 10).ok
    counts = version in ("1.1", "1.2")
    assert told(path, "word-unread") == (
        [] if counts else ["quat_xyzw= in 1 <origin> is not read: URDF 1.0 does not have it"]
    )


@pytest.mark.parametrize("quaternion", ["0 0 1", "0 0 0 0", "a b c d", '0 0 0 1" rpy="0 0 0'])
def test_no_quaternion_is_refused(quaternion: str, tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match="its <origin> is malformed"):
        load_arm(write(tmp_path, text_of("1.1", f'quat_xyzw="{quaternion}"')))


def test_a_quaternion_turns_shapes_and_inertias(tmp_path: Path) -> None:
    origin = f'<origin xyz="1 2 3" quat_xyzw="{QUATERNION}"/>'
    shape = f'{origin}<geometry><box size="1 2 3"/></geometry>'
    inertia = '<inertia ixx="0.1" iyy="0.2" izz="0.25" ixy="0" ixz="0" iyz="0"/>'
    body = f'<inertial>{origin}<mass value="2"/>{inertia}</inertial>'
    link = f'<link name="upper"><visual>{shape}</visual><collision>{shape}</collision>{body}</link>'
    text = text_of("1.1", 'xyz="0 0 0.5"').replace('<link name="upper"/>', link)
    arm = load_arm(write(tmp_path, text))
    R = Rotation.from_quat([float(x) for x in QUATERNION.split()]).as_matrix()
    assert arm.description is not None
    upper = arm.description.links["upper"]
    for drawn in (*upper.visuals, *upper.collisions):
        np.testing.assert_allclose(drawn.origin[:3, :3], R, atol=1e-14)
    reference = pinocchio.buildModelFromXML(text)
    model = arm.pinocchio.model
    np.testing.assert_allclose(model.inertias[1].inertia, reference.inertias[1].inertia, atol=1e-14)
    np.testing.assert_allclose(reference.inertias[1].inertia, R @ np.diag([0.1, 0.2, 0.25]) @ R.T, atol=1e-14)


RATES = 'acceleration="5" deceleration="{}" jerk="70"'


@pytest.mark.parametrize(("deceleration", "smaller"), [("9", 5.0), ("3", 3.0), ("0", 5.0)])
def test_acceleration_and_jerk_count_from_1_2_on(deceleration: str, smaller: float, tmp_path: Path) -> None:
    path = write(tmp_path, text_of("1.2", 'xyz="0 0 0.5"', RATES.format(deceleration)))
    limits = load_arm(path).limits
    assert (limits.acceleration[0], limits.jerk[0]) == (smaller, 70.0)
    assert np.isinf([limits.acceleration[1], limits.jerk[1]]).all()
    older = write(tmp_path, text_of("1.1", 'xyz="0 0 0.5"', RATES.format(deceleration)), "older.urdf")
    assert np.isinf(load_arm(older).limits.acceleration).all()
    assert told(older, "word-unread") == [
        f"{name}= in 1 <limit> is not read: URDF 1.1 does not have it"
        for name in ("acceleration", "deceleration", "jerk")
    ]


@pytest.mark.parametrize("version", ["1", "1.3", "x", "1.1.0", ""])
def test_a_version_that_nobody_knows_is_told_and_read(version: str, tmp_path: Path) -> None:
    text = robot(joint("a", "base_link", "upper"), joint("b", "upper", "tool0"))
    path = write(tmp_path, text.replace("<robot ", f'<robot version="{version}" '))
    assert load_arm(path).joint_names == ("a", "b")
    (what,) = told(path, "word-unread")
    assert repr(version) in what
    with pytest.raises(ValueError, match="valid URDF"):
        pinocchio.buildModelFromXML(path.read_text())
