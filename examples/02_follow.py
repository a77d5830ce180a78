"""Follow a planned motion on joints that answer 50 ms late: pause and resume it on its path, then pull the plug."""

import tempfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from twistarm import load_arm, load_trajectory, plan_joint, save_trajectory
from twistarm.control.stream import Ending, FollowControl, FollowCycle, FollowOptions, SimulatedJoints, follow

LATENCY, PERIOD = 0.05, 0.01  # s: of the drives, of the loop

arm = load_arm("rover_arm")
goal = arm.ready + [0.2, 0.3, -0.4, 0.2, 1.0]
with tempfile.TemporaryDirectory() as folder:  # as it would come to the robot: in a file
    planned = plan_joint(arm, [arm.ready, goal])
    motion = load_trajectory(arm, save_trajectory(planned, Path(folder) / "motion.csv"))


def followed(pause: float = np.inf, feedback_ends: float = np.inf) -> tuple[Any, ...]:
    """The report, and times, setpoints and joints of the cycles; paused for a second, or with a joint state cut off."""
    clock = SimpleNamespace(time=0.0)  # time passes only while the loop sleeps: the same run every time, and at once
    clock.now = lambda: clock.time
    clock.sleep_until = lambda moment: setattr(clock, "time", max(clock.time, moment))
    joints, control = SimulatedJoints(arm, arm.ready, latency=LATENCY, clock=clock.now), FollowControl()
    said, rows = SimpleNamespace(), []

    def state(now: float) -> Any:  # a cut wire's last word grows old
        if now < feedback_ends:
            said.state = joints.read(now)
        return said.state

    def operate(cycle: FollowCycle) -> None:
        if cycle.setpoint is None:  # it has ended
            return
        rows.append((cycle.time, cycle.setpoint.theta, joints.theta))
        if pause <= cycle.time < pause + 1.0:
            control.pause()
        else:
            control.resume()

    # Whatever has the method `read` is a feedback.
    feedback = SimpleNamespace(read=state)
    options = FollowOptions(rate=1 / PERIOD, control=control)
    report = follow(arm, motion, joints, feedback, options, clock=clock, on_cycle=operate)
    return report, *(np.array(column) for column in zip(*rows, strict=True))


def within_limits(told: Any) -> bool:
    """Whether velocities and accelerations between the setpoints keep the arm's limits."""
    rates = np.diff(told, axis=0) / PERIOD
    shares = rates / arm.limits.velocity, np.diff(rates, axis=0) / PERIOD / arm.limits.acceleration
    return all(np.abs(share).max() <= 1 + 1e-6 for share in shares)


report, t, told, theta = followed()
assert report.ok
assert np.allclose(told, motion(t + PERIOD), atol=1e-9), "the plan, to the last digit"
assert np.allclose(theta[-1], goal, atol=0.01)
assert within_limits(told)
# Of all shifts in time, which one makes the plan and the joints agree best?
shifts = np.arange(0.0, 0.15, 0.001)
lag = shifts[np.argmin([np.abs(motion(t - shift) - theta).max() for shift in shifts])]
assert LATENCY - PERIOD <= lag <= LATENCY + 2 * PERIOD, "the drives' latency, and a cycle of the loop"
print(f"followed in {t[-1]:.2f} s; the joints are {1e3 * lag:.0f} ms behind the plan")

report, t, told, theta = followed(pause=0.5 * motion.duration)
assert report.ok
assert within_limits(told), "while it slows down and speeds up too"
stood = PERIOD * (~np.diff(told, axis=0).any(axis=1)).sum()
path = motion(np.linspace(0.0, motion.duration, 5001))
off = max(np.abs(path - each).max(axis=1).min() for each in told)
assert stood > 0.5
assert off < 1e-3, "it never leaves its path"
print(f"paused for a second: it stood for {stood:.2f} s of that, and arrived in {t[-1]:.2f} s")

report, t, told, theta = followed(feedback_ends=0.2 * motion.duration)
assert report.stream.ending is Ending.FEEDBACK_FAILED
assert report.stream.at_rest
assert within_limits(told)
assert np.abs(theta[-1] - told[-1]).max() < 1e-6, "the joints stand where they were told to"
print(f"plug pulled: at rest {report.at:.2f} s into {report.duration:.2f} s of the motion; {report.stream.reason}")
