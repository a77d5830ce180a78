"""What `solve_ik` and `solve_ik_batch` take and refuse: the same at every door, whoever looks at it."""

from __future__ import annotations

import subprocess
import sys
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from catalogue import load
from twistarm import (
    Approach,
    Arm,
    ArmBuilder,
    InputError,
    JointMove,
    LineMove,
    NotConvergedError,
    PathError,
    Pose,
    Position,
    TolerancedPose,
    UnitsWarning,
    plan,
    solve_ik,
    solve_ik_batch,
)
from twistarm.support.checks import as_pose
from twistarm.support.errors import RoundedPoseWarning

ARM = load("panda")
G = ARM.fk(ARM.ready)
AXIS = np.array([0.0, 0.0, 1.0])
MILLIMETRES = G * [1, 1, 1, 1000]
MILLIMETRES[3, 3] = 1.0


def with_one(array: Any, value: float) -> np.ndarray:
    """The same numbers, the last of the first row another: of a pose, where it is along x."""
    changed = np.array(array, dtype=float)
    changed[(0,) * (changed.ndim - 1) + (-1,)] = value
    return changed


DOORS: dict[str, Callable[[Arm, float], Any]] = {
    "a bare pose": lambda arm, x: solve_ik(arm, with_one(G, x)),
    "a bare pose in a list": lambda arm, x: solve_ik(arm, with_one(G, x).tolist()),
    "Pose": lambda _, x: Pose(with_one(G, x)),
    "Position": lambda _, x: Position(with_one(AXIS, x)),
    "Approach, position": lambda _, x: Approach(with_one(AXIS, x), AXIS),
    "Approach, direction": lambda _, x: Approach(AXIS, with_one(AXIS, x)),
    "Approach, axis": lambda _, x: Approach(AXIS, AXIS, with_one(AXIS, x)),
    "TolerancedPose": lambda _, x: TolerancedPose(with_one(G, x), np.zeros(6)),
    "batch": lambda arm, x: solve_ik_batch(arm, np.array([G, with_one(G, x)])),
    "batch in a list": lambda arm, x: solve_ik_batch(arm, [G, with_one(G, x)]),
    "batch, theta0": lambda arm, x: solve_ik_batch(arm, [G, G], np.array([with_one(arm.ready, x), arm.ready])),
    **{
        f"{solve.__name__}, {name}": lambda arm, x, solve=solve, asked=asked, name=name: solve(
            arm, asked, **{name: with_one(arm.ready, x) if name in ("theta0", "posture") else x}
        )
        for solve, asked in ((solve_ik, G), (solve_ik_batch, [G]))
        for name in ("theta0", "posture", "position_tol", "orientation_tol", "max_time")
    },
}


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_refused_at_every_door(door: str, value: float) -> None:
    with pytest.raises(InputError):
        DOORS[door](ARM, value)


LONE: list[tuple[Any, dict[str, Any], str]] = [
    (np.eye(3), {}, "target"),
    (G, {"theta0": np.zeros((2, 7))}, "theta0"),
    (G, {"theta0": with_one(ARM.ready, 1e17)}, "panda_joint7"),
    (G, {"orientation_tol": 3.0}, "172°"),
    (G, {"restarts": 2.5}, "restarts"),
    (G, {"rng": True}, "rng"),
    (G, {"posture": "home"}, "'middle'"),
    (G, {"posture": np.zeros((2, 7))}, "posture"),
]
MANY: list[tuple[Any, dict[str, Any], str]] = [
    (np.eye(4), {}, "(N, 4, 4)"),
    (Pose(np.eye(4)), {}, "targets"),
    ("poses", {}, "targets"),
    ([np.eye(4), None], {}, "targets[1]"),
    (np.stack([np.eye(4), np.diag([1, 1, -1, 1.0])]), {}, "targets[1]"),
    ([Position(AXIS)] * 2, {"theta0": np.zeros((3, 7))}, "(2, 7)"),
    ([G], {"theta0": with_one(ARM.ready, 1e17)}, "panda_joint7"),
    ([], {"threads": 0}, "threads"),
    ([], {"progress": 3}, "progress"),
]


@pytest.mark.parametrize(
    ("solve", "asked", "how", "text"), [*((solve_ik, *row) for row in LONE), *((solve_ik_batch, *row) for row in MANY)]
)
def test_misuse_is_refused(solve: Any, asked: Any, how: dict[str, Any], text: str) -> None:
    with pytest.raises(InputError) as caught:
        solve(ARM, asked, **how)
    assert text in str(caught.value)
    with pytest.raises(InputError, match="arm must be an Arm"):
        solve("panda", asked)


def test_millimetres_and_degrees_are_reported() -> None:
    far = Position(1000.0 * G[:3, 3])
    assert "millimetres" in solve_ik(ARM, far).explain()
    with pytest.raises(NotConvergedError, match="millimetres"):
        solve_ik(ARM, far).require()
    assert "millimetres" not in solve_ik(ARM, Position(5.0 * G[:3, 3])).explain()
    degrees = np.degrees(ARM.ready)
    assert "degrees" in solve_ik(ARM, G, degrees).notes[0]
    for given in (degrees, degrees.tolist(), np.tile(degrees, (3, 1)).tolist()):
        with pytest.warns(UnitsWarning, match="degrees"):
            ARM.fk(given)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ARM.fk((ARM.limits.upper + 0.5).tolist())
        turning = ArmBuilder("x").revolute("j", AXIS, [1, 0, 0]).tool(np.eye(4)).build()
        np.testing.assert_allclose(turning.fk(np.array([0.3 + 6 * np.pi])), turning.fk([0.3]), atol=1e-12)


def test_a_move_in_millimetres_is_reported() -> None:
    for move in (LineMove.by([0.0, 0.0, 50.0]), JointMove(MILLIMETRES)):
        with pytest.raises((PathError, NotConvergedError), match="from the base looks like millimetres"):
            plan(load("scara"), move)
    with pytest.raises(PathError) as caught:
        plan(load("scara"), LineMove.by([0.0, 0.0, 5.0]))
    assert "millimetres" not in str(caught.value)


TILTED = G.copy()
TILTED[:3, 0] *= 1 + 8e-12

WRITTEN: dict[str, dict[str, Any]] = {
    "lists": {"target": G.tolist(), "theta0": ARM.ready.tolist()},
    "rows in a tuple": {"target": tuple(G), "theta0": tuple(ARM.ready)},
    "column by column": {"target": np.asfortranarray(G), "theta0": np.array([ARM.ready, ARM.ready]).T[:, 1]},
    "merely almost a rotation": {"target": TILTED},
    "numbers of NumPy's": {"position_tol": np.float64(1e-6), "orientation_tol": np.float32(1e-6), "rng": np.int64(0),
                           "restarts": np.int32(100), "max_time": np.int64(10)},
    "the ready configuration by its name": {"theta0": "ready"},
}  # fmt: skip


@pytest.mark.parametrize("how", WRITTEN)
def test_however_numbers_are_written_the_answer_is_the_same(how: str) -> None:
    given = {"target": G, "theta0": ARM.ready} | WRITTEN[how]
    solution = solve_ik(ARM, **given)
    assert solution.converged
    np.testing.assert_allclose(solution.theta, solve_ik(ARM, G, ARM.ready).theta, atol=1e-6)
    batch = solve_ik_batch(ARM, [given.pop("target")], **given)
    np.testing.assert_allclose(batch.theta[0], solution.theta, atol=1e-6)


@pytest.mark.parametrize("kind", [np.float32, np.float16, np.int64, np.uint8, np.bool_, ">f8"])
def test_every_type_of_array_is_read(kind: Any) -> None:
    whole = np.eye(4)
    whole[0, 3] = 1.0
    given = np.repeat(whole.astype(kind), 2, axis=1)[:, ::2]
    np.testing.assert_array_equal(Pose(given).g, whole)
    np.testing.assert_array_equal(solve_ik(ARM, given, restarts=1).target.g, whole)
    np.testing.assert_array_equal(solve_ik_batch(ARM, given[None], restarts=1)[0].target.g, whole)


def test_a_rotation_is_rounded_by_the_core_as_in_python() -> None:
    rng = np.random.default_rng(3)
    for size in (1e-15, 1e-13, 1e-9, 4e-7):
        g = ARM.fk(ARM.random_theta(rng))
        g[:3, :3] += rng.uniform(-size, size, (3, 3))
        np.testing.assert_allclose(Pose(g).g, as_pose(g), atol=1e-14, rtol=0)
    g[0, 0] += 1e-4
    with pytest.warns(RoundedPoseWarning):
        Pose(g)


DAEMON = """
import sys, threading, time, numpy as np, twistarm
arm = twistarm.load_arm("panda")
far = arm.fk(arm.ready) + np.diag([0.0, 0.0, 5.0], 1)
many, thetas = np.tile(far, (2000, 1, 1)), np.tile(arm.ready, (100_000, 1))
state = twistarm.ServoState.at(arm, arm.ready)
calls = {
    "one": lambda: twistarm.solve_ik(arm, far),
    "batch": lambda: twistarm.solve_ik_batch(arm, many),
    "threads": lambda: twistarm.solve_ik_batch(arm, many, threads=2, progress=lambda *_: time.sleep(0.001)),
    "fk": lambda: arm.fk(thetas),
    "servo": lambda: twistarm.servo_step(arm, state, np.full(6, 0.01), 0.01),
}
def work(call):
    while True:
        call()
for name in sys.argv[1:]:
    threading.Thread(target=work, args=(calls[name],), daemon=True).start()
time.sleep(0.1)
"""


@pytest.mark.parametrize("calls", [["threads"], ["one", "batch", "fk", "servo"]])
def test_a_program_may_end_while_daemon_threads_work(calls: list[str]) -> None:
    for _ in range(2):
        done = subprocess.run([sys.executable, "-c", DAEMON, *calls], capture_output=True, text=True, timeout=60)
        assert (done.returncode, done.stderr) == (0, "")
