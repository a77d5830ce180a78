"""The arms of the comparison, targets and starts repeatable from a seed, and Pinocchio's verdict on every answer.

The arms are robots of the example-robot-data wheel, cut to the chain from base to tool. Every solver gets the same cut
URDF, with continuous joints as revolute ones of ±2π. twistarm reads the whole description, with base, tip and limits.

cold         target: the pose of a configuration uniform in the limits; start: another one
fresh        the same from the seed of this run
warm         target: the pose of a configuration 0.01 rad away from the start
unreachable  the targets of cold, moved straight away from the first joint to 1.05 to 1.5 times the arm's reach
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import distribution
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

OWN = Path(__file__).resolve().parents[1] / "robots"

ARMS = {
    "panda": ("panda_description/urdf/panda.urdf", "panda_link0", "panda_hand_tcp"),
    "ur5": ("ur_description/urdf/ur5_robot.urdf", "base_link", "tool0"),
    "jaco": ("kinova_description/robots/kinova.urdf", "j2s6s200_link_base", "j2s6s200_end_effector"),
    "so101": ("so_arm_description/urdf/so101.urdf", "base_link", "gripper_frame_link"),
    "rover_arm_6dof": (str(OWN / "rover_arm_6dof/rover_arm_6dof.urdf"), "base_link", "tool0"),
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


def make_robot(name: str, folder: Path) -> Robot:
    """The arm `name`, its cut URDF written into `folder`."""
    file, base, tip = ARMS[name]
    models = distribution("example-robot-data").locate_file("cmeel.prefix/share/example-robot-data/robots")
    whole = Path(str(models)) / file
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
        if joint.get("type") == "continuous":
            joint.set("type", "revolute")
            limit = joint.find("limit")
            limit = ElementTree.SubElement(joint, "limit", effort="1", velocity="1") if limit is None else limit
            limit.set("lower", repr(-2 * math.pi))
            limit.set("upper", repr(2 * math.pi))
        ElementTree.SubElement(robot, "link", name=joint.find("child").get("link"))
        for part in [part for part in joint if part.tag not in ("parent", "child", "origin", "axis", "limit")]:
            joint.remove(part)
        robot.append(joint)
    return ElementTree.tostring(robot, encoding="unicode")


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


STRICT = 1e-6  # Position [m] and rotation [rad] that an answer may be off.
LIMIT_SLACK = 1e-7  # How far beyond a limit rounding may put a joint [rad].


@dataclass(frozen=True)
class Errors:
    """Errors of N answers: position [m], rotation [rad] and the largest excess over a limit [rad], each (N,).

    NaN where a solver gave no answer.
    """

    position: np.ndarray
    rotation: np.ndarray
    beyond: np.ndarray

    @property
    def strict(self) -> np.ndarray:
        """Whether an answer meets its target, (N,). No comparison with NaN holds."""
        return (self.position <= STRICT) & (self.rotation <= STRICT) & (self.beyond <= LIMIT_SLACK)


class Judge:
    """Forward kinematics and limits of a robot, by Pinocchio alone."""

    def __init__(self, robot: Robot) -> None:
        self.model = pin.buildModelFromUrdf(robot.urdf)
        self.data = self.model.createData()
        self.tip = self.model.getFrameId(robot.tip)
        self.lower, self.upper = np.array(robot.lower), np.array(robot.upper)

    def fk(self, theta: np.ndarray) -> np.ndarray:
        """The tool seen from the base, (N, 4, 4), of configurations (N, n)."""
        return np.array([self._pose(row) for row in theta]).reshape(-1, 4, 4)

    def jacobian(self, theta: np.ndarray) -> np.ndarray:
        """The body Jacobian, (N, 6, n), linear part first."""
        columns = (pin.computeFrameJacobian(self.model, self.data, row, self.tip, pin.LOCAL).copy() for row in theta)
        return np.array(list(columns))

    def errors(self, theta: np.ndarray, targets: np.ndarray) -> Errors:
        """The errors of the answers (N, n), NaN rows for none, at the targets (N, 4, 4)."""
        if theta.shape != (len(targets), self.model.nq):
            raise ValueError(f"answers must have the shape {(len(targets), self.model.nq)}; got {theta.shape}")
        given = np.isfinite(theta).all(axis=1)
        position, rotation = np.full((2, len(targets)), np.nan)
        g, goal = self.fk(theta[given]), targets[given]
        position[given] = np.linalg.norm(g[:, :3, 3] - goal[:, :3, 3], axis=1)
        # ‖R_a − R_b‖ = 2√2 sin(angle / 2), in which nothing cancels for small angles.
        chord = np.linalg.norm(g[:, :3, :3] - goal[:, :3, :3], axis=(1, 2)) / np.sqrt(8)
        rotation[given] = 2 * np.arcsin(np.minimum(chord, 1.0))
        beyond = np.maximum(self.lower - theta, theta - self.upper).max(axis=1)
        return Errors(position, rotation, beyond)

    def _pose(self, theta: np.ndarray) -> np.ndarray:
        pin.forwardKinematics(self.model, self.data, theta)
        pose: np.ndarray = pin.updateFramePlacement(self.model, self.data, self.tip).homogeneous
        return pose


SEED = 20260701  # Of the problems that every run has in common.
WARM_DISTANCE = 0.01  # From the start of a warm problem to its solution [rad], the norm over the joints.
FARTHEST = 1.5  # Unreachable targets lie at 1.05 to this times the reach.


@dataclass(frozen=True)
class Problems:
    """N targets (N, 4, 4) and starts (N, n)."""

    kind: str
    targets: np.ndarray
    starts: np.ndarray

    def __len__(self) -> int:
        return len(self.targets)

    def chunks(self, size: int) -> Iterator[Problems]:
        """Parts of so many targets."""
        for k in range(0, len(self), size):
            yield Problems(self.kind, self.targets[k : k + size], self.starts[k : k + size])


def configurations(robot: Robot, seed: int, count: int) -> np.ndarray:
    """(count, 3, n): goal and start, uniform in the limits, and a unit vector. The first are equal for any count."""
    rng, made = np.random.default_rng([seed, list(ARMS).index(robot.name)]), []
    for _ in range(count):
        goal, start = rng.uniform(robot.lower, robot.upper), rng.uniform(robot.lower, robot.upper)
        direction = rng.normal(size=len(goal))
        made.append([goal, start, direction / np.linalg.norm(direction)])
    return np.array(made)


def cold(robot: Robot, judge: Judge, count: int, seed: int = SEED) -> Problems:
    goal, start, _ = configurations(robot, seed, count).swapaxes(0, 1)
    return Problems("cold" if seed == SEED else "fresh", judge.fk(goal), start)


def warm(robot: Robot, judge: Judge, count: int, seed: int = SEED) -> Problems:
    _, start, direction = configurations(robot, seed, count).swapaxes(0, 1)
    step = WARM_DISTANCE * direction
    out = (start + step < robot.lower) | (start + step > robot.upper)
    return Problems("warm", judge.fk(start + np.where(out, -step, step)), start)


def unreachable(robot: Robot, judge: Judge, count: int, seed: int = SEED) -> Problems:
    problems = cold(robot, judge, count, seed)
    centre = np.array(robot.axis_frames)[0, :3, 3]
    ray = problems.targets[:, :3, 3] - centre
    far = np.random.default_rng([seed, count]).uniform(1.05, FARTHEST, (count, 1)) * robot.reach
    problems.targets[:, :3, 3] = centre + far * ray / np.linalg.norm(ray, axis=1, keepdims=True)
    return Problems("unreachable", problems.targets, problems.starts)
