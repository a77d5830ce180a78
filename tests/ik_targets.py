"""Targets an arm can reach, built from its own forward kinematics, and judges of answers that use Pinocchio alone."""

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

from needed import absent
from twistarm.ik import Approach, Pose, Position, TolerancedPose

KINDS = ("Pose", "Position", "Approach", "TolerancedPose")

# Exact, banded and free components of position and rotation at once.
TASK_TOLERANCE = (0.0, 0.0, 0.01, 0.1, np.inf, 0.0)
USUAL = (1e-5, 5e-5)  # The success that is counted [m], [rad]: what a call tolerates unless it says otherwise.
JUDGE_SLACK = 1e-9  # What two forward kinematics may differ by, and how far beyond a limit rounding may lie.


def target_from(kind, g, rng):
    """A target of `kind` that the pose g reaches."""
    if kind == "Pose":
        return Pose(g)
    if kind == "Position":
        return Position(g[:3, 3])
    if kind == "Approach":
        axis = rng.normal(size=3)
        return Approach(g[:3, 3], g[:3, :3] @ axis, tool_axis=axis)
    return TolerancedPose(g, TASK_TOLERANCE, frame=("target", "base")[rng.integers(2)])


def pinocchio_fk(arm, theta):
    """g_st by Pinocchio alone: the arm's model, but neither its chain, its screws nor its own fk."""
    engine = arm.pinocchio
    data = engine.model.createData()
    pin.framesForwardKinematics(engine.model, data, engine.q(np.asarray(theta)))
    base, tip = (data.oMf[engine.frame_id(link)] for link in (arm.base, arm.tip_link))
    return base.actInv(tip).homogeneous @ arm.tool


def errors(target, g):
    """Position [m] and rotation error [rad] of the pose g, anew from the definitions, with Pinocchio's logarithm."""
    if isinstance(target, Position):
        return np.linalg.norm(g[:3, 3] - target.p), 0.0
    if isinstance(target, Approach):
        axis = g[:3, :3] @ target.tool_axis
        chord = np.linalg.norm(axis - target.direction)
        return np.linalg.norm(g[:3, 3] - target.p), 2 * np.arcsin(min(chord / 2, 1))
    R_g = target.g[:3, :3]
    p, w = g[:3, 3] - target.g[:3, 3], pin.log3(g[:3, :3] @ R_g.T)
    if isinstance(target, Pose):
        return np.linalg.norm(p), np.linalg.norm(w)
    if target.frame == "target":
        p, w = R_g.T @ p, R_g.T @ w
    beyond = np.maximum(np.abs(np.r_[p, w]) - target.tolerance, 0.0)
    beyond[3:][target.tolerance[3:] >= np.pi] = 0.0
    return np.linalg.norm(beyond[:3]), np.linalg.norm(beyond[3:])


def judged(arm, target, solution):
    """Whether Pinocchio finds the target reached to `USUAL`, and the limits kept."""
    lower, upper = arm.limits.lower - JUDGE_SLACK, arm.limits.upper + JUDGE_SLACK
    inside = (solution.theta >= lower).all() and (solution.theta <= upper).all()
    return inside and is_reached(*errors(target, pinocchio_fk(arm, solution.theta)))


def is_reached(position, orientation):
    """Whether errors [m], [rad] count as reached, one or arrays."""
    return (position <= USUAL[0] + JUDGE_SLACK) & (orientation <= USUAL[1] + JUDGE_SLACK)


def pinocchio_poses(arm, theta):
    """g_st (N, 4, 4) of configurations (N, n) by Pinocchio alone, one after the other."""
    engine = arm.pinocchio
    data, (base, tip) = engine.model.createData(), (engine.frame_id(link) for link in (arm.base, arm.tip_link))
    poses = np.empty((len(theta), 4, 4))
    for i, row in enumerate(theta):
        pin.framesForwardKinematics(engine.model, data, engine.q(row))
        poses[i] = data.oMf[base].actInv(data.oMf[tip]).homogeneous
    return poses @ arm.tool


def judged_batch(arm, targets, batch):
    """`judged` for each row of a batch (N,): targets are poses (N, 4, 4) or target objects."""
    reached, limits = pinocchio_poses(arm, batch.theta), arm.limits
    inside = (batch.theta >= limits.lower - JUDGE_SLACK) & (batch.theta <= limits.upper + JUDGE_SLACK)
    if isinstance(targets, np.ndarray):
        position = np.linalg.norm(reached[:, :3, 3] - targets[:, :3, 3], axis=1)
        chord = np.linalg.norm(reached[:, :3, :3] - targets[:, :3, :3], axis=(1, 2)) / np.sqrt(8)
        missed = position, 2 * np.arcsin(np.minimum(chord, 1))
    else:
        missed = np.array([errors(target, g) for target, g in zip(targets, reached, strict=True)]).reshape(-1, 2).T
    return inside.all(1) & is_reached(*missed)


def require_core(arm):
    """For sweeps that only the compiled core gets through: skips without it, fails where nothing may be skipped."""
    if arm.compiled is None:
        absent("needs the compiled core")


def at_some_limits(arm, rng, count):
    """Random configurations (count, n) with each joint at a bound with probability 1/2, ±π or ±1 m where unbounded."""
    theta, bounds = arm.random_theta(rng, count), np.array(arm.sampling_bounds)
    at = rng.random(theta.shape) < 0.5
    theta[at] = bounds[rng.integers(2, size=theta.shape), np.arange(arm.n)][at]
    return theta


def turned(g, axis, angle):
    """g turned about an axis of its own by `angle` [rad]."""
    turned = g.copy()
    turned[:3, :3] = g[:3, :3] @ Rotation.from_rotvec(angle * np.asarray(axis, dtype=float)).as_matrix()
    return turned


def moved(g, offset):
    """g moved by `offset` [m] in base axes."""
    moved = g.copy()
    moved[:3, 3] += offset
    return moved
