"""Every configuration of a UR5 for one pose, eight of them, and every flip of the rover arm; with --view as ghosts."""

import sys
from itertools import combinations

import numpy as np

from twistarm import Approach, load_arm, solve_ik_all
from twistarm.viewer import Viewer

ur5, rover = load_arm("ur5"), load_arm("rover_arm")

# A UR5 has three parallel axes: shoulder left or right, elbow up or down, wrist flipped or not, 2 · 2 · 2.
g, _, _ = ur5.by_pinocchio([0.3, -1.2, 1.4, -0.9, -1.1, 0.4])
eight = solve_ik_all(ur5, g)
assert len(eight) == 8
assert eight.complete

# The rover arm slides, and turns in one plane: where the tool's position and direction are given, the elbow is up or
# down. Its last joint rolls the tool about that direction, which is free.
flips = solve_ik_all(rover, Approach([0.8, 0.1, 0.7], direction=[1, 0, 0]))
assert len(flips) == 2
assert flips.complete
assert flips.free == (("wrist_roll",), ("wrist_roll",))

# Pinocchio judges: each meets the target, and no two of them are the same, whole turns aside.
for solutions in (eight, flips):
    arm = solutions.arm
    for theta in (*solutions, *solutions.outside):
        reached, _, _ = arm.by_pinocchio(theta)
        assert solutions.target.position_error(reached) < 1e-9
        assert solutions.target.orientation_error(reached) < 1e-9
    for one, other in combinations([*solutions, *solutions.outside], 2):
        assert np.abs(np.exp(1j * one) - np.exp(1j * other)).max() > 0.01
    print(solutions.explain(), end="\n\n")

if "--view" in sys.argv[1:]:
    with Viewer(ur5) as left, Viewer(rover) as right:
        left.show_solutions(eight)
        right.show_solutions(flips)
        right.wait()
