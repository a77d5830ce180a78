"""Options that the loop of the servo and the loop of a trajectory share."""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from ...support.checks import as_flag, as_positive, require
from .interlock import Interlock
from .links.inbox import FEEDBACK_TIMEOUT


@dataclass(frozen=True, eq=False)
class StreamOptions:
    """Options of `run`, `Streaming`, `follow` and `Following`.

    rate [Hz]: cycles per second. A period may not exceed the servo's longest step (`ServoSettings.max_dt`).

    feedback_timeout [s]: greatest age of the joint state.

    tolerance [rad, m]: greatest distance of a joint from what was commanded, one number or (n,). None: 0.2 for the
    servo, where an operator corrects, and 0.1 for a trajectory.

    velocity_mode: whether the robot takes rates alone.

    interlock: the switch that allows motion. None: a new one, enabled.

    Raises InputError for a rate or timeout that is not positive, or a value of another type.
    """

    rate: float = 100.0
    feedback_timeout: float = FEEDBACK_TIMEOUT
    tolerance: ArrayLike | None = None
    velocity_mode: bool = False
    interlock: Interlock | None = None

    def __post_init__(self) -> None:
        for name in ("rate", "feedback_timeout"):
            object.__setattr__(self, name, as_positive(getattr(self, name), name))
        as_flag(self.velocity_mode, "velocity_mode")
        if self.interlock is not None:
            require(self.interlock, Interlock, "interlock", "as Interlock() is")


USUAL = StreamOptions()
