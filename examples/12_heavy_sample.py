"""Lift a heavy sample as fast as the motors can: torque limits along the motion, judged by Pinocchio's dynamics."""

import numpy as np
from play import play_if_asked

from twistarm import Approach, JointMove, LineMove, Trajectory, active_limits, load_arm, payload, plan

SAMPLE = 5.0, (0.0, 0.0, 0.03)  # kg, and where its mass is in tool axes [m]

arm = load_arm("rover_arm", limits={"acceleration": 12.0, "jerk": 240.0})
g = arm.fk(arm.ready)
ground, axis = g[:3, 3] + [0.05, 0.2, -0.3], g[:3, 2]
lift = [
    JointMove(Approach(ground, axis)),
    LineMove.by([0.0, 0.0, 0.15], frame="base", label="off the ground", blend=0.03),
    JointMove("ready"),
]


def used(motion: Trajectory) -> float:
    """The largest share of any effort at 5,000 instants, with the sample."""
    t = np.linspace(0.0, motion.duration, 5000)
    torques = arm.inverse_dynamics(motion(t), motion(t, 1), motion(t, 2), payload=SAMPLE)
    return float(np.abs(torques / arm.limits.effort).max())


durations = {}
for kind in ("time_optimal", "s_curve"):
    free = plan(arm, lift, kind=kind)
    motion = plan(arm, lift, kind=kind, torques=True, payload=SAMPLE)
    assert used(free) > 1.0, "without torque limits a motor would have to give more than it can"
    assert used(motion) < 1.001
    assert motion.duration > free.duration
    durations[kind] = motion.duration
    print(f"{kind}: {free.duration:.2f} s would need {used(free):.0%} of an effort")
    print(f"{kind}: {motion.duration:.2f} s keep all efforts")
assert durations["time_optimal"] < durations["s_curve"]

# Which limit to raise for a faster motion, and what the arm could carry along it.
motion = plan(arm, lift, kind="time_optimal", torques=True, payload=SAMPLE)
limiting = {limit.describe() for limit in active_limits(arm, motion, segments=lift, torques=True, payload=SAMPLE)}
print("limited by", ", ".join(sorted(limiting)))
assert any(words.startswith("torque of joint") for words in limiting)
assert np.isclose(payload(arm, motion, offset=SAMPLE[1]).mass.min(), SAMPLE[0], rtol=0.01)
play_if_asked(arm, motion)
