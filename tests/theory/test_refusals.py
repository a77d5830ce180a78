"""What the theory refuses: every argument of every function, by its name, and what only looks like an argument."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from twistarm import joints, poe, rotations, screws
from twistarm.support.errors import InputError

EYE, HOME, S = np.eye(3), np.eye(4), np.eye(6)[:, :2]
GOOD: dict[str, Any] = {
    "R": EYE, "R1": EYE, "R2": EYE, "A": EYE, "axes": EYE, "w": EYE[0], "axis": EYE[0], "normal": EYE[2],
    "x_axis": EYE[0], "point": np.zeros(3), "rpy": np.zeros(3), "angles": np.zeros(3), "order": "ZYZ", "theta": 0.3,
    "angle": 0.3, "pitch": 0.1, "Q": np.ones(4), "P": np.ones(4), "g": HOME, "g_ab": HOME, "home": HOME, "twists": None,
    "matrix": np.zeros((4, 4)), **dict.fromkeys(("xi", "a", "b", "V", "xi_b", "F_b"), np.ones(6)),
    "screws": S, "body_screws": S, "x": np.zeros(2),
}  # fmt: skip
SPOKEN = {"R": "rotation", "Q": "quaternion|Q"}  # What an error calls some of them.
UNCHECKED = {  # For inner loops, whose callers have checked.
    "cross", "split", "log_of", "adjoint_of", "inverse_of", "exp_along", "turn_and_slide", "columns", "products",
    "motions",
}  # fmt: skip


def arguments() -> Iterator[Any]:
    for space in (rotations, screws, joints, poe):
        for name, function in inspect.getmembers(space, inspect.isfunction):
            if function.__module__ == space.__name__ and not name.startswith("_") and name not in UNCHECKED:
                for parameter in inspect.signature(function).parameters:
                    yield pytest.param(
                        function, parameter, id=f"{space.__name__.rpartition('.')[2]}.{name}-{parameter}"
                    )


@pytest.mark.parametrize(("function", "argument"), [*arguments()])
def test_an_argument_that_cannot_be_is_named(function: Callable[..., Any], argument: str) -> None:
    good = {name: GOOD[name] for name in inspect.signature(function).parameters}
    function(**good)
    wrong: list[Any] = ["banana"]
    if not isinstance(good[argument], (str, type(None))):
        wrong.append(np.full(np.shape(good[argument]), np.nan))
        wrong += [] if argument in ("theta", "angle") else [np.ones((2, 7))]
    for value in wrong:
        with pytest.raises(InputError, match=rf"\b({argument}|{SPOKEN.get(argument, argument)})\b"):
            function(**good | {argument: value})


@pytest.mark.parametrize(
    ("call", "telling"),
    [
        (lambda: rotations.exp(np.ones((2, 3)), np.ones(5)), r"w \(2,\) and theta \(5,\)"),
        (lambda: rotations.log(np.ones((3, 3))), r"not in SO\(3\)"),
        (lambda: rotations.from_xyzw([0, 0, 0, 0]), "quaternion"),
        (lambda: rotations.from_euler("ZZY", [1, 2, 3]), "ZZY"),
        (lambda: screws.vee(EYE), r"not in so\(3\).* off by 2"),
        (lambda: screws.vee(HOME), r"not in se\(3\).* off by 2"),
        (lambda: screws.bracket(np.ones((2, 6)), np.ones((3, 6))), r"a \(2,\) and b \(3,\)"),
        (lambda: screws.inverse(np.zeros((4, 4))), r"not in SE\(3\)"),
        (lambda: screws.from_angular_first(np.ones((6, 3))), "columns"),
        (lambda: joints.revolute(EYE, [0, 0, 0]), r"axis must be one vector .* got \(3, 3\)"),
        (lambda: joints.helical([0, 0, 1], [0, 0, 0], [1.0, 2.0]), "pitch"),
        (lambda: joints.spherical([0, 0, 0], np.ones((3, 3))), r"axes is not in SO\(3\)"),
        (lambda: joints.planar([0, 0, 1], x_axis=[0, 0, 2]), "along the normal"),
        (lambda: poe.fk(S, [HOME, HOME], [0, 0]), r"home pose .* got \(2, 4, 4\)"),
        (lambda: poe.fk(S, 2 * HOME, [0, 0]), r"home pose is not in SE\(3\)"),
    ],
)
def test_what_is_no_rotation_motion_or_batch(call: Callable[[], Any], telling: str) -> None:
    with pytest.raises(InputError, match=telling):
        call()
