"""Swing a latch: hold its free end and lead it about its hinge, the hand turning with it, then push it home."""

import numpy as np
from play import play_if_asked

from twistarm import Approach, ArcMove, Dwell, JointMove, LineMove, load_arm, plan, rotations

RADIUS, ANGLE = 0.12, np.radians(-100)  # m; clockwise for who looks at the panel

arm = load_arm("rover_arm")
normal = np.array([-1.0, 0.0, 0.0])  # out of the panel, toward the rover
hinge = np.array([0.95, 0.0, 0.7])
end = hinge + RADIUS * np.array([0.0, 0.0, 1.0])  # of the latch, upright at first

motion = plan(
    arm,
    [
        JointMove(Approach(end + 0.05 * normal, -normal), label="open gripper"),
        LineMove(Approach(end, -normal), linear_speed=0.1),
        Dwell(0.5, label="close gripper"),
        ArcMove.about(normal, hinge, ANGLE, linear_speed=0.1, label="latch swung"),
        LineMove.by(-0.01 * normal, frame="base", linear_speed=0.02, label="open gripper"),
        LineMove.by(0.06 * normal, frame="base"),
    ],
    start="ready",
)

begin, swung = (moment for moment, label in motion.labels if label in ("close gripper", "latch swung"))
t = np.linspace(begin + 0.5, swung, 2000)
g = arm.fk(motion(t))
arm_of_latch = g[:, :3, 3] - hinge
radius = np.linalg.norm(arm_of_latch, axis=1)
turned = rotations.log(g[:, :3, :3] @ g[0, :3, :3].T)
swing = np.arctan2(np.cross(arm_of_latch[0], arm_of_latch) @ normal, arm_of_latch @ arm_of_latch[0])
assert np.abs(radius - RADIUS).max() < 1e-4, "the hinge gives way to no more"
assert np.abs(arm_of_latch @ normal).max() < 1e-4, "in the panel's plane"
assert np.abs(turned - np.outer(swing, normal)).max() < np.radians(0.05), "the hand turns with the latch"
assert np.isclose(swing[-1], ANGLE, atol=1e-3)
off = 1e6 * np.abs(radius - RADIUS).max()
print(f"{np.degrees(swing[-1]):.1f}° in {swung - begin - 0.5:.2f} s, at most {off:.2g} µm off the arc")
play_if_asked(arm, motion)
