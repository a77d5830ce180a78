"""One library that computes all solutions, in its own environment. `python -m benchmarks.all_solutions_worker PEER`.

It reads one JSON object per line and answers with one line each:

  {"do": "all", "robot", "held", "value", "g", "start"}                    {"theta": [...], "ns"} or {"error"}

`held` is the joint that stays at `value`, or null. The timed work is one pose to all solutions: verified to 1e-9,
inside the limits, sorted by distance from `start`. What a library leaves out, NumPy does with the library's forward
kinematics. `ns` is the least of several calls.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from .peers import Unfit, serve, timed

TURN, EXACT = 2.0 * np.pi, 1e-9

Solve = Callable[[np.ndarray, np.ndarray, float | None], np.ndarray]


def kept(theta: np.ndarray, start: np.ndarray, robot: dict[str, Any], fk: Callable[..., Any], g: np.ndarray) -> Any:
    """Rows of theta (k, n) that are exact, brought inside the limits, nearest to the start first."""
    lower, upper = np.array(robot["lower"]), np.array(robot["upper"])
    exact = [bool(np.abs(np.asarray(fk(each)) - g).max() <= EXACT) for each in theta]
    theta = theta[np.array(exact, dtype=bool)]
    theta = theta + TURN * np.round((start - theta) / TURN)
    theta = theta + TURN * (theta < lower) - TURN * (theta > upper)
    theta = theta[((theta >= lower) & (theta <= upper)).all(axis=1)]
    return theta[np.argsort(np.abs(theta - start).max(axis=1, initial=0.0))]


def twistarm(robot: dict[str, Any], held: int | None) -> Solve:
    from twistarm import Pose, load_arm, solve_ik_all

    limits = {side: dict(zip(robot["joints"], robot[side], strict=True)) for side in ("lower", "upper")}
    arm = load_arm(robot["whole_urdf"], base=robot["base"], tip=robot["tip"], limits=limits)

    def solve(g: np.ndarray, start: np.ndarray, value: float | None) -> np.ndarray:
        given = None if held is None else {arm.joint_names[held]: value}
        return solve_ik_all(arm, Pose(g), start, fixed_joints=given).theta

    return solve


def eaik(robot: dict[str, Any], held: int | None) -> Solve:
    from eaik.IK_Homogeneous import HomogeneousRobot

    frames = np.array(robot["axis_frames"])
    made: dict[float | None, Any] = {}

    def of(value: float | None) -> Any:
        if value not in made:
            made.clear()
            fixed = [] if held is None else [(held, value)]
            made[value] = HomogeneousRobot(frames, fixed_axes=fixed)
            if not made[value].hasKnownDecomposition():
                raise Unfit(f"no decomposition: {made[value].getKinematicFamily()}")
        return made[value]

    def solve(g: np.ndarray, start: np.ndarray, value: float | None) -> np.ndarray:
        solver = of(value)
        found = solver.IK(g)
        exact = ~np.asarray(found.is_LS, dtype=bool)
        return kept(np.asarray(found.Q).reshape(len(exact), -1)[exact], start, robot, solver.fwdKin, g)

    return solve


def ssik(robot: dict[str, Any], held: int | None) -> Solve:
    from benchmarks.peers.ssik import _built

    artifact = _built(robot)
    lower, upper = np.array(robot["lower"]), np.array(robot["upper"])

    if held is not None:
        raise Unfit("it samples the joint that the arm has too many, and is given no value for it")

    def solve(g: np.ndarray, start: np.ndarray, value: float | None) -> np.ndarray:
        found = np.array([each.q for each in artifact.solve(g, q_seed=start)]).reshape(-1, len(start))
        found = found[((found >= lower) & (found <= upper)).all(axis=1)]
        return found[np.argsort(np.abs(found - start).max(axis=1, initial=0.0))]

    return solve


# The constructor for the arm, and the first of the joints whose axes meet in one point, which it needs.
IK_GEO = {"ur5": ("three_parallel_two_intersecting", 4), "jaco": ("spherical_two_parallel", 3)}


def ik_geo(robot: dict[str, Any], held: int | None) -> Solve:
    from ik_geo import Robot

    if robot["name"] not in IK_GEO:
        raise Unfit("no constructor: six joints of a family that has to be named")
    family, first = IK_GEO[robot["name"]]
    frames = np.array(robot["axis_frames"])
    w, points, home = frames[:6, :3, 2], np.array(frames[:, :3, 3]), frames[6]
    across = np.eye(3) - w[first:6, :, None] * w[first:6, None, :]
    points[first:6] = np.linalg.lstsq(across.sum(0), (across @ points[first:6, :, None]).sum(0)[:, 0], rcond=None)[0]
    solver = getattr(Robot, family)(w.tolist(), np.diff(points, axis=0, prepend=np.zeros((1, 3))).tolist())

    def fk(theta: np.ndarray) -> np.ndarray:  # its matrices are lists of columns
        R, p = solver.forward_kinematics(theta.tolist())
        return np.block([[np.array(R).T @ home[:3, :3], np.array(p)[:, None]], [np.eye(4)[3:]]])

    def solve(g: np.ndarray, start: np.ndarray, value: float | None) -> np.ndarray:
        found = solver.get_ik((home[:3, :3] @ g[:3, :3].T).tolist(), g[:3, 3].tolist())
        exact = np.array([theta for theta, least_squares in found if not least_squares]).reshape(-1, 6)
        return kept(exact, start, robot, fk, g)

    return solve


MADE: dict[str, Callable[[dict[str, Any], int | None], Solve]] = {
    "twistarm": twistarm,
    "eaik": eaik,
    "ik_geo": ik_geo,
    "ssik": ssik,
}


SOLVERS: dict[str, Solve] = {}


def answer(asked: dict[str, Any]) -> dict[str, Any]:
    name = asked["robot"]["name"]
    if name not in SOLVERS:
        SOLVERS[name] = MADE[sys.argv[1]](asked["robot"], asked["held"])
    g, start = np.array(asked["g"]), np.array(asked["start"])
    theta, ns = timed(lambda: SOLVERS[name](g, start, asked["value"]))
    return {"theta": theta.tolist(), "ns": ns}


if __name__ == "__main__":
    serve(answer)
