"""Twists from sensor_msgs/Joy: none before every axis was seen at rest and the button let go."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np

from twistarm import InputError

UNUSED = -1
"""An axis that the joystick has not got."""

AT_REST = 0.05
"""Of full deflection: what a worn stick may be off."""


@dataclass(frozen=True)
class JoyMapping:
    """Which axes of a joystick move what.

    axes: six indices, for (vx, vy, vz, wx, wy, wz), −1 for none. rest: what each of them says when nobody touches it, 0
    for a stick, 1 for most triggers. scale (6,) [m/s, rad/s]: the twist at full deflection, signs included; an axis'
    deflection is (value − rest) / (1 + |rest|), −1 … 1. deadband: deflections below are none; beyond, they begin at 0.
    dead_man: the button that must be held. Raises InputError for anything else.
    """

    axes: Sequence[int]
    rest: Sequence[float]
    scale: Sequence[float]
    deadband: float
    dead_man: int

    def __post_init__(self) -> None:
        if len(self.axes) != 6 or min(self.axes) < UNUSED or self.dead_man < 0:
            raise InputError(
                f"a joystick needs six axes, counted from 0, {UNUSED} for none, and a dead man's button; got "
                f"{list(self.axes)} and {self.dead_man}"
            )
        if len(self.scale) != 6 or not all(map(isfinite, self.scale)):
            raise InputError(f"joy_scale must be six numbers [m/s, rad/s]; got {list(self.scale)}")
        if not 0.0 <= self.deadband < 1.0:
            raise InputError(f"joy_deadband must be from 0 to below 1; got {self.deadband!r}")
        said = len(self.rest) == 6 and all(abs(rest) <= 1.0 for axis, rest in self._used)
        if not said:
            raise InputError(
                f"joy_rest must say what each axis of joy_axes {list(self.axes)} reads when nobody touches it, from -1 "
                f"to 1, as `ros2 topic echo /joy` shows it: 0.0 for a stick, 1.0 for most triggers; got "
                f"{list(self.rest)}"
            )

    @property
    def used(self) -> bool:
        """Whether any axis is."""
        return bool(self._used)

    @property
    def _used(self) -> list[tuple[int, float]]:
        return [(axis, rest) for axis, rest in zip(self.axes, self.rest, strict=False) if axis != UNUSED]

    def deflections(self, message: Any) -> tuple[list[float], bool]:
        """Six deflections, −1 … 1, and whether the button is held; InputError where the joystick lacks one of them."""
        axes, buttons = message.axes, message.buttons
        if max(self.axes) >= len(axes) or self.dead_man >= len(buttons):
            raise InputError(
                f"the joystick has {len(axes)} axes and {len(buttons)} buttons; the mapping asks for axis "
                f"{max(self.axes)} and button {self.dead_man}, counted from 0"
            )
        values = [
            0.0 if axis == UNUSED else (axes[axis] - rest) / (1.0 + abs(rest))
            for axis, rest in zip(self.axes, self.rest, strict=True)
        ]
        if not all(map(isfinite, values)):
            raise InputError(f"the joystick says {list(axes)}; its axes must be finite")
        return values, bool(buttons[self.dead_man])

    def twist(self, deflections: Sequence[float]) -> list[float]:
        """The twist (6,) of six deflections."""
        size = np.clip((np.abs(deflections) - self.deadband) / (1.0 - self.deadband), 0.0, 1.0)
        twist: list[float] = (np.sign(deflections) * size * np.asarray(self.scale)).tolist()
        return twist


class Joystick:
    """A joystick in somebody's hand; after a silence longer than `timeout` [s] it may be another one, or unplugged.

    Drivers say 0 for an axis that was never touched, which for a trigger that rests at 1 is half pressed; and a button
    may be stuck. So nothing counts until every axis was at rest, and the button let go, at some moment since.
    """

    def __init__(self, mapping: JoyMapping, timeout: float) -> None:
        self._mapping = mapping
        self._timeout = timeout
        self._heard = -np.inf
        self._released = False
        self._moving: list[int] = []
        self._begin()

    def twist(self, message: Any, now: float) -> list[float] | None:
        """The twist that a message asks for at `now` [s]; None while the button is not held.

        InputError while it is held but an axis, or the button, was not yet seen at rest.
        """
        deflections, held = self._mapping.deflections(message)
        if not 0.0 <= now - self._heard <= self._timeout:
            self._begin()
        self._heard = now
        self._released = self._released or not held
        self._moving = [k for k in self._moving if abs(deflections[k]) > max(AT_REST, self._mapping.deadband)]
        if not held:
            return None
        if self._moving or not self._released:
            raise InputError(f"the joystick counts once it was seen at rest: {self._wanted(message)}")
        return self._mapping.twist(deflections)

    def _begin(self) -> None:
        self._released = False
        self._moving = [k for k, axis in enumerate(self._mapping.axes) if axis != UNUSED]

    def _wanted(self, message: Any) -> str:
        mapping = self._mapping
        axes = [f"axis {mapping.axes[k]} reads {message.axes[mapping.axes[k]]:g}, at rest {mapping.rest[k]:g}"
                for k in self._moving]  # fmt: skip
        return "; ".join(axes if self._released else [*axes, f"let go of button {mapping.dead_man}"])
