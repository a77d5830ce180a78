"""Carry a full cup over the edge of a table and past a post: the tool stays level, proven at every instant."""

import numpy as np
from play import play_if_asked

from twistarm import FreeMove, JointMove, Keep, Position, Scene, assert_free, load_arm, plan, solve_ik

TILT = np.radians(2.0)  # more spills
UP = np.array([0.0, 0.0, 1.0])
TABLE, EDGE = 0.32, 0.06  # m: the height of the table's top, and of the rim round it

# The gripper points forward and holds the cup upright: its axis is the one of the tool that points up at the start.
arm = load_arm("rover_arm_6dof")
scene = Scene(arm, margin=0.005)
scene.add_box("table", (0.3, 0.5, 0.04), (0.85, 0.35, TABLE - 0.02))
scene.add_box("edge", (0.3, 0.02, EDGE), (0.85, 0.11, TABLE + EDGE / 2))
scene.add_cylinder("post", 0.02, 0.5, (0.95, -0.02, 0.7))
level = Keep.level(TILT)
cup = arm.fk(arm.ready)[:3, :3].T @ UP

# From beside the table onto it. Straight in joint space the cup would tilt, or the arm would hit something.
start = solve_ik(arm, level.at(arm, arm.fk(arm.ready)).constrain(Position([0.85, -0.3, 0.4]))).require()
goal = Position([0.85, 0.3, TABLE + 0.1])


def tilt(theta: np.ndarray) -> float:
    """The largest angle of the cup from upright [rad]."""
    return float(np.arccos(np.clip((arm.fk(theta)[..., :3, :3] @ cup)[..., 2], -1.0, 1.0)).max())


motion = plan(arm, FreeMove(goal, keep=level), start=start, scene=scene)
straight = plan(arm, JointMove(motion.waypoints[-1]), start=start)
t = np.linspace(0.0, 1.0, 2000)
knock = scene.first_collision(straight.breakpoints, straight.coefficients)
tilted = tilt(straight(t * straight.duration))
print(f"straight: the cup tilts by {np.degrees(tilted):.1f}°", "and something is hit" if knock else "")
print(f"kept: {np.degrees(tilt(motion(t * motion.duration))):.2f}° at most, in {motion.duration:.1f} s")
assert knock is not None or tilted > TILT
assert tilt(motion(t * motion.duration)) <= TILT
assert_free(arm, motion, scene)
play_if_asked(arm, motion)
