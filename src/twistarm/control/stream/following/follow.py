"""follow: a trajectory on a robot, from where the arm is to where the motion ends."""

from __future__ import annotations

from collections.abc import Callable

from numpy.typing import ArrayLike

from ....arm.arm import Arm
from ....planning import Trajectory
from ....support.checks import require_callback
from ..driving import drive
from ..interlock import Interlock
from ..links.inbox import FEEDBACK_TIMEOUT
from ..protocols import Clock, Feedback, Sink
from .control import FollowControl
from .cycle import START_TOLERANCE, TRACKING_TOLERANCE, FollowCycle, Following
from .report import FollowReport


def follow(
    arm: Arm,
    trajectory: Trajectory,
    sink: Sink,
    feedback: Feedback,
    *,
    rate: float = 100.0,
    speed: float = 1.0,
    approach: bool = False,
    start_tolerance: ArrayLike = START_TOLERANCE,
    tolerance: ArrayLike = TRACKING_TOLERANCE,
    feedback_timeout: float = FEEDBACK_TIMEOUT,
    velocity_mode: bool = False,
    control: FollowControl | None = None,
    interlock: Interlock | None = None,
    handle_signals: bool = True,
    on_cycle: Callable[[FollowCycle], object] | None = None,
    clock: Clock | None = None,
) -> FollowReport:
    """Follow `trajectory` on a robot: its positions and rates go to `sink` at `rate` [Hz], while `feedback` is watched.

    It begins only where the arm is measured to be at the trajectory's start, each joint within `start_tolerance`; what
    is left is a straight joint move from the measured position, within the limits. With `approach` that may begin
    anywhere: nothing looks for obstacles on its way.

    The motion's own time s runs at a rate r = ds/dt of `speed`, less where the trajectory would exceed the arm's
    velocity or acceleration limits, those of its motors too. To pause and to stop, r goes to 0 and the arm comes to
    rest on its path; to resume, it rises again. Its slope is at most 4 1/s, and no greater than what keeps the
    accelerations q' dr/dt + q'' r² within their limits at each moment: while a joint of the motion brakes at its limit,
    the motion cannot be slowed further.

    A joint farther than `tolerance` from all that was commanded within the last `feedback_timeout` ends the motion, and
    so does an emergency stop of `interlock`: each joint brakes by itself, as fast as its limit allows, off the path.
    Whatever else is not well brings the arm to rest along its path. It goes on once the joint state is fresh again;
    after a stop of the interlock `control.resume` goes on, once it is enabled; after 3 s without a joint state at
    rest the motion is given up. Ctrl-C, signals and devices that fail end it as they end `run`.

    Args:
        arm: The arm; limits that it does not give are the usual ones, as in `run`.
        trajectory: The motion, of the arm's joints in any order, without jumps, at rest at both ends.
        sink: Where setpoints go.
        feedback: Where the joint state comes from.
        rate: Cycles per second [Hz].
        speed: The share of the trajectory's own speed, above 0 and at most 1.
        approach: Whether to move to the start first, straight in joint space, where the arm is elsewhere.
        start_tolerance: How far from the start the arm may be without that, one number or (n,) [rad, m].
        tolerance: Greatest distance of a joint from what was commanded, one number or (n,) [rad, m].
        feedback_timeout: Greatest age of the joint state [s].
        velocity_mode: Whether the robot takes rates alone, as in `run`.
        control: What pauses, resumes and stops the motion, from any thread, or None.
        interlock: The switch that allows motion, or None.
        handle_signals: Whether SIGTERM and SIGHUP end it, as in `run`.
        on_cycle: Called with each `FollowCycle`, or None; it must be quick.
        clock: The clock, by default the system's monotonic one.

    Returns:
        The `FollowReport`: how far the motion came, how well the joints followed, how it ended.

    Raises:
        InputError: The trajectory is of other joints, jumps, or does not begin and end at rest; another argument cannot
            be.
        LimitError: The trajectory leaves the arm's position limits.
    """
    require_callback(on_cycle, "on_cycle", "(cycle)")
    following = Following(
        arm, trajectory, sink, feedback, rate=rate, speed=speed, approach=approach,
        start_tolerance=start_tolerance, tolerance=tolerance, feedback_timeout=feedback_timeout,
        velocity_mode=velocity_mode, control=control, interlock=interlock,
    )  # fmt: skip
    report = drive(following, clock=clock, handle_signals=handle_signals, on_cycle=on_cycle)
    motion, off = following.motion, (following.largest_lag, following.largest_error)
    return FollowReport(report, following.at, motion.duration, following.pace, *off, motion.joint_names, motion.units)
