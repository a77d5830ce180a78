"""Follow a trajectory on a robot, from the arm's position to the end, and report it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ....arm.arm import Arm
from ....planning import Trajectory
from ....support.checks import Array, require_callback
from ....support.display import Brief
from ....support.messages import Quantity, Text, joined
from ..driving import drive
from ..options import USUAL, StreamOptions
from ..protocols import Clock, Feedback, Sink
from ..report import Ending, StreamReport
from .cycle import START_TOLERANCE, FollowControl, FollowCycle, Following

AS_PLANNED = 0.9995
"""Share of the trajectory's speed that counts as full speed."""


@dataclass(frozen=True, eq=False, repr=False)
class FollowReport(Brief):
    """The result of `follow`.

    stream: the loop's report, with its ending and reason. at: the reached time of the motion [s], below 0 on the way to
    the start. duration: its length [s]. speed: the share of the planned speed, lower if the arm's limits require it.
    largest_lag (n,): the largest distance of each joint from the current setpoint [rad, m]. Drives lag by delay times
    rate. largest_error (n,): the largest distance from all setpoints within the last `feedback_timeout`. `tolerance`
    bounds it, and a delay does not count.
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
        """Whether the motion ended as planned, with the arm at rest and no trouble."""
        return self.completed and self.stream.ok

    def explain(self) -> str:
        """The report in lines."""
        return joined("\n", [*self.followed(), self.stream.explain()])

    def followed(self) -> list[str]:
        """How far, how fast and how well, a line each."""
        if not self.stream.started:
            return ["followed: nothing"]
        way = "on the way to where it begins" if self.at < 0.0 else f"{self.at:.2f} s of {self.duration:.2f} s"
        slower = f", at {100.0 * self.speed:.3g} % of its speed" if self.speed < AS_PLANNED else ""
        return [
            f"followed: {way}{slower}",
            self._farthest("the setpoint of its time", self.largest_lag),
            self._farthest("all setpoints of the last timeout", self.largest_error),
        ]

    def _farthest(self, what: str, off: Array) -> str:
        j = int(np.argmax(off))
        away = Quantity(float(off[j]), self.units[j], 3)
        return Text("farthest from {what}: joint {joint}, {away}", what=what, joint=self.joint_names[j], away=away)


def follow(
    arm: Arm,
    trajectory: Trajectory,
    sink: Sink,
    feedback: Feedback,
    options: StreamOptions = USUAL,
    *,
    speed: float = 1.0,
    approach: bool = False,
    start_tolerance: ArrayLike = START_TOLERANCE,
    control: FollowControl | None = None,
    handle_signals: bool = True,
    on_cycle: Callable[[FollowCycle], object] | None = None,
    clock: Clock | None = None,
) -> FollowReport:
    """Follow `trajectory` on a robot. Positions and rates go to `sink`, and `feedback` is watched.

    The motion begins only if each measured joint is within `start_tolerance` of the trajectory's start. A straight
    joint move inside the limits covers the rest. With `approach` this move may begin anywhere; it avoids no obstacles.

    The motion's time s advances at the rate r = ds/dt of `speed`. It is less if a velocity or acceleration limit of the
    arm or its motors needs it. For a pause or stop r goes to 0 and the arm rests on its path. To resume, r rises again.
    |dr/dt| is at most 4 1/s, and keeps q' dr/dt + q'' r² within the acceleration limits. While a joint brakes at its
    limit, the motion cannot be slowed further.

    A joint farther than `tolerance` from all setpoints of the last `feedback_timeout` ends the motion. So does an
    emergency stop of `interlock`. Each joint then brakes as fast as its limit allows, off the path. Other trouble
    brings the arm to rest along its path. It continues with a fresh joint state. After a stop of the interlock, enable
    it and call `control.resume`. After 3 s at rest without a joint state the motion ends. Ctrl-C, signals and failing
    devices end it as in `run`.

    Args:
        arm: The arm. Usual limits replace missing ones, as in `run`.
        trajectory: The motion, with the arm's joints in any order, without jumps, at rest at both ends.
        sink: Where setpoints go.
        feedback: Where the joint state comes from.
        options: Rate, timeout of the joint state, tolerance, velocity mode and interlock, as in `run`.
        speed: The share of the trajectory's own speed, above 0 and at most 1.
        approach: Whether to move straight in joint space to the start first, if the arm is elsewhere.
        start_tolerance: Allowed distance from the start without that, one number or (n,) [rad, m].
        control: What pauses, resumes and stops the motion, from any thread, or None.
        handle_signals: Whether SIGTERM and SIGHUP end it, as in `run`.
        on_cycle: Called with each `FollowCycle`, or None; it must be quick.
        clock: The clock, by default the system's monotonic one.

    Returns:
        The `FollowReport`: how far the motion came, how well the joints followed, how it ended.

    Raises:
        InputError: The trajectory has other joints, jumps, or an end that is not at rest. Or another argument is
            unusable.
        LimitError: The trajectory leaves the arm's position limits.
    """
    require_callback(on_cycle, "on_cycle", "(cycle)")
    following = Following(
        arm, trajectory, sink, feedback, options, speed=speed, approach=approach, start_tolerance=start_tolerance,
        control=control,
    )  # fmt: skip
    report = drive(following, clock=clock, handle_signals=handle_signals, on_cycle=on_cycle)
    motion, off = following.motion, (following.largest_lag, following.largest_error)
    return FollowReport(report, following.at, motion.duration, following.pace, *off, motion.joint_names, motion.units)
