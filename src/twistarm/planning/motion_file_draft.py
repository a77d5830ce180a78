"""A first motion.toml for an arm: a valid motion, with comments to fill in."""

from __future__ import annotations

import numpy as np

from ..arm.arm import Arm
from ..description.companions.toml_entries import toml_key

STEP = {"rad": 0.2, "m": 0.05}
"""How far the first joint that can moves away from the ready pose."""


def draft_motion_file(arm: Arm) -> str:
    """Return the text of a motion.toml for this arm, with every kind of segment."""
    x, y, z = np.round(arm.fk(arm.ready)[:3, 3], 3).tolist()
    joint, value = _first_move(arm)
    return f"""\
# A motion of the arm {arm.name}: twistarm plan ARM motion.toml -o motion.csv
# Metres and radians. A line that begins with # is a note or an example: take the # away to make it count.
start = "ready"              # a pose's name, the joints' values, or {{ joint = value, … }} of every joint
# kind = "s_curve"           # or "time_optimal", "quintic"
# degrees = true             # angles below are degrees
# linear_speed = 0.2           # m/s, for segments that give none; angular_speed is in rad/s
# unwrap = true              # continuous joints go to configurations by the shorter way
# position_tol = 1e-4        # m that the tool may be off its targets and lines; orientation_tol is in rad
# scene = "scene.toml"       # obstacles: the motion must not collide with them, nor the arm with itself

# [limits]                   # in place of the arm's own
# acceleration = 3.0

[[segment]]
joint = {{ {toml_key(joint)} = {value} }}    # a joint move; joints that are left out stay
# blend = 0.02               # round the corner to the next segment inside this radius [m]; without it: stop
# velocity_scaling = 0.5     # share of the joints' velocity limits
label = "close gripper"      # what is due at its end, carried into files

[[segment]]
dwell = 0.5                  # s

# [[segment]]                # round the obstacles of `scene`; to the goals of a joint move
# free = "ready"

# [[segment]]                # the tool along a straight line: 5 cm along its own z axis
# line = {{ by = [0.0, 0.0, 0.05], frame = "tool" }}

# [[segment]]                # … to a position alone, with a direction, or turned by rpy; joint, screw and arc as well
# line = {{ xyz = [{x}, {y}, {z}], direction = [0.0, 0.0, -1.0] }}

# [[segment]]                # a screw motion: a turn about an axis that advances `pitch` metres per radian
# screw = {{ axis = [0.0, 0.0, 1.0], point = [{x}, {y}, {z}], angle = 0.5, pitch = 0.0 }}

# [[segment]]                # an arc about an axis, or through a point: {{ via = [x, y, z], to = … }}
# arc = {{ axis = [0.0, 0.0, 1.0], centre = [{x}, {y}, {z}], angle = 0.5, constrain = "position" }}

[[segment]]
joint = "ready"
"""


def _first_move(arm: Arm) -> tuple[str, float]:
    """Return the first joint with room around the ready pose, and a value for it."""
    for j, (name, unit) in enumerate(zip(arm.joint_names, arm.units, strict=True)):
        for step in (STEP[unit], -STEP[unit]):
            value = float(np.round(arm.ready[j] + step, 3))
            if arm.limits.lower[j] <= value <= arm.limits.upper[j]:
                return name, value
    return arm.joint_names[0], float(arm.ready[0])
