"""What is said of a singular posture is the same whichever of the equally right singular vectors NumPy finds."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise

import numpy as np
import pytest

from catalogue import load
from twistarm import Arm, ArmBuilder, Position, diagnose, solve_ik
from twistarm.control.servo import ServoState, TwistCommand, servo_step
from twistarm.viewer.parts.gauge import Gauge
from twistarm.viewer.parts.theory import numbers

SVD, EIGH = np.linalg.svd, np.linalg.eigh


@contextmanager
def another_lapack(seed: int) -> Iterator[None]:
    """Singular vectors and eigenvectors of equal values are turned at random, and so are those of rounding."""
    rng = np.random.default_rng(seed)

    def turn(columns: np.ndarray) -> np.ndarray:
        return np.linalg.qr(rng.normal(size=(columns.shape[1],) * 2))[0]

    def groups(values: np.ndarray, count: int) -> list[slice]:
        padded = np.concatenate([values, np.zeros(count - len(values))])
        equal = np.abs(np.diff(padded)) <= 1e-12 * np.abs(values).max(initial=1e-300)
        ends = [0, *(np.flatnonzero(~equal) + 1), count]
        return [slice(*pair) for pair in pairwise(ends)]

    def svd(a: np.ndarray, full_matrices: bool = True, compute_uv: bool = True):
        if not compute_uv:
            return SVD(a, compute_uv=False)
        if a.ndim > 2 and len(a):
            parts = [svd(each, full_matrices) for each in a]
            return tuple(np.stack(each) for each in zip(*parts, strict=True))
        U, s, Vt = SVD(a)
        if U.ndim > 2 or not s.size:
            return SVD(a, full_matrices)
        least = 1e-12 * s[0]
        for group in groups(s, len(s)):
            if s[group.start] > least:
                Q = turn(U[:, group])
                U[:, group], Vt[group] = U[:, group] @ Q, Q.T @ Vt[group]
        rank = int((s > least).sum())
        U[:, rank:], Vt[rank:] = U[:, rank:] @ turn(U[:, rank:]), turn(Vt[rank:].T).T @ Vt[rank:]
        return (U, s, Vt) if full_matrices else (U[:, : len(s)], s, Vt[: len(s)])

    def eigh(a: np.ndarray):
        values, vectors = EIGH(a)
        for group in groups(values, len(values)):
            vectors[:, group] = vectors[:, group] @ turn(vectors[:, group])
        return values, vectors

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(np.linalg, "svd", svd)
        patch.setattr(np.linalg, "eigh", eigh)
        yield


def planar(normal: list[float], along: list[float]) -> Arm:
    """Three parallel axes, a metre apart: stretched at zeros, along an axis of the tool."""
    arm, home = ArmBuilder("planar"), np.eye(4)
    for k, name in enumerate("abc"):
        arm = arm.revolute(name, normal, (np.array(along) * k).tolist(), lower=-3, upper=3)
    home[:3, 3] = np.array(along) * 3
    return arm.tool(home).build()


def gantry() -> Arm:
    """Two slides, x and y: equal singular values everywhere."""
    return ArmBuilder("gantry").prismatic("x", [1, 0, 0], lower=-1, upper=1).prismatic(
        "y", [0, 1, 0], lower=-1, upper=1
    ).tool(np.eye(4)).build()  # fmt: skip


def slide() -> Arm:
    """One slide: two directions in which the tool never moves."""
    return ArmBuilder("slide").prismatic("x", [0.6, 0.8, 0], lower=-1, upper=1).tool(np.eye(4)).build()


BUILT: dict[str, Callable[[], Arm]] = {
    "planar in x and y": lambda: planar([0, 0, 1], [1, 0, 0]),
    "planar in y and z": lambda: planar([1, 0, 0], [0, 0, 1]),
    "gantry": gantry,
    "slide": slide,
}

ARMS = {**{name: (lambda name=name: load(name)) for name in ("rover_arm", "scara", "panda")}, **BUILT}


def on_the_page(arm: Arm) -> list[str]:
    return [str(numbers(arm, theta)["standing"]) for theta in (np.zeros(arm.n), arm.ready)]


def by_the_gauge(arm: Arm) -> list[object]:
    gauge = Gauge(arm)
    return [gauge.words(theta, None)["lacks"] for theta in (np.zeros(arm.n), np.full(arm.n, 1e-2), arm.ready)]


def by_the_servo(arm: Arm) -> list[str]:
    said = []
    for theta in (np.zeros(arm.n), arm.ready):
        state = ServoState.at(arm, theta)
        twists = np.vstack([np.eye(6), -np.eye(6)]) * np.repeat([0.1, 0.5], 3)
        said += [servo_step(arm, state, TwistCommand(twist, "base"), 0.01)[1].reason for twist in twists]
    return said


def by_the_doctor(arm: Arm) -> list[str]:
    return [finding.what for finding in diagnose(arm)]


def by_inverse_kinematics(arm: Arm) -> list[str]:
    p = arm.fk(arm.ready)[:3, 3]
    return [solve_ik(arm, Position(p + arm.reach * away), arm.ready).explain() for away in np.eye(3) * 0.1]


OF_ALL = [(name, who) for name in ARMS for who in (on_the_page, by_the_gauge, by_the_servo)]
OF_BUILT = [(name, who) for name in BUILT for who in (by_the_doctor, by_inverse_kinematics)]


@pytest.mark.parametrize(("name", "who"), [*OF_ALL, *OF_BUILT])
def test_it_is_the_same_with_another_lapack(name: str, who: Callable[[Arm], list[str]]) -> None:
    said = who(ARMS[name]())
    for seed in range(3):
        with another_lapack(seed):
            assert who(ARMS[name]()) == said


@pytest.mark.parametrize(("name", "lost"), [("planar in x and y", "x"), ("planar in y and z", "z"), ("rover_arm", "z")])
def test_what_is_lost_is_what_the_arm_has_beside(name: str, lost: str) -> None:
    """A stretched arm lacks the way along itself; it also lacks what it has nowhere, and that is no news."""
    said = numbers(ARMS[name](), np.zeros(ARMS[name]().n))["standing"]
    assert said.endswith(f", singular: the tool cannot move along its {lost} axis.")
