"""The troubles that real arm descriptions have, one test each: what the user gets, judged by plain Pinocchio."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio
import pytest

from twistarm import Arm, load_arm
from twistarm.support.errors import DescriptionError
from urdf_text import joint, robot, two_joints, write


def by_plain_pinocchio(path: Path, values: dict[str, float], base: str, tip: str) -> np.ndarray:
    """Pose of `tip` in `base` from the file as it is, every joint set by its name."""
    model = pinocchio.buildModelFromUrdf(str(path))
    data, q = model.createData(), pinocchio.neutral(model)
    for name, value in values.items():
        at = model.joints[model.getJointId(name)]
        q[at.idx_q : at.idx_q + at.nq] = value if at.nq == 1 else [np.cos(value), np.sin(value)]
    pinocchio.framesForwardKinematics(model, data, q)
    base_frame, tip_frame = (data.oMf[model.getFrameId(link, pinocchio.FrameType.BODY)] for link in (base, tip))
    return np.asarray(base_frame.actInv(tip_frame).homogeneous)


def agrees(arm: Arm, path: Path, theta: np.ndarray, **others: float) -> bool:
    values = dict(zip(arm.joint_names, theta, strict=True)) | others
    return np.allclose(arm.fk(theta), by_plain_pinocchio(path, values, arm.base, arm.tip), atol=1e-13)


def test_links_without_inertia_need_no_word(tmp_path: Path) -> None:
    assert load_arm(write(tmp_path, two_joints())).findings == ()


def test_the_root_is_the_base_whatever_its_name(tmp_path: Path) -> None:
    parts = joint("mount", "world", "base_link", kind="fixed"), joint("a", "base_link", "tool0")
    path = write(tmp_path, robot(*parts, links=("tool0", "base_link", "world")))
    assert load_arm(path).base == "world"
    assert np.allclose(load_arm(path, base="base_link").home[:3, 3], [0, 0, 0.5])


def test_the_tool_is_looked_for_among_all_links(tmp_path: Path) -> None:
    """As on the UR arms: `ee_link` and `base` are leaves beside `tool0`; on others the only leaves are fingers."""
    links = ("base_link", "wrist", "base", "ee_link", "tool0", "left", "right")
    parts = [joint("a", "base_link", "wrist"), joint("b", "base_link", "base", kind="fixed")]
    parts += [joint("e", "wrist", "ee_link", kind="fixed"), joint("t", "wrist", "tool0", kind="fixed")]
    parts += [joint(f"{side}_finger", "tool0", side, kind="prismatic") for side in ("left", "right")]
    assert load_arm(write(tmp_path, robot(*parts, links=links))).tip == "tool0"


def test_continuous_joints_are_one_unbounded_angle(tmp_path: Path) -> None:
    parts = [joint("a", "base_link", "upper", kind="continuous", inside='<axis xyz="1 0 0"/>')]
    parts += [joint("b", "upper", "tool0", kind="continuous")]
    path = write(tmp_path, robot(*parts))
    arm = load_arm(path)
    assert arm.joint_types == ("continuous", "continuous")
    assert np.isinf(arm.limits.lower).all()
    assert np.linalg.det(arm.fk([0.0, 0.0])[:3, :3]) == pytest.approx(1.0)
    assert agrees(arm, path, np.array([2.5, -7.0]))
    assert load_arm(path, limits={"lower": -1.0, "upper": {"b": 2.0}}).limits.upper.tolist() == [np.inf, 2.0]


def test_a_parallelogram_arm_moves_by_its_coupling(tmp_path: Path) -> None:
    """The forearm follows the shoulder, and the level follows the forearm: a mimic of a mimic."""
    pitch = '<axis xyz="0 1 0"/>'
    parts = (
        joint("shoulder", "base_link", "upper", inside=pitch),
        joint("forearm", "upper", "fore", inside=pitch + '<mimic joint="shoulder" multiplier="-1" offset="0.3"/>'),
        joint("elbow", "fore", "hand", inside=pitch),
        joint("level", "hand", "tool0", inside=pitch + '<mimic joint="forearm" multiplier="-0.5" offset="0.1"/>'),
    )
    path = write(tmp_path, robot(*parts, links=("base_link", "upper", "fore", "hand", "tool0")))
    arm = load_arm(path)
    assert arm.joint_names == ("shoulder", "elbow")
    for shoulder, elbow in np.random.default_rng(1).uniform(-0.5, 0.5, (20, 2)):
        forearm = -shoulder + 0.3
        assert agrees(arm, path, np.array([shoulder, elbow]), forearm=forearm, level=-0.5 * forearm + 0.1)


def test_a_continuous_master_drives_a_revolute_follower(tmp_path: Path) -> None:
    """A pair that Pinocchio's own mimic refuses."""
    wide = '<limit lower="-9" upper="9" velocity="1" effort="1"/><axis xyz="1 0 0"/>'
    parts = (
        joint("a", "base_link", "upper", kind="continuous", inside='<axis xyz="0 1 0"/>'),
        joint("b", "upper", "tool0", inside=wide + '<mimic joint="a" multiplier="0.5"/>'),
    )
    path = write(tmp_path, robot(*parts))
    assert agrees(load_arm(path), path, np.array([1.4]), b=0.7)


def test_slides_and_angles_carry_their_units(tmp_path: Path) -> None:
    parts = joint("rail", "base_link", "upper", kind="prismatic"), joint("b", "upper", "tool0")
    arm = load_arm(write(tmp_path, robot(*parts)))
    assert arm.units == ("m", "rad")


def test_theta_runs_base_to_tip_whatever_the_file_or_the_alphabet_says(tmp_path: Path) -> None:
    links = ("tool0", "upper", "fore", "base_link")
    parts = (
        joint("a_last", "fore", "tool0", inside='<axis xyz="1 0 0"/>'),
        joint("m_middle", "upper", "fore", inside='<axis xyz="0 1 0"/>'),
        joint("z_first", "base_link", "upper"),
    )
    path = write(tmp_path, robot(*parts, links=links))
    arm = load_arm(path)
    assert arm.joint_names == ("z_first", "m_middle", "a_last")
    assert agrees(arm, path, np.array([0.3, -0.4, 0.5]))
    assert arm.theta_from(["a_last", "z_first", "m_middle"], [3.0, 1.0, 2.0]).tolist() == [1.0, 2.0, 3.0]


def test_a_joint_may_have_the_name_of_a_link(tmp_path: Path) -> None:
    parts = joint("upper", "base_link", "upper"), joint("tool0", "upper", "tool0", inside='<axis xyz="1 0 0"/>')
    path = write(tmp_path, robot(*parts))
    arm = load_arm(path)
    assert agrees(arm, path, np.array([0.2, 0.4]))
    assert np.allclose(arm.pose([0.2, 0.4], "upper"), by_plain_pinocchio(path, {"upper": 0.2}, "base_link", "upper"))


def test_two_arms_in_one_file(tmp_path: Path) -> None:
    links = ("torso", *(f"{side}_{part}" for side in ("left", "right") for part in ("upper", "tcp")))
    parts = [
        joint(f"{side}_{name}", parent, child, xyz=xyz, inside=f'<axis xyz="{axis}"/>')
        for side, xyz in (("left", "0 0.3 0"), ("right", "0 -0.3 0"))
        for name, parent, child, axis in (
            ("shoulder", "torso", f"{side}_upper", "0 1 0"),
            ("elbow", f"{side}_upper", f"{side}_tcp", "1 0 0"),
        )
    ]
    path = write(tmp_path, robot(*parts, links=links))
    with pytest.raises(
        DescriptionError, match=r"tip: 'left_tcp' \(2 joints\), 'right_tcp' \(2 joints\); pass tip='left_tcp'$"
    ):
        load_arm(path)
    arm = load_arm(path, tip="right_tcp")
    assert arm.joint_names == ("right_shoulder", "right_elbow")
    assert agrees(arm, path, np.array([0.5, -0.5]))
    left = arm.poses([0.0, 0.0], others={"left_shoulder": 0.4})["left_tcp"]
    assert np.allclose(left, by_plain_pinocchio(path, {"left_shoulder": 0.4}, "torso", "left_tcp"))


def test_an_arm_inside_a_whole_rover(tmp_path: Path) -> None:
    """Wheels turn, the chassis floats, the mast pans: the arm is what lies between its base and its tip."""
    links = ("world", "chassis", "left_wheel", "mast", "arm_base", "arm_upper", "arm_tip")
    parts = (
        joint("drive", "world", "chassis", kind="floating"),
        joint("left_wheel_joint", "chassis", "left_wheel", kind="continuous"),
        joint("pan", "chassis", "mast"),
        joint("mount", "chassis", "arm_base", kind="fixed", xyz="0.2 0 0.1"),
        joint("shoulder", "arm_base", "arm_upper", inside='<axis xyz="0 1 0"/>'),
        joint("elbow", "arm_upper", "arm_tip", inside='<axis xyz="0 1 0"/>'),
    )
    path = write(tmp_path, robot(*parts, links=links))
    arm = load_arm(path, base="arm_base", tip="arm_tip")
    assert arm.joint_names == ("shoulder", "elbow")
    assert agrees(arm, path, np.array([0.3, 0.4]))
    with pytest.raises(DescriptionError, match="joint 'drive': between 'world' and 'arm_tip' it is floating"):
        load_arm(path, tip="arm_tip")


def test_find_in_a_plain_urdf_is_substituted(tmp_path: Path) -> None:
    (tmp_path / "package.xml").write_text("<package><name>our_arm</name></package>")
    (tmp_path / "hand.stl").write_bytes(b"solid\nendsolid\n")
    shape = '<visual><geometry><mesh filename="$(find our_arm)/hand.stl"/></geometry></visual>'
    text = two_joints().replace('<link name="upper"/>', f'<link name="upper">{shape}</link>')
    arm = load_arm(write(tmp_path, text))
    assert arm.description is not None
    assert arm.description.links["upper"].visuals[0].mesh == tmp_path / "hand.stl"
    assert arm.findings == ()


def test_equal_bounds_hold_the_joint_and_are_said(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, two_joints(inside='<limit lower="0" upper="0" velocity="1" effort="1"/>')))
    assert arm.random_theta(np.random.default_rng(0))[0] == 0.0
    (said,) = arm.findings
    assert said.code == "limit-zero-range"
    assert "give its range as limits.a in arm.toml" in said.remedy
    assert load_arm(tmp_path / "arm.urdf", limits={"lower": {"a": -1}, "upper": {"a": 1}}).limits.upper[0] == 1


def test_a_mesh_that_is_a_pointer_never_stops_the_kinematics(tmp_path: Path) -> None:
    (tmp_path / "hand.stl").write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n")
    shape = '<visual><geometry><mesh filename="hand.stl"/></geometry></visual>'
    path = write(tmp_path, two_joints().replace('<link name="upper"/>', f'<link name="upper">{shape}</link>'))
    assert load_arm(path).proof is not None
