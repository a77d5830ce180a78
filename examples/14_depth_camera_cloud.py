"""Points of a depth camera as an obstacle, without the arm: a motion goes round, the next picture replaces them."""

import time

import numpy as np

from twistarm import FreeMove, Scene, load_arm, plan

arm = load_arm("rover_arm_6dof")
aside = np.array([0.7, 0.0, 0.0, 0.0, 0.0, 0.0])
start, goal = arm.ready - aside, arm.ready + aside

# The camera stands 2.5 m in front of the base and looks back: x to its right, y down, z forward.
camera = np.eye(4)
camera[:3, :3] = [[0, 0, -1], [1, 0, 0], [0, -1, 0]]
camera[:3, 3] = [2.5, 0.0, 0.6]
across, down = np.meshgrid(np.linspace(-0.6, 0.6, 320), np.linspace(-0.45, 0.45, 240))
rays = np.stack([across, down, np.ones_like(across)], axis=-1).reshape(-1, 3)


def picture(middle: float, theta: np.ndarray) -> np.ndarray:
    """Points (k, 3) in the camera's frame: a board 0.3 m wide and 0.8 m high at x = 0.95 m, and the arm's hand."""
    board = 1.55 * rays
    board = board[(np.abs(board[:, 0] - middle) < 0.15) & (np.abs(board[:, 1] - 0.2) < 0.4)]
    hand = (np.linalg.inv(camera) @ arm.fk(theta))[:3, 3]
    along = rays @ hand / (rays**2).sum(axis=1)
    beside = (hand**2).sum() - along**2 * (rays**2).sum(axis=1)
    met = beside < 0.015**2
    return np.concatenate([board, along[met, None] * rays[met]])


scene = Scene(arm, margin=0.01)
scene.add_points("camera", picture(0.0, start), 0.02, camera, without_arm=True, theta=start)
assert not scene.collides(start), "the points on the hand are left out"
assert not scene.is_free(start, goal), "the board is in the way"

motion = plan(arm, FreeMove(goal), start=start, scene=scene)
real = Scene(arm)
real.add_box("board", [0.001, 0.3, 0.8], [0.95, 0.0, 0.4])
assert not real.collides(motion(np.linspace(0.0, motion.duration, 500))).any()

# The board has moved to the left of the hand: the way back is free of it only in the next picture.
before = scene.distance(goal).metres
began = time.perf_counter()
scene.replace_points("camera", picture(0.7, goal), without_arm=True, theta=goal)
took = time.perf_counter() - began
assert scene.distance(goal).metres < before
voxels = len(scene.obstacles["camera"].shape.centres)
print(
    f"round the board in {motion.duration:.1f} s; the next picture, {voxels} voxels, replaced it in {1e3 * took:.0f} ms"
)
