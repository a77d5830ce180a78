"""What `solve_ik` and `solve_ik_batch` take and refuse: the same at every door, whoever looks at it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from catalogue import load
from twistarm import Approach, Arm, InputError, Pose, Position, Task, solve_ik, solve_ik_batch

ARM = load("panda")
G = ARM.fk(ARM.ready)
AXIS = np.array([0.0, 0.0, 1.0])


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
    "Task": lambda _, x: Task(with_one(G, x), np.zeros(6)),
    "theta0": lambda arm, x: solve_ik(arm, G, with_one(arm.ready, x)),
    "posture": lambda arm, x: solve_ik(arm, G, posture=with_one(arm.ready, x)),
    "position_tol": lambda arm, x: solve_ik(arm, G, position_tol=x),
    "orientation_tol": lambda arm, x: solve_ik(arm, G, orientation_tol=x),
    "max_time": lambda arm, x: solve_ik(arm, G, max_time=x),
    "batch": lambda arm, x: solve_ik_batch(arm, np.array([G, with_one(G, x)])),
    "batch in a list": lambda arm, x: solve_ik_batch(arm, [G, with_one(G, x)]),
    "batch, theta0": lambda arm, x: solve_ik_batch(arm, [G, G], np.array([with_one(arm.ready, x), arm.ready])),
    "batch, posture": lambda arm, x: solve_ik_batch(arm, [G], posture=with_one(arm.ready, x)),
    "batch, position_tol": lambda arm, x: solve_ik_batch(arm, [G], position_tol=x),
    "batch, max_time": lambda arm, x: solve_ik_batch(arm, [G], max_time=x),
}


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_refused_at_every_door(door: str, value: float) -> None:
    with pytest.raises(InputError):
        DOORS[door](ARM, value)
