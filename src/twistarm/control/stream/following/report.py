"""The report of a followed motion: how far it came, how well the joints followed, and what the loop did."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....support.caller_words import quantity
from ....support.checks import Array
from ....support.display import Brief
from ..report import Ending, StreamReport

AS_PLANNED = 0.9995
"""A share of the trajectory's speed from which on it is all of it."""


@dataclass(frozen=True, eq=False, repr=False)
class FollowReport(Brief):
    """What `follow` did.

    stream: the loop's own report, with how it ended and why. at: how far the motion came on its own time [s], below 0
    where it ended on the way to the start; duration: its length [s]. speed: at which share of its own speed it was
    followed, less than was asked for where the arm's limits did not allow more. largest_lag (n,): how far each measured
    joint was at most from the setpoint that held then [rad, m]: drives that are late lag by their delay times their
    rate. largest_error (n,): how far it was at most from all that it was commanded within the last `feedback_timeout`,
    which `tolerance` bounds and a delay does not count in.
    """

    stream: StreamReport
    at: float
    duration: float
    speed: float
    largest_lag: Array
    largest_error: Array
    joint_names: tuple[str, ...]
    units: tuple[str, ...]

    @property
    def completed(self) -> bool:
        """Whether the motion was followed to its end."""
        return self.stream.ending is Ending.ARRIVED

    @property
    def ok(self) -> bool:
        """Whether the motion was followed to its end and the arm rests there, without trouble on the way."""
        return self.completed and self.stream.ok

    def explain(self) -> str:
        """The report in lines."""
        return "\n".join([*self.followed(), self.stream.explain()])

    def followed(self) -> list[str]:
        """How far, how fast and how well, a line each."""
        if not self.stream.started:
            return ["followed: nothing"]
        way = "on the way to where it begins" if self.at < 0.0 else f"{self.at:.2f} s of {self.duration:.2f} s"
        slower = f", at {100.0 * self.speed:.3g} % of its speed" if self.speed < AS_PLANNED else ""
        return [
            f"followed: {way}{slower}",
            f"farthest from the setpoint of its time: {self._farthest(self.largest_lag)}",
            f"farthest from all setpoints of the last timeout: {self._farthest(self.largest_error)}",
        ]

    def _farthest(self, off: Array) -> str:
        j = int(np.argmax(off))
        return f"joint {self.joint_names[j]}, {quantity(float(f'{off[j]:.3g}'), self.units[j])}"
