"""What a servo does, for the pages: its status in words, and a gauge of singularities and limits."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import Any

import numpy as np

from ...arm.abilities import ANGULAR, LINEAR, NO_MOTION, largest_rank, span
from ...arm.arm import Arm
from ...arm.usual_limits import usually_limited
from ...control.servo import AnyCommand, PoseCommand, ServoOutput, ServoSettings
from ...control.servo.settings import ServoBounds, bounds_of
from ...control.stream import Cycle
from ...support.checks import Array, require
from ...support.directions import leading, nearest_axes
from ..memo import Memo
from ..protocol.messages import Message
from .show import NO_REPORT, Part, Show


def servo_words(answer: Cycle | ServoOutput) -> dict[str, Any]:
    """The answer of a servo or its loop in words.

    {"status": status of a ServoOutput or null, "joint": name or null, "reason": text, "share": executed share of the
    command from 0 to 1, or null}.
    """
    if isinstance(answer, ServoOutput):
        return _words(answer, True)
    require(answer, Cycle, "answer", "as stream.run hands to on_cycle, or a ServoOutput, or None")
    if answer.setpoint is None or not answer.delivered:
        return {**NO_REPORT, "reason": answer.reason}
    reading = answer.reading
    idle = reading is not None and reading.idle and reading.reason == answer.reason
    return NO_REPORT if idle else _words(answer.setpoint.output, reading is not None and _moves(reading.command))


def _words(output: ServoOutput, asked: bool) -> dict[str, Any]:
    valid = asked and output.status != "STALE"
    return {
        "status": output.status,
        "joint": output.joint,
        "reason": output.explain(),
        "share": round(output.share, 2) if valid else None,  # whole percents: pages get only changes
    }


def _moves(command: AnyCommand | None) -> bool:
    """Whether a command asks for a motion: a stop is no share of anything."""
    return command is not None and (isinstance(command, PoseCommand) or bool(command.numbers.any()))


NEAR = 0.05
"""Share of the range between two limits that counts as near a limit, as in the joints' rows."""

LEAST = {"rad": np.pi / 36, "m": 0.01}
"""Least distance [rad, m] that counts as near: 5°, 1 cm."""

DIRECTIONS = ("along x", "along y", "along z", "about x", "about y", "about z")

JOINTS_TO_POINT = 5
"""Joints that position and point a tool. With fewer, the position alone can be singular and is examined first."""

NO_GAUGE: dict[str, Any] = {
    "sigma": None, "below": ServoSettings().singularity_threshold, "lacks": None,
    "joint": None, "unit": None, "room": None, "near": None, "end": None,
}  # fmt: skip
"""The message without a servo."""


class Gauge(Part):
    """The part that shows how near the arm is to singularities and limits. It is silent without a servo."""

    def __init__(self, arm: Arm) -> None:
        self.arm = arm
        self._words = Memo(self.words)

    def messages(self, show: Show) -> Iterator[Message]:
        """The messages with singular value and limit.

        sigma: smallest singular value [rad per rad], singular below `below`. lacks: its direction in base axes.

        joint: the joint or motor that the servo says is limited, else the one nearest to a position limit. It has
        `room` [unit] to its `end`, and the warning distance `near`. All are null without a servo or without a limit.
        """
        limited = show.report["joint"] if str(show.report["status"]).endswith("_LIMIT") else None
        yield {"type": "gauge", **(self._words(show.theta, limited) if show.driven else NO_GAUGE)}

    @cached_property
    def bounds(self) -> ServoBounds:
        """Those of a servo with standard settings."""
        return bounds_of(usually_limited(self.arm), ServoSettings())

    def words(self, theta: Array, limited: str | None) -> dict[str, Any]:
        """The fields of the message at theta (n,), where the servo says that joint `limited` is."""
        sigma, u = self.least(theta)
        lacks = DIRECTIONS[leading(np.abs(u))] if u.any() else None
        return {
            "sigma": round(sigma, 5),
            "below": self.bounds.singularity_threshold,
            "lacks": lacks,
            **self.room(theta, limited),
        }

    def least(self, theta: Array) -> tuple[float, Array]:
        """The least singular value of the directions that the arm has elsewhere, and its direction (6,) in base axes.

        0 and no direction if one is missing here. Metres are measured in the reach. For equal values it is the
        direction in their span nearest to an axis. From five joints on the Jacobian is of the whole twist, else of the
        position, then of the rotation that keeps it.
        """
        least, u = np.inf, np.zeros(6)
        levels = [(LINEAR + ANGULAR, ())] if self.arm.n >= JOINTS_TO_POINT else [(LINEAR, ()), (ANGULAR, LINEAR)]
        for components, before in levels:
            U, sigma = span(self.arm, theta, components, before, "base")
            if len(sigma) < largest_rank(self.arm, components, before, "base"):
                return 0.0, np.zeros(6)
            if len(sigma) and sigma[-1] < least:
                equal = U[:, sigma <= sigma[-1] + NO_MOTION]
                least, u = float(sigma[-1]), np.zeros(6)
                u[list(components)] = nearest_axes(equal @ equal.T, 1)[:, 0]
        return least, u

    def room(self, theta: Array, limited: str | None) -> dict[str, Any]:
        """The joint or motor `limited`, else the one nearest to a limit relative to its warning distance."""
        motion, arm = self.bounds.motion, self.arm
        motors = arm.actuators.motor_units[: len(motion.names) - arm.n] if arm.actuators else ()
        units = (*motors, *arm.units)
        x, lower, upper = motion.C @ theta + motion.c, motion.limits.lower, motion.limits.upper
        room = np.minimum(x - lower, upper - x)
        near = np.array([LEAST[unit] for unit in units])
        near = np.where(np.isfinite(upper - lower), np.maximum(NEAR * (upper - lower), near), near)
        row = motion.names.index(limited) if limited in motion.names else int(np.argmin(room / near))
        if not np.isfinite(room[row]):
            return dict.fromkeys(("joint", "unit", "room", "near", "end"))
        return {
            "joint": motion.names[row],
            "unit": units[row],
            "room": round(float(room[row]), 6),
            "near": float(near[row]),
            "end": "lower" if x[row] - lower[row] < upper[row] - x[row] else "upper",
        }
