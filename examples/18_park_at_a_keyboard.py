"""Where does the rover park to type? A map of where the tool points down, places for the base, and the proof by IK."""

import numpy as np

from twistarm import Approach, load_arm, reach_map, solve_ik

DOWN = [0.0, 0.0, -1.0]
KEYS = np.array([[3.0 + 0.019 * row, 1.0 + 0.019 * key, 0.2] for row in range(4) for key in range(0, 12, 3)])  # [m]

arm = load_arm("rover_arm")
m = reach_map(arm, 0.2, "down").require(arm)
share, poses = m.base_poses(KEYS, yaws=12, count=20)
assert share[0] == 1.0, "the cubes of all keys are reached from the best place"


def missed(g: np.ndarray) -> int:
    """How many keys the arm misses with its base at g."""
    return sum(not solve_ik(arm, Approach(g[:3, :3].T @ (key - g[:3, 3]), DOWN)).converged for key in KEYS)


# A cube answers for its centre only, so each place is proven at the keys themselves.
parked = next(g for g in poses if missed(g) == 0)
heading = np.degrees(np.arctan2(parked[1, 0], parked[0, 0]))
print(f"park at x = {parked[0, 3]:.2f} m, y = {parked[1, 3]:.2f} m, heading {heading:.0f}°: all {len(KEYS)} keys")
