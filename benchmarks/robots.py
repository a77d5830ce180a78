"""The arms of the comparison: robots of the example-robot-data wheel, cut to the chain from base to tool.

Every solver gets the same cut URDF, with continuous joints as revolute ones of ±2π. twistarm reads the whole
description, with base, tip and limits.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from dataclasses import asdict, dataclass
from importlib.metadata import distribution
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

ARMS = {
    "panda": ("panda_description/urdf/panda.urdf", "panda_link0", "panda_hand_tcp"),
    "ur5": ("ur_description/urdf/ur5_robot.urdf", "base_link", "tool0"),
    "jaco": ("kinova_description/robots/kinova.urdf", "j2s6s200_link_base", "j2s6s200_end_effector"),
    "so101": ("so_arm_description/urdf/so101.urdf", "base_link", "gripper_frame_link"),
}
"""File, base and tool. The place in this order is the arm_index of the problems' seed."""


@dataclass(frozen=True)
class Robot:
    """An arm as plain data for a worker. It has lists because it is sent as JSON."""

    name: str
    whole_urdf: str
    urdf: str
    base: str
    tip: str
    joints: list[str]
    lower: list[float]
    upper: list[float]
    axis_frames: list[Any]
    """(n + 1, 4, 4) at theta = 0, from the base: every joint with z along its axis, then the tool."""
    reach: float
    """The sum of the distances between successive joints: the tool's largest distance from the first joint [m]."""

    def as_message(self) -> dict[str, Any]:
        return asdict(self)


def make_robot(name: str, folder: Path) -> Robot:
    """The arm `name`, its cut URDF written into `folder`."""
    file, base, tip = ARMS[name]
    whole = _models() / file
    urdf = folder / f"{name}.urdf"
    urdf.write_text(cut(whole.read_text(), base, tip))
    model = pin.buildModelFromUrdf(str(urdf))
    frames = _axis_frames(model, tip)
    return Robot(
        name=name,
        whole_urdf=str(whole),
        urdf=str(urdf),
        base=base,
        tip=tip,
        joints=list(model.names)[1:],
        lower=model.lowerPositionLimit.tolist(),
        upper=model.upperPositionLimit.tolist(),
        axis_frames=frames.tolist(),
        reach=float(np.linalg.norm(np.diff(frames[:, :3, 3], axis=0), axis=1).sum()),
    )


def cut(urdf: str, base: str, tip: str) -> str:
    """The URDF of the chain base -> tip: no meshes or masses, continuous joints as revolute ones of ±2π."""
    joints = {
        joint.find("child").get("link"): joint
        for joint in ElementTree.fromstring(urdf).iter("joint")
        if joint.find("child") is not None
    }
    robot = ElementTree.Element("robot", name="arm")
    ElementTree.SubElement(robot, "link", name=base)
    chain = []
    link = tip
    while link != base:
        chain.append(joints[link])
        link = joints[link].find("parent").get("link")
    for joint in reversed(chain):
        _limit_turns(joint)
        ElementTree.SubElement(robot, "link", name=joint.find("child").get("link"))
        for part in [part for part in joint if part.tag not in ("parent", "child", "origin", "axis", "limit")]:
            joint.remove(part)
        robot.append(joint)
    return ElementTree.tostring(robot, encoding="unicode")


def _limit_turns(joint: ElementTree.Element) -> None:
    if joint.get("type") == "continuous":
        joint.set("type", "revolute")
        limit = joint.find("limit")
        if limit is None:
            limit = ElementTree.SubElement(joint, "limit", effort="1", velocity="1")
        limit.set("lower", repr(-2 * math.pi))
        limit.set("upper", repr(2 * math.pi))


def _axis_frames(model: Any, tip: str) -> np.ndarray:
    data = model.createData()
    theta = pin.neutral(model)
    pin.framesForwardKinematics(model, data, theta)
    pin.computeJointJacobians(model, data, theta)
    frames = []
    for i in range(1, model.njoints):
        frame = data.oMi[i].homogeneous.copy()
        axis = pin.getJointJacobian(model, data, i, pin.LOCAL)[3:, i - 1]
        frame[:3, :3] = frame[:3, :3] @ pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), axis).matrix()
        frames.append(frame)
    return np.array([*frames, data.oMf[model.getFrameId(tip)].homogeneous])


def _models() -> Path:
    return Path(str(distribution("example-robot-data").locate_file("cmeel.prefix/share/example-robot-data/robots")))
