"""Replay a planned motion through the loop on joints that answer 50 ms late; then pull one plug, then the other."""

import tempfile
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from twistarm import ServoState, load_arm, plan_joint
from twistarm.stream import Cycle, Reading, Replay, SimulatedJoints, read_recording, run

LATENCY, PERIOD, TIMEOUT = 0.05, 0.01, 0.2  # s: of the drives, of the loop, of commands and joint states

arm = load_arm("rover_arm")
goal = arm.ready + [0.2, 0.3, -0.4, 0.2, 1.0]
motion = plan_joint(arm, [arm.ready, goal], kind="quintic")
with tempfile.TemporaryDirectory() as folder:
    recording = read_recording(arm, motion.to_csv(Path(folder) / "motion.csv", dt=0.02))


def replay(source_ends: float = np.inf, feedback_ends: float = np.inf) -> tuple[Any, ...]:
    """The report, and times, rates, joints and troubles of the cycles; a cut wire's last word grows old."""
    clock = SimpleNamespace(time=0.0)  # time passes only while the loop sleeps: the same run every time, and at once
    clock.now = lambda: clock.time
    clock.sleep_until = lambda moment: setattr(clock, "time", max(clock.time, moment))
    source, joints = Replay(arm, recording), SimulatedJoints(arm, arm.ready, latency=LATENCY, clock=clock.now)
    said, rows = SimpleNamespace(), []

    def command(now: float, state: ServoState) -> Reading:
        if now < source_ends:
            said.command = source.read(now, state)
        last: Reading = said.command
        return replace(last, age=max(0.0, now - source_ends))

    def state(now: float) -> Any:
        if now < feedback_ends:
            said.state = joints.read(now)
        return said.state

    def note(cycle: Cycle) -> None:
        assert cycle.setpoint is not None
        rows.append((cycle.time, cycle.setpoint.theta_dot, joints.theta, cycle.reason))

    # Whatever has the method `read` is a source, or a feedback.
    report = run(
        arm, SimpleNamespace(read=command), joints, SimpleNamespace(read=state), rate=1 / PERIOD,
        duration=motion.duration + 1.0, clock=clock, on_cycle=note,
    )  # fmt: skip
    return report, *(np.array(column) for column in zip(*rows, strict=True))


report, t, rates, theta, _ = replay()
assert report.ok
assert np.allclose(theta[-1], goal, atol=1e-6), "the joints end where the motion does"
assert (np.abs(rates) <= arm.limits.velocity * (1 + 1e-9)).all()
assert (np.abs(np.diff(rates, axis=0)) <= arm.limits.acceleration * PERIOD * (1 + 1e-9)).all()

# Of all shifts in time, which one makes the plan and the joints agree best?
shifts = np.arange(0.0, 0.15, 0.001)
apart = [np.abs(motion(np.clip(t - shift, 0, motion.duration)) - theta).max() for shift in shifts]
lag = shifts[np.argmin(apart)]
assert LATENCY <= lag <= LATENCY + 2 * PERIOD, "the drives' latency, and a cycle of the loop"
print(f"replayed in {t[-1]:.2f} s; the joints are {1e3 * lag:.0f} ms behind the plan")

# A wire is cut in the middle of the motion: the arm stands after the timeout and the time that braking takes.
cut, braking = motion.duration / 2, (arm.limits.velocity / arm.limits.acceleration).max()
for wire in ("source_ends", "feedback_ends"):
    report, t, rates, theta, troubles = replay(**{wire: cut})
    stands = t[rates.any(axis=1)].max() + PERIOD
    assert cut + TIMEOUT < stands <= cut + TIMEOUT + braking
    later = theta[t > stands + LATENCY + 0.2]
    assert np.abs(later - later[-1]).max() < 1e-6, "and so do the joints"
    print(f"{wire.replace('_', ' ')}: at rest {stands - cut:.2f} s later; {next(filter(None, troubles))}")
