"""Follow a trajectory on a robot: start, pause, resume and stop along its path, and report it."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm
from ...planning import Trajectory
from ...support.checks import Array, as_flag, as_positive, frozen, require, require_callback
from ...support.display import Brief
from ...support.errors import InputError, one_line
from ...support.messages import Quantity, Text, joined
from ..servo import ServoOutput, ServoReason, ServoSettings, ServoState
from .cycles import Cycle, Loop, StreamError, run_loop
from .motion_clock import SLOPE, LimitedMotion, MotionClock, motion_of, way_there, why_elsewhere
from .protocols import EMERGENCY_STOP, LONGEST_REASON, Clock, Feedback, LoopOptions, Setpoint, Sink, joint_tolerances
from .report import MOVED, Ending, StreamReport

# Allowed distance of a joint from the command [rad, m]. Nobody corrects it by hand, unlike with a servo.
TRACKING_TOLERANCE = 0.1
# Allowed distance of a joint from the motion's start [rad, m]: half a degree or a centimetre.
START_TOLERANCE = 0.01
PATIENCE = 3.0  # Seconds without a joint state after which a motion of a resting arm is given up.
SETTLING = 1.0  # Seconds at the motion's end for the measured arm to arrive.
HALF_WAY = 0.5  # Rate of the clock below which it can always be slowed: a quarter of the accelerations.
AS_PLANNED = 0.9995  # Share of the trajectory's speed that counts as full speed.

PAUSED = "paused"


class FollowControl:
    """Whether a followed motion goes on, as programs and operators have last said. Thread-safe.

    Paused, the arm comes to rest along its path and waits there for `resume`. Stopped, it does so and the motion ends,
    which nothing takes back.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._pause = ""
        self._stopped = False

    def pause(self, reason: str = PAUSED) -> None:
        """Come to rest along the path, and wait there; the first reason counts until `resume`."""
        with self._lock:
            self._pause = self._pause or one_line(require(reason, str, "reason", "in words"), LONGEST_REASON) or PAUSED

    def resume(self) -> None:
        """Go on along the path."""
        with self._lock:
            self._pause = ""

    def toggle(self) -> None:
        """Pause a motion that goes on, resume one that is paused."""
        with self._lock:
            self._pause = "" if self._pause else PAUSED

    def stop(self) -> None:
        """Come to rest along the path, and end there."""
        self._stopped = True

    @property
    def pause_reason(self) -> str:
        """Why the motion is paused, "" where it goes on."""
        return self._pause

    @property
    def paused(self) -> bool:
        """Whether the motion is paused."""
        return bool(self._pause)

    @property
    def stopped(self) -> bool:
        """Whether the motion is to end."""
        return self._stopped


@dataclass(frozen=True, eq=False)
class FollowOptions(LoopOptions):
    """Options of `follow` and `Following`: those of `LoopOptions`, and these.

    tolerance [rad, m]: half of the servo's, because no operator corrects the arm.

    speed: the share of the trajectory's own speed, above 0 and at most 1.

    approach: whether to move straight in joint space to the start first, if the arm is elsewhere.

    start_tolerance [rad, m]: allowed distance from the start without that, one number or (n,).

    control: what pauses, resumes and stops the motion, from any thread. None: a new one.

    Raises InputError for a number that is not positive, a speed above 1, or a value of another type.
    """

    tolerance: ArrayLike = TRACKING_TOLERANCE
    speed: float = 1.0
    approach: bool = False
    start_tolerance: ArrayLike = START_TOLERANCE
    control: FollowControl | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "speed", as_positive(self.speed, "speed"))
        if self.speed > 1.0:
            raise InputError(f"speed is a share of the trajectory's own, above 0 and at most 1; got {self.speed:g}")
        as_flag(self.approach, "approach")
        if self.control is not None:
            require(self.control, FollowControl, "control", "as FollowControl() is")


USUAL_FOLLOW = FollowOptions()


@dataclass(frozen=True, eq=False, repr=False)
class FollowCycle(Cycle):
    """The events of one cycle of `follow`, and the progress.

    at: the motion's time [s], below 0 on the way to its start. `duration`: its length [s]. rate: the speed of its time,
    0 … 1. error (n,): each joint's distance from all setpoints of the last `feedback_timeout` [rad, m]. lag (n,): the
    distance from the present setpoint. None: unknown. labels: the labels passed in this cycle, such as "close gripper".
    """

    at: float = 0.0
    duration: float = 0.0
    rate: float = 0.0
    error: Array | None = None
    lag: Array | None = None
    labels: tuple[str, ...] = ()


class Following(Loop[FollowCycle]):
    """A trajectory followed cycle by cycle, for loops with a timer; `follow` has its own.

    The arguments are those of `follow`. `largest_error` (n,): the largest distance of each joint from all setpoints
    within the last `feedback_timeout`. `largest_lag` (n,): the largest distance from the setpoint of the moment [rad,
    m].
    """

    def __init__(
        self, arm: Arm, trajectory: Trajectory, sink: Sink, feedback: Feedback, options: FollowOptions = USUAL_FOLLOW
    ) -> None:
        require(options, FollowOptions, "options", "as FollowOptions() is")
        super().__init__(arm, sink, feedback, options, ServoSettings())
        self.control = FollowControl() if options.control is None else options.control
        self.motion = motion_of(self.arm, trajectory)
        self._leg = self._main = LimitedMotion.of(self._commanded_arm, self.motion)
        self.speed, self.approach = options.speed, options.approach
        self.largest_error, self.largest_lag = np.zeros(self.arm.n), np.zeros(self.arm.n)
        self._near = joint_tolerances(options.start_tolerance, self.arm, "start_tolerance")
        self._clock = MotionClock(0.0, 0.0)
        self._joins = 0.0  # the motion's time where the way to it ends [s]
        self._astray = False
        self._seen = self._arrived = inf
        self._labels = deque(self.motion.labels)

    @property
    def at(self) -> float:
        """The motion's time [s], below 0 on the way to its start."""
        if not self._on_the_way:
            return self._clock.time
        return self._joins or self._clock.time - self._leg.motion.duration

    @property
    def pace(self) -> float:
        """The share of the trajectory's own speed that it is followed at."""
        return min(self.speed, self._main.rate)

    @property
    def longest_braking(self) -> float:
        """Seconds for the arm to stop along its path, or at once if it has left the path."""
        left = 0.0 if self._astray else (self._leg.motion.duration - self._clock.time) / max(self._clock.rate, HALF_WAY)
        return super().longest_braking + left + 1.0 / SLOPE

    @property
    def _on_the_way(self) -> bool:
        """Whether it is still to come to where the trajectory begins, or goes on."""
        return self._leg is not self._main

    def _events(self, now: float) -> FollowCycle:
        theta, blind = self._measure(now)
        if not blind or self._seen == inf or now < self._seen:
            self._seen = now
        elif self.at_rest and now - self._seen >= PATIENCE:
            raise StreamError(Ending.FEEDBACK_FAILED, blind)
        if self.state is None:
            return self._record(now, blind)
        lag = None if theta is None else frozen(np.abs(theta - self.state.theta))
        error = None if theta is None else self._watch.error(theta)
        strayed = "" if theta is None else self._watch.deviation(theta)
        barrier = self.interlock.barrier
        if barrier:  # enabling does not resume the motion
            self.control.pause(barrier)
        self._astray = bool(strayed) or self.interlock.word == EMERGENCY_STOP
        paused = self.control.pause_reason or ("stopped" if self.control.stopped else "")
        self.tally.count(blind=blind, barred=barrier, uncommanded="" if barrier else paused)
        reason = strayed or barrier or blind or self._time_fault(now) or paused
        if theta is not None and not strayed:
            self._rejoin(theta, now, bool(reason))
        setpoint = self._braked(now, reason) if self._astray else self._along(now, reason)
        undelivered = self._send(setpoint)
        ending, why = self._ending(strayed, theta, now)
        reason = why or "; ".join(filter(None, (reason, undelivered)))
        return self._record(now, reason, ending, theta, setpoint, lag, error)

    def _starts(self, theta: Array) -> bool:
        starts = super()._starts(theta)
        elsewhere = starts and why_elsewhere(self.arm, theta, self.motion.waypoints[0], self._near)
        if elsewhere and not self.approach:
            raise StreamError(Ending.ELSEWHERE, elsewhere)
        return starts

    def _start(self, theta: Array, now: float) -> None:
        """Start at theta (n,), on the way to where the motion is joined."""
        super()._start(theta, now)
        way = way_there(self._commanded_arm, theta, self.motion(self._joins))
        self._leg, self._clock = LimitedMotion.of(self._commanded_arm, way), MotionClock(0.0, 0.0)

    def _rejoin(self, theta: Array, now: float, holds: bool) -> None:
        """Go on from the measured theta where others have moved the resting arm, straight back to the path."""
        assert self.state is not None
        distance, rests = theta - self.state.theta, self.at_rest
        unseen = self._watch.returned and rests and bool((np.abs(distance) > MOVED).any())
        if unseen or (not holds and self._watch.moved_by_others(distance)):
            self._joins = self._joins if self._on_the_way else self._clock.time
            self._start(theta, now)
            distance = np.zeros(self.arm.n)
        self._watch.rest(distance if holds and rests else None, now)

    def _along(self, now: float, hold: str) -> Setpoint:
        """A step along the path: toward rest for a reason to `hold`, else toward the requested speed."""
        assert self.state is not None
        if self._on_the_way and self._clock.time >= self._leg.motion.duration:
            self._leg, self._clock = self._main, MotionClock(self._joins, 0.0)
        rate, dt = 0.0 if hold else min(self.speed, self._leg.rate), self._elapsed(now)
        clock = self._clock
        if self._time_fault(now):  # who hears nothing for so long stands by now
            clock = MotionClock(clock.time, 0.0)
        elif clock.time == 0.0:  # nothing moves there, at whatever rate
            clock = MotionClock(0.0, rate)
        clock = clock.after(dt, self._leg, rate)
        theta = frozen(self._leg.motion(clock.time))
        rates = frozen((theta - self.state.theta) / dt)
        moving = bool(rates.any())
        output = ServoOutput.stale(rates, hold)
        if not hold:
            output = replace(output, reason=ServoReason.MOVING, scale=1.0)
        setpoint = self._moved(ServoState(theta, rates), output, now, follow=moving or not hold)
        self._clock = clock
        return setpoint

    def _coming_to_rest(self, now: float) -> Setpoint:
        if self._astray:
            return super()._coming_to_rest(now)
        return self._along(now, "coming to rest")

    def _ending(self, strayed: str, theta: Array | None, now: float) -> tuple[Ending | None, str]:
        """Whether the motion is over, and why."""
        if strayed:
            return Ending.STRAYED, strayed
        if self._astray:
            return Ending.STOPPED, f"{self.interlock.barrier} {self._where}"
        if self.state is None or self.state.theta_dot.any():
            return None, ""
        if self.control.stopped:
            return Ending.STOPPED, self._where
        if self._on_the_way or self._clock.time < self.motion.duration:
            return None, ""
        self._arrived = min(self._arrived, now)
        there = theta is not None and bool((np.abs(theta - self.motion.waypoints[-1]) <= self._near).all())
        return (Ending.ARRIVED, "") if there or now - self._arrived >= SETTLING else (None, "")

    @property
    def _where(self) -> str:
        if self._on_the_way and not self._joins:
            return "on the way to where it begins"
        return f"at {self.at:.2f} s of {self.motion.duration:.2f} s"

    def _record(
        self,
        now: float,
        reason: str,
        ending: Ending | None = None,
        theta: Array | None = None,
        setpoint: Setpoint | None = None,
        lag: Array | None = None,
        error: Array | None = None,
    ) -> FollowCycle:
        if error is not None:
            self.largest_error = np.maximum(self.largest_error, error)
        if lag is not None:
            self.largest_lag = np.maximum(self.largest_lag, lag)
        labels = []
        while self.state is not None and self._labels and self._labels[0][0] <= self.at:
            labels.append(self._labels.popleft()[1])
        return FollowCycle(
            now, None, theta, setpoint, reason, ending, self.tally.delivered, self.interlock.word,
            at=self.at, duration=self.motion.duration, rate=self._clock.rate, error=error, lag=lag,
            labels=tuple(labels),
        )  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class FollowReport(Brief):
    """The result of `follow`.

    stream: the loop's report, with its ending and reason. at: the reached time of the motion [s], below 0 on the way to
    the start. duration: its length [s]. speed: the share of the planned speed, lower if the arm's limits require it.
    largest_lag (n,): the largest distance of each joint from the current setpoint [rad, m]. Drives lag by delay times
    rate. largest_error (n,): the largest distance from all setpoints within the last `feedback_timeout`. A delay does
    not count, nor how far a joint goes on at its rate until a late cycle. Beyond `tolerance` the motion has ended.
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
        lines = [f"followed: {way}{slower}"]
        for what, off in (("setpoint of its time", self.largest_lag), ("setpoints of a timeout", self.largest_error)):
            j = int(np.argmax(off))
            away = Quantity(float(off[j]), self.units[j], 3)
            template = "farthest from the {what}: joint {joint}, {away}"
            lines.append(Text(template, what=what, joint=self.joint_names[j], away=away))
        return lines


def follow(
    arm: Arm,
    trajectory: Trajectory,
    sink: Sink,
    feedback: Feedback,
    options: FollowOptions = USUAL_FOLLOW,
    *,
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
    limit, the motion cannot be slowed further. Where others have moved the resting arm by more than 0.01 rad or m, the
    motion goes on from there: straight in joint space to where it was on its path.

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
        options: Speed, tolerances, approach and control, and what all loops share.
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
    following = Following(arm, trajectory, sink, feedback, options)
    report = run_loop(following, clock=clock, handle_signals=handle_signals, on_cycle=on_cycle)
    motion, off = following.motion, (following.largest_lag, following.largest_error)
    return FollowReport(report, following.at, motion.duration, following.pace, *off, motion.joint_names, motion.units)
