"""Arms of each family from `data/ik_families.json`, and judges of all their answers that use SciPy alone."""

import json
from pathlib import Path

import numpy as np
from scipy.linalg import expm

from twistarm import Pose, arm_from_screws, solve_ik_all

CASES = json.loads((Path(__file__).parent / "data" / "ik_families.json").read_text(encoding="utf-8"))["arms"]


def screws_of(axes):
    """Twists (6, n) of axes [kind, direction, point]."""
    columns = []
    for kind, direction, point in axes:
        w = np.array(direction, dtype=float) / np.linalg.norm(direction)
        columns.append(np.r_[np.cross(point, w), w] if kind == "R" else np.r_[w, 0.0, 0.0, 0.0])
    return np.array(columns).T


def family_arm(name, noise=0.0, rng=None, half_turns=1.0):
    """The arm of that name, its axes off by `noise`, joints within ± `half_turns` π or 1 m."""
    xi = screws_of(CASES[name]["axes"])
    if noise:
        turning = np.linalg.norm(xi[3:], axis=0) > 0
        for i in np.flatnonzero(turning):
            w, v = xi[3:, i], xi[:3, i]
            o = np.cross(w, v) + noise * rng.normal(size=3)
            w = w + noise * rng.normal(size=3)
            w /= np.linalg.norm(w)
            xi[:, i] = np.r_[np.cross(o, w), w]
    home = np.eye(4)
    home[:3, 3] = [0.9, 0.15, 0.3]
    names = [f"joint{i + 1}" for i in range(xi.shape[1])]
    bound = np.where(np.linalg.norm(xi[3:], axis=0) > 0, half_turns * np.pi, 1.0)
    limits = {"lower": dict(zip(names, (-bound).tolist(), strict=True))}
    limits["upper"] = dict(zip(names, bound.tolist(), strict=True))
    return arm_from_screws(xi, home, joints=names, limits=limits, name=name)


def twist_motion(xi, x):
    """e^{ξ̂x} (4, 4) by SciPy's matrix exponential."""
    vx, vy, vz, wx, wy, wz = xi
    return expm(x * np.array([[0, -wz, wy, vx], [wz, 0, -wx, vy], [-wy, wx, 0, vz], [0, 0, 0, 0]]))


def pose_of(arm, theta):
    """g_st (4, 4) by the motions of the arm's twists."""
    g = np.eye(4)
    for xi, x in zip(arm.screws.T, arm.coupling.A @ theta + arm.coupling.b, strict=True):
        g = g @ twist_motion(xi, x)
    return g @ arm.home


def missed(arm, g, theta):
    """How far theta (n,) is from the pose g (4, 4), in m or rad."""
    off = pose_of(arm, theta) - g
    return max(np.linalg.norm(off[:3, 3]), np.linalg.norm(off[:3, :3]) / np.sqrt(2))


def differences(arm, a, b):
    """a − b (n,), angles modulo whole turns."""
    turns = np.array(arm.units) != "m"
    return np.where(turns, (a - b + np.pi) % (2 * np.pi) - np.pi, a - b)


def joint_distance(arm, a, b):
    """The largest difference of two configurations, angles modulo whole turns."""
    return np.abs(differences(arm, a, b)).max()


def one(arm, g, a, b, exact=1e-9):
    """Whether two configurations for the pose g (4, 4) are one: near, and halfway between them it is met so well."""
    return joint_distance(arm, a, b) < 9e-3 and missed(arm, g, b + 0.5 * differences(arm, a, b)) < exact


def holds(arm, g, theta, found, deeper=3):
    """Whether theta is an answer, or lies in a family that was reported: then a free joint is given theta's value."""
    everything = [*found.theta, *found.outside]
    near = min(everything, key=lambda answer: joint_distance(arm, answer, theta), default=None)
    if near is not None and (joint_distance(arm, near, theta) < 1e-5 or one(arm, g, near, theta)):
        return True
    names = {name for joints in found.free for name in joints}
    for name in sorted(names) if deeper else ():
        value = float(theta[arm.joint_names.index(name)])
        if holds(arm, g, theta, solve_ik_all(arm, Pose(g), theta, fixed_joints={name: value}), deeper - 1):
            return True
    return False


def assert_exact_and_different(arm, g, theta, found, exact=1e-9):
    """Every answer meets the pose g that theta (n,) made, none is there twice, and theta is among them."""
    everything = [*found.theta, *found.outside]
    assert all(missed(arm, g, answer) <= exact for answer in everything)
    assert not any(one(arm, g, a, b, 0.5 * exact) for i, a in enumerate(everything) for b in everything[:i])
    assert holds(arm, g, theta, found), theta
