"""Open a drawer: reach for its handle, pull it straight out, let go and step back, corners rounded in free space."""

import numpy as np
from play import play_if_asked

from twistarm import Approach, Dwell, JointMove, LineMove, load_arm, plan

LENGTH, SPEED = 0.25, 0.08  # m, m/s

arm = load_arm("rover_arm")
handle, into = np.array([1.0, 0.1, 0.6]), np.array([1.0, 0.0, 0.0])  # where it is held; from the rover into the drawer
above = np.array([0.0, 0.0, 0.12])

motion = plan(
    arm,
    [
        JointMove(Approach(handle - 0.08 * into, into), label="open gripper"),
        LineMove(Approach(handle, into), linear_speed=SPEED),
        Dwell(0.5, label="close gripper"),
        LineMove.by(-LENGTH * into, frame="base", linear_speed=SPEED, label="drawer open"),
        Dwell(0.5, label="open gripper"),
        LineMove.by(-0.06 * into, frame="base", blend=0.02),
        LineMove.by(above, frame="base"),
        JointMove("ready"),
    ],
    start="ready",
    kind="time_optimal",
)

closed, drawn = (moment for moment, label in motion.labels if label in ("close gripper", "drawer open"))
t = np.linspace(closed + 0.5, drawn, 2000)
g = arm.fk(motion(t))
way = g[:, :3, 3] - g[0, :3, 3]
off_line = np.linalg.norm(way - np.outer(way @ into, into), axis=1).max()
turned = np.arccos(np.clip((np.trace(g[0, :3, :3].T @ g[:, :3, :3], axis1=1, axis2=2) - 1) / 2, -1, 1)).max()
assert np.linalg.norm(g[0, :3, 3] - handle) < 1e-4
assert np.isclose(way[-1] @ into, -LENGTH, atol=1e-4)
assert off_line < 1e-4, "a drawer jams on less than a millimetre"
assert turned < np.radians(0.05)
speeds = np.linalg.norm(np.diff(way, axis=0), axis=1) / np.diff(t)
assert speeds.max() <= SPEED * (1 + 1e-3)

# What a firmware must hold in mind: the joints stand wherever the gripper moves.
for moment, label in motion.labels:
    if label.endswith("gripper"):
        assert np.allclose(motion(moment, order=1), 0.0, atol=1e-9), label
print(
    f"{LENGTH} m in {drawn - closed - 0.5:.2f} s, {1e6 * off_line:.2g} µm off the line; {motion.duration:.1f} s in all"
)
play_if_asked(arm, motion)
