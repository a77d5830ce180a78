"""The troubles that real arm descriptions have, one test each: what the user gets, judged by plain Pinocchio."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio
import pytest

from twistarm import Arm, load_arm
from twistarm.support.errors import DescriptionError
from urdf_text import joint, robot, write


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


def test_the_root_is_the_base_whatever_its_name(tmp_path: Path) -> None:
    parts = joint("mount", "world", "base_link", kind="fixed"), joint("a", "base_link", "tool0")
    path = write(tmp_path, robot(*parts, links=("tool0", "base_link", "world")))
    assert load_arm(path).base == "world"
    assert np.allclose(load_arm(path, base="base_link").home[:3, 3], [0, 0, 0.5])


def test_a_continuous_master_drives_a_revolute_follower(tmp_path: Path) -> None:
    """A pair that Pinocchio's own mimic refuses."""
    wide = '<limit lower="-9" upper="9" velocity="1" effort="1"/><axis xyz="1 0 0"/>'
    parts = (
        joint("a", "base_link", "upper", kind="continuous", inside='<axis xyz="0 1 0"/>'),
        joint("b", "upper", "tool0", inside=wide + '<mimic joint="a" multiplier="0.5"/>'),
    )
    path = write(tmp_path, robot(*parts))
    assert agrees(load_arm(path), path, np.array([1.4]), b=0.7)


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
