"""Exercises: model solutions are right, slips are named, and references agree with Pinocchio and SciPy."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import cache
from math import acos, atan2, cos, pi, sin, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from scipy.spatial.transform import Rotation

from catalogue import load
from joint_arms import by_hand, random_chain
from small_course import REAL_ARMS
from twistarm import Arm, load_arm, screws
from twistarm.guide.exercises import LESSONS, every_exercise, exercises_of
from twistarm.guide.exercises.exercise import Exercise, Slip
from twistarm.guide.exercises.independent import (
    body_columns,
    expm,
    pose_log,
    spatial_columns,
    tool,
    twist_matrix,
    twist_of,
)
from twistarm.guide.exercises.instances import own_chain, pose
from twistarm.guide.grading.answers import of_function
from twistarm.guide.grading.verdict import Case, Verdict, cases_of, judged

EXERCISES = every_exercise()


@cache
def cases_on(name: str, arm: Arm, seed: int) -> list[Case]:
    cases = cases_of(EXERCISES[name], arm, seed)
    assert all(case.expected.error is None and not case.expected.undefined for case in cases)
    return cases


def verdict_on(function: Callable[..., Any], exercise: Exercise, arm: Arm, seed: int = 0) -> Verdict:
    cases = cases_on(exercise.name, arm, seed)
    return judged(exercise, cases, [of_function(function, case.arguments) for case in cases])


def hold(exercise: Exercise, arm: Arm, seed: int) -> None:
    """The model solution is right, and each slip is named."""
    right = verdict_on(exercise.model, exercise, arm, seed)
    assert right.ok, f"{arm.name}: {right}"
    for slip in exercise.slips:
        verdict = verdict_on(exercise.wrong(slip), exercise, arm, seed)
        assert (verdict.state, verdict.slip) == ("wrong", slip.name), f"{arm.name}, seed {seed}: {slip.name}"


LONG = ("solve_pose",)  # Seconds each: its solution, and a slip of it, are among those below.


@pytest.mark.parametrize("name", [pytest.param(k, marks=pytest.mark.slow if k in LONG else ()) for k in EXERCISES])
def test_the_model_solution_is_right_and_each_slip_is_named(name: str, rover: Arm) -> None:
    hold(EXERCISES[name], rover, seed=0)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1, 6))
@pytest.mark.parametrize("name", EXERCISES)
def test_on_other_instances_and_arms(name: str, seed: int) -> None:
    """Five joints, slides, two joints, and one that turns and slides at once."""
    for arm in ("scara", "rr_planar", "stanford"):
        hold(EXERCISES[name], load(arm), seed)
    hold(EXERCISES[name], helical_arm(seed), seed)


@pytest.mark.slow
@pytest.mark.parametrize(("file", "options"), REAL_ARMS)
def test_on_real_arms(file: str, options: dict[str, Any], models: Path) -> None:
    arm = load_arm(models / file, **options)
    for exercise in EXERCISES.values():
        hold(exercise, arm, seed=0)


def helical_arm(seed: int) -> Arm:
    return by_hand(*random_chain(("helical", "prismatic", "revolute", "cylindrical"), seed))


def test_what_there_is() -> None:
    for lesson in LESSONS:
        assert 2 <= len(exercises_of(lesson)) <= 4
    for exercise in EXERCISES.values():
        assert len({slip.name for slip in exercise.slips}) == len(exercise.slips), exercise.name
        assert "raise NotImplementedError" in exercise.template


def turn(axis: str, angle: float) -> Any:
    return Rotation.from_euler(axis, angle).as_matrix()


def hat(w: Any) -> Any:
    return np.array([np.cross(w, e) for e in np.eye(3)]).T


def by_scipy(S: Any, x: Any) -> Any:
    g = np.eye(4)
    for xi, value in zip(S.T, x, strict=True):
        g = g @ scipy.linalg.expm(twist_matrix(xi) * value)
    return g


def by_the_third_column(R: Any) -> list[float]:
    return [atan2(R[1, 2], R[0, 2]), acos(max(-1.0, min(1.0, R[2, 2]))), atan2(R[2, 1], -R[2, 0])]


def mixed_signs(l1: float, l2: float, x: float, y: float) -> list[list[float]]:
    r = sqrt(x * x + y * y)
    bend = pi - acos(max(-1.0, min(1.0, (l1**2 + l2**2 - r**2) / (2 * l1 * l2))))
    beta = acos(max(-1.0, min(1.0, (r * r + l1**2 - l2**2) / (2 * l1 * r))))
    wrap = lambda a: atan2(sin(a), cos(a))  # noqa: E731
    return [[wrap(atan2(y, x) + beta), bend], [wrap(atan2(y, x) - beta), -bend]]


OTHER_FUNCTIONS: list[tuple[str, str, Callable[..., Any]]] = [
    ("rotation_z", "sine for cosine", lambda a: [[sin(a), -cos(a), 0], [cos(a), sin(a), 0], [0, 0, 1]]),
    ("zyz", "fixed for moved axes", lambda a, b, c: Rotation.from_euler("zyz", [a, b, c]).as_matrix()),
    ("zyz_angles", "sin β = 0 forgotten", by_the_third_column),
    ("multiply", "order reversed", lambda P, Q: EXERCISES["multiply"].reference(Q, P)),
    ("rotate", "xyzw", lambda Q, p: Rotation.from_quat(Q).apply(p)),
    (
        "rodrigues",
        "not normalised",
        lambda w, t: np.eye(3) + sin(t) * hat(w) + (1 - cos(t)) * (np.outer(w, w) - w @ w * np.eye(3)),
    ),
    ("rodrigues", "exponential of each number", lambda w, t: np.exp(hat(w) * t)),
    ("rotation_log", "half turn forgotten", lambda R: Rotation.from_matrix(R).as_rotvec() * np.any(R != R.T)),
    ("transform_points", "rows times R", lambda g, P: np.array([p @ g[:3, :3] + g[:3, 3] for p in P])),
    ("twist_of_screw", "angular first", lambda a, q, h: np.r_[a, np.cross(q, a) + h * a] / np.linalg.norm(a)),
    (
        "screw_of_twist",
        "pitch inverted",
        lambda xi: (screws.to_screw(xi).axis, screws.to_screw(xi).point, 1 / screws.to_screw(xi).pitch),
    ),
    ("pose_log", "p for v", lambda g: np.r_[g[:3, 3], Rotation.from_matrix(g[:3, :3]).as_rotvec()]),
    ("adjoint", "no p̂R", lambda g: scipy.linalg.block_diag(g[:3, :3], g[:3, :3])),
    ("product_of_exponentials", "home forgotten", lambda S, home, x: by_scipy(S, x)),
    ("product_of_exponentials", "axes of the moment", lambda S, home, x: by_scipy(spatial_columns(S, x), x) @ home),
    ("reachable", "no room for rounding", lambda a, b, x, y: (a - b) ** 2 <= x * x + y * y <= (a + b) ** 2),
    ("both_elbows", "mixed signs", mixed_signs),
    ("damped_step", "damping not squared", lambda J, e, k: np.linalg.inv(J.T @ J + k * np.eye(J.shape[1])) @ J.T @ e),
    ("screw_between", "numbers interpolated", lambda a, b, s: (1 - s) * a + s * b),
    ("body_jacobian", "hybrid", lambda S, home, x: hybrid_columns(S, home, x)),
    ("manipulability", "JᵀJ for JJᵀ", lambda J: sqrt(np.linalg.det(np.dot(J.T, J)))),
    ("solve_pose", "one step", lambda S, home, x, g: x + np.linalg.pinv(body_columns(S, home, x)) @ off(S, home, x, g)),
    ("setpoints", "np.arange to the end", lambda a, b, T, dt: eased(np.arange(0, T, dt) / T, a, b)),
    ("pregrasp", "left for right", lambda g, d: g - d * np.eye(4)[:, [2]] * [0, 0, 0, 1]),
    # right, written otherwise
    ("rotation_z", "right", lambda a: ((cos(a), -sin(a), 0), (sin(a), cos(a), 0), (0, 0, 1))),
    (
        "zyz",
        "right",
        lambda a, b, c: scipy.linalg.expm(hat([0, 0, a])) @ scipy.linalg.expm(hat([0, b, 0])) @ turn("z", c),
    ),
    ("zyz_angles", "right", lambda R: Rotation.from_matrix(R).as_euler("ZYZ")),
    ("rotation_log", "right", lambda R: Rotation.from_matrix(R).as_rotvec() * (-1 if np.trace(R) < -0.999 else 1)),
    ("from_axis_angle", "right", lambda w, t: -np.roll(Rotation.from_rotvec(w / np.linalg.norm(w) * t).as_quat(), 1)),
    ("inverse_pose", "right", np.linalg.inv),
    (
        "screw_of_twist",
        "right",
        lambda xi: [screws.to_screw(xi).axis, screws.to_screw(xi).point, screws.to_screw(xi).pitch],
    ),
    (
        "screw_of_twist",
        "right",
        lambda xi: [screws.to_screw(xi).axis, screws.to_screw(xi).point - 2 * xi[3:], screws.to_screw(xi).pitch],
    ),
    ("twist_exp", "right", lambda xi, t: scipy.linalg.expm(twist_matrix(xi) * t)),
    ("pose_log", "right", lambda g: twist_of(scipy.linalg.logm(g).real)),
    ("both_elbows", "right", lambda *a: np.array(mixed_signs(*a))[[1, 0]] * [1, -1]),
    ("wrap", "right", lambda a: atan2(sin(a), cos(a))),
    ("newton_step", "right", lambda *a: np.angle(np.exp(1j * EXERCISES["newton_step"].reference(*a)))),
    ("screw_between", "right", lambda a, b, s: screws.exp(screws.log(b @ np.linalg.inv(a)), s) @ a),
    ("solve_pose", "right", EXERCISES["solve_pose"].model),
    ("carried_wrench", "right", lambda J: -scipy.linalg.null_space(J.T)[:, 0]),
    (
        "setpoints",
        "right",
        lambda a, b, T, dt: [a + (b - a) * (t / T) ** 2 * (3 - 2 * t / T) for t in np.arange(0, T + dt / 2, dt)],
    ),
    # two slips at once, which are not taken for one
    ("rotation_z", "", lambda a: turn("z", np.radians(-a))),
    ("zyz", "", lambda a, b, c: turn("z", c).T @ turn("y", b) @ turn("z", a)),
    ("rodrigues", "", lambda w, t: scipy.linalg.expm(-hat(w / np.linalg.norm(w)) * t) if w.any() else np.eye(3)),
    ("tool_point", "", lambda g, h, q: (h @ g @ [*q, 0])[:3]),
    ("product_of_exponentials", "", lambda S, home, x: by_scipy(np.r_[S[3:], S[:3]], np.radians(x))),
    ("damped_step", "", lambda J, e, k: -np.linalg.solve(J.T @ J + k * np.eye(J.shape[1]), J.T @ e)),
    ("body_jacobian", "", lambda S, home, x: np.roll(S, 3, axis=0)),
]
"""Functions that a reader may write: the exercise, the slip that the grader names ("right" for none), the function."""


def hybrid_columns(S: Any, home: Any, x: Any) -> Any:
    """(ṗ, ω) in base axes, by ṗ = v + ω × p."""
    J = spatial_columns(S, x)
    return np.vstack([J[:3] + np.cross(J[3:], tool(S, home, x)[:3, 3], axis=0), J[3:]])


def off(S: Any, home: Any, x: Any, g: Any) -> Any:
    return pose_log(np.linalg.inv(tool(S, home, x)) @ g)


def eased(s: Any, a: Any, b: Any) -> Any:
    return a + np.outer(s * s * (3 - 2 * s), b - a)


@pytest.mark.filterwarnings("ignore:Gimbal lock")  # of SciPy, which chooses as the task does
@pytest.mark.parametrize(
    ("name", "slip", "function"), OTHER_FUNCTIONS, ids=lambda value: str(value)[:40] if isinstance(value, str) else ""
)
def test_functions_written_otherwise(name: str, slip: str, function: Callable[..., Any], rover: Arm) -> None:
    verdict = verdict_on(function, EXERCISES[name], rover)
    assert (verdict.state, verdict.slip) == (("right", "") if slip == "right" else ("wrong", slip)), verdict
    assert ("yours gives" in verdict.words) == (slip == "")


@pytest.mark.parametrize("arm", ["rover_arm", "rover_arm_6dof", "scara", "stanford"])
def test_the_reader_s_arm_is_judged_as_by_pinocchio(arm: str) -> None:
    loaded = load(arm)
    theta = loaded.random_theta(5)
    S, home, A = np.array(loaded.screws), np.array(loaded.home), loaded.coupling.A
    g, J_s, J_b = loaded.by_pinocchio(theta)
    np.testing.assert_allclose(tool(S, home, A @ theta), g, atol=1e-12)
    np.testing.assert_allclose(spatial_columns(S, A @ theta) @ A, J_s, atol=1e-12)
    np.testing.assert_allclose(body_columns(S, home, A @ theta) @ A, J_b, atol=1e-12)


def test_the_exponential_and_the_logarithm_are_those_of_scipy() -> None:
    rng = np.random.default_rng(4)
    for size in (0.0, 1e-9, 0.3, 2.0, 20.0):
        M = rng.normal(size=(4, 4)) * size
        np.testing.assert_allclose(expm(M), scipy.linalg.expm(M), rtol=1e-10, atol=1e-12)
    for _ in range(5):
        g = pose(rng)
        np.testing.assert_allclose(twist_matrix(pose_log(g)), scipy.linalg.logm(g).real, atol=1e-9)


def test_instances_hold_numbers_alone_and_the_reader_s_arm(rover: Arm) -> None:
    S = own_chain(np.random.default_rng(0), rover)[0]
    with_it = set()
    for exercise in EXERCISES.values():
        for arguments in exercise.instances(np.random.default_rng(0), rover):
            assert len(arguments) == len(exercise.parameters)
            for argument in arguments:
                assert isinstance(argument, (float, str, np.ndarray)), exercise.name
                if np.shape(argument) == S.shape and np.array_equal(argument, S):
                    with_it.add(exercise.name)
    assert {"product_of_exponentials", "spatial_jacobian", "body_screws", "cloud", "solve_pose"} <= with_it


def test_a_slip_that_no_longer_fits_the_solution_is_noticed() -> None:
    exercise = EXERCISES["rotation_z"]
    with pytest.raises(LookupError, match="rotation_z, old: the solution has no"):
        exercise.wrong(Slip("old", "", {"not there": ""}))
    assert inspect.signature(exercise.wrong(exercise.slips[0])) == inspect.signature(exercise.model)
