"""Commands of the servo: a tool twist, joint rates, or a pose to reach and hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm, require_arm
from ...support.checks import (
    Array,
    Matrix,
    Row,
    as_floats,
    as_pose,
    as_positive,
    as_twist,
    frozen,
    require_choice,
    require_mapping,
    require_one,
)
from ...support.display import Brief
from ...support.errors import InputError, listed, quote

TOOL, BASE = "tool", "base"
FRAMES = (TOOL, BASE)

# Greatest rates [m/s, rad/s] and positions [m] of an arm. Larger ones come from wrong units or broken messages.
FASTEST, FARTHEST = 1e4, 1e6
# Names of held components in (vx, vy, vz, wx, wy, wz).
HELD = {"position": (True, True, True, False, False, False), "orientation": (False, False, False, True, True, True)}


@dataclass(frozen=True, eq=False, init=False, repr=False)
class TwistCommand(Brief):
    """Move the tool: twist (v, w) (6,) [m/s, rad/s] of its origin, in tool or base axes.

    frame="tool": the body twist V^b = (g⁻¹ ġ)^∨. frame="base": (ṗ, ω), the tool origin's velocity and the angular
    velocity, both in base axes. This is not the spatial twist. Its v is the velocity of the point at the base's origin.

    hold: components to keep where the hold began, along the axes of `frame`. It is "position", "orientation" or six
    booleans in the order of the twist. These have priority, drift is corrected, and their twist must be 0.

    Raises InputError for a twist that is not six finite numbers, an unknown frame, or a moving held component.
    """

    twist: Array
    frame: str
    hold: str | Sequence[bool] | None
    held: tuple[bool, ...] = field(init=False, repr=False)
    numbers: Array = field(init=False, repr=False)
    flags: int = field(init=False, repr=False)
    kind: ClassVar[int] = 2

    def __init__(self, twist: Row, frame: str = TOOL, hold: str | Sequence[bool] | None = None) -> None:
        six, held = _six(twist, "twist"), held_components(hold)
        require_choice(frame, FRAMES, "frame")
        if any(six[k] != 0.0 for k in range(6) if held[k]):
            raise InputError(f"a held component cannot be commanded: hold={hold!r}, twist={six.tolist()}")
        flags = int(frame == BASE) + sum(2 << k for k in range(6) if held[k])
        values = {"twist": six, "frame": frame, "hold": hold, "held": held, "numbers": six, "flags": flags}
        for name, value in values.items():
            object.__setattr__(self, name, value)


@dataclass(frozen=True, eq=False, init=False, repr=False)
class JogCommand(Brief):
    """Move the joints: their rates (n,) [rad/s, m/s], base to tip. See also `JogCommand.of`."""

    theta_dot: Array
    numbers: Array = field(init=False, repr=False)
    flags: ClassVar[int] = 0
    kind: ClassVar[int] = 1

    def __init__(self, theta_dot: Row) -> None:
        if isinstance(theta_dot, Mapping):
            raise InputError("theta_dot must be one number per joint; of names take JogCommand.of(arm, {'elbow': 0.1})")
        rates = _moderate(as_floats(theta_dot, "theta_dot"), "theta_dot", FASTEST)
        if rates.ndim != 1:
            raise InputError(f"theta_dot must be one number per joint, shape (n,); got {rates.shape}")
        for name in ("theta_dot", "numbers"):
            object.__setattr__(self, name, frozen(rates))

    @classmethod
    def of(cls, arm: Arm, rates: Mapping[str, float]) -> JogCommand:
        """The rates of some joints by name, the others at rest.

        Args:
            arm: The arm.
            rates: {joint: rate} [rad/s, m/s].

        Raises:
            InputError: A rate is not a finite number.
            UnknownNameError: The arm has no such joint.
        """
        given = require_mapping(rates, "rates", "{'elbow': 0.1}")
        return cls(require_arm(arm).theta_from(dict.fromkeys(arm.joint_names, 0.0) | dict(given)))


@dataclass(frozen=True, eq=False, init=False, repr=False)
class PoseCommand(Brief):
    """Bring the tool to the pose g (4, 4) in base coordinates and hold it.

    The way is straight and turns about one axis.

    With tight acceleration limits the tool may pass the pose by millimetres and come back.

    `velocity` (6,) [m/s, rad/s]: the velocity (ṗ, ω) of the pose in base axes. With it the tool follows without lag,
    otherwise some hundredths of a second behind. The speeds [m/s, rad/s] bound the approach.
    """

    g: Array
    velocity: Array
    linear_speed: float
    angular_speed: float
    numbers: Array = field(init=False, repr=False)
    flags: ClassVar[int] = 1
    kind: ClassVar[int] = 3

    def __init__(
        self, g: Matrix, velocity: Row = (0.0,) * 6, linear_speed: float = 0.25, angular_speed: float = 1.0
    ) -> None:
        pose = require_one(as_pose(g, "g"), "g", 2)
        _moderate(pose, "g", FARTHEST)
        speeds = {"linear_speed": linear_speed, "angular_speed": angular_speed}
        checked = {name: _speed(speed, name) for name, speed in speeds.items()}
        moving = _six(velocity, "velocity")
        numbers = frozen([*pose.ravel(), *moving, *checked.values()])
        for name, value in {"g": frozen(pose), "velocity": moving, **checked, "numbers": numbers}.items():
            object.__setattr__(self, name, value)


# `kind`, `flags` (1 for base axes, 2 << k for held component k) and `numbers` say the same to the compiled core.
AnyCommand = TwistCommand | JogCommand | PoseCommand

# What a step accepts: a command, six numbers for a twist in tool axes, or None.
CommandLike = AnyCommand | Row | None


def held_components(hold: Any) -> tuple[bool, ...]:
    """Six booleans for "position", "orientation", None or six booleans; InputError for anything else."""
    if hold is None:
        return (False,) * 6
    if isinstance(hold, str) and hold in HELD:
        return HELD[hold]
    row = hold.ndim == 1 if isinstance(hold, np.ndarray) else isinstance(hold, Sequence) and not isinstance(hold, str)
    several = tuple(hold) if row else ()
    if len(several) == 6 and all(isinstance(component, (bool, np.bool_)) for component in several):
        return tuple(bool(component) for component in several)
    raise InputError(f"hold must be {listed(HELD)} or six booleans (vx, vy, vz, wx, wy, wz); got {quote(hold)}")


def _speed(value: float, name: str) -> float:
    return float(_moderate(np.array(as_positive(value, name)), name, FASTEST))


def _six(values: ArrayLike, name: str) -> Array:
    return frozen(_moderate(require_one(as_twist(values, name), name, 1), name, FASTEST))


def _moderate(values: Array, name: str, most: float) -> Array:
    if np.abs(values).max(initial=0.0) > most:
        raise InputError(f"{name} must be at most {most:g} in size, in SI units; got {np.abs(values).max():g}")
    return values
