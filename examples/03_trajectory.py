"""A motion through poses under the joints' limits, looked at between the waypoints and written for a controller."""

import tempfile
from pathlib import Path

import numpy as np

from twistarm import load_arm, plan_joint, save_trajectory

arm = load_arm("rover_arm")
waypoints = [arm.ready, arm.ready + [0.2, 0.3, -0.4, 0.2, 1.0], arm.ready + [-0.2, 0.1, 0.3, -0.3, -1.0]]
motion = plan_joint(arm, waypoints)

# It is at rest at both ends, passes every waypoint, and keeps the limits everywhere: the peaks are exact.
assert np.allclose(motion(motion.times), waypoints, atol=1e-9)
assert np.allclose(motion([0.0, motion.duration], order=1), 0.0, atol=1e-9)
assert (motion.peak(1) <= arm.limits.velocity * (1 + 1e-9)).all()
assert (motion.peak(2) <= arm.limits.acceleration * (1 + 1e-9)).all()

with tempfile.TemporaryDirectory() as folder:
    csv = save_trajectory(motion, Path(folder) / "motion.csv", dt=0.02)
    trajectory = save_trajectory(motion, Path(folder) / "motion.json", dt=0.02)
    rows = csv.read_text().count("\n") - 1
    print(f"{motion.duration:.2f} s, {rows} rows of CSV, {trajectory.stat().st_size} bytes of JSON")
