"""The report of a followed motion: its progress, the joints' errors, and the loop."""

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
    """The result of `follow`.

    stream: the loop's report, with its ending and reason. at: the reached time of the motion [s], below 0 on the way to
    the start. duration: its length [s]. speed: the share of the planned speed, lower if the arm's limits require it.
    largest_lag (n,): the largest distance of each joint from the setpoint of the moment [rad, m]; drives lag by their
    delay times their rate. largest_error (n,): the largest distance from all setpoints within the last
    `feedback_timeout`. `tolerance` bounds it, and a delay does not count.
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
        """Whether the motion reached its end and the arm rests there, without trouble on the way."""
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
