"""A depth camera sees a board and the arm: its points are an obstacle, a motion goes round, and a new picture replaces it."""

import numpy as np

from twistarm import FreeMove, Scene, load_arm, plan

VOXEL = 0.02
arm = load_arm("ur5", limits={"acceleration": 3.0})
start = np.array([0.0, -1.2, 1.4, -0.2, 0.0, 0.0])
goal = start + [1.6, 0.0, 0.0, 0.0, 0.0, 0.0]

# The camera looks along its z axis from 2 m in front of the base, 0.7 m high, towards the arm.
camera = np.eye(4)
camera[:3, :3] = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]], dtype=float).T @ np.diag([-1.0, 1.0, -1.0])
camera[:3, 3] = [2.0, 0.0, 0.7]
