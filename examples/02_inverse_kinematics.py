"""Five joints cannot meet every pose: ask for what they can do, or read how near they come and why."""

import numpy as np

from twistarm import Approach, Pose, load_arm, rotations, solve_ik

arm = load_arm("rover_arm")
g = arm.fk(arm.ready)

# A position and where the tool points: four numbers besides the wrist roll, within five joints.
key = Approach(p=g[:3, 3] + [0.05, 0.1, -0.05], direction=[1, 0, 0])
found = solve_ik(arm, key)
assert found.converged
assert np.linalg.norm(arm.fk(found.theta)[:3, 3] - key.p) < 1e-6

# The same position with the tool turned 20° to the side: this arm has no joint for it.
aside = g.copy()
aside[:3, :3] = rotations.from_rpy([0, 0, np.radians(20)]) @ g[:3, :3]
nearest = solve_ik(arm, Pose(aside))
assert not nearest.converged
assert nearest.position_error < 1e-6, "the position comes first"
assert np.isclose(nearest.orientation_error, np.radians(20), atol=1e-4), "and the rotation as near as it gets"
print(nearest.explain())
