"""URDF 1.0, 1.1 and 1.2: what counts from which version on, as Pinocchio's parser (urdfdom) reads it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio
import pytest
from scipy.spatial.transform import Rotation

from twistarm import crosscheck, load_arm
from twistarm.description.urdf import read_description
from twistarm.support.errors import DescriptionError
from urdf_text import joint, robot, two_joints, write

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
