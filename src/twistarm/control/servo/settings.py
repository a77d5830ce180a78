"""Settings of the servo: margins, thresholds, and the length that compares metres with radians."""

from __future__ import annotations

from dataclasses import dataclass

from ...arm.abilities import NO_MOTION
from ...support.checks import as_number, as_positive, require_choice
from ...support.errors import InputError

SLIDE, STOP = "slide", "stop"
ON_UNREACHABLE = (SLIDE, STOP)


@dataclass(frozen=True)
class ServoSettings:
    """Settings of `servo_step`.

    length [m]: makes metres and radians comparable in singular values. None: the arm's `reach`.

    damping [s]: the τ of the servo's law (docs/servo.md), at least three steps. A twist of size V, in rad/s, is exact
    where the Jacobian's singular values are above √(τ V). More damping is calmer near singularities.

    on_unreachable: "slide" or "stop", at a joint limit or the end of the reach. The tool slides along as far as it can,
    or slows down and stops on course.

    singularity_threshold: singular values below this (rad per rad, see `Manipulability`) count as singular.

    position_margin [rad or m]: distance that joints keep from their position limits.

    max_dt [s]: longer steps are refused, because the arm was unwatched for so long.

    Raises InputError for numbers that are not positive (the margin may be 0).
    """

    length: float | None = None
    singularity_threshold: float = 0.04
    damping: float = 0.03
    on_unreachable: str = SLIDE
    position_margin: float = 0.0
    max_dt: float = 0.1

    def __post_init__(self) -> None:
        for name in ("length", "singularity_threshold", "damping", "max_dt"):
            value = getattr(self, name)
            if value is not None or name != "length":
                object.__setattr__(self, name, as_positive(value, name))
        if self.singularity_threshold <= NO_MOTION:
            raise InputError(f"singularity_threshold must be more than {NO_MOTION:g}, which counts as no motion at all")
        require_choice(self.on_unreachable, ON_UNREACHABLE, "on_unreachable")
        object.__setattr__(self, "position_margin", as_number(self.position_margin, "position_margin", 0.0))
