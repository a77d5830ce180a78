"""Find a camera on the flange, the tag that it sees, and the arm's wrong zeros in one fit: hand-eye calibration.

A real log has rvec and tvec of OpenCV's solvePnP. This one is simulated: noise of 0.3 mm sideways, 2 mm in depth and
0.8° in the tag's tilt.
"""

import numpy as np

from twistarm import calibrate, load_arm, rotations, screws
from twistarm.calibration import Measurements

arm, rng = load_arm("ur5"), np.random.default_rng(0)
wrong = np.radians([0.0, 1.5, -2.0, 1.0, 0.0, 0.0])  # what the encoders do not show
camera = screws.exp([0.03, 0.0, 0.05, 0.0, 0.0, 0.4])  # beyond the tip

# The tag lies 0.4 m in front of the camera and faces it; the arm looks at it from many sides.
start = arm.random_theta(3, 1)[0]
facing = np.diag([1.0, -1.0, -1.0, 1.0])
facing[2, 3] = 0.4
tag = arm.fk(start) @ camera @ facing
theta = start + rng.uniform(-0.5, 0.5, (4000, arm.n))
seen = screws.inverse(arm.fk(theta + wrong) @ camera) @ tag
inside = (np.abs(seen[:, :2, 3]) < 0.3 * seen[:, 2:3, 3]).all(axis=1) & (np.abs(seen[:, 2, 3] - 0.4) < 0.2)
theta, seen = theta[inside][:30], seen[inside][:30]

tvec = seen[:, :3, 3] + rng.normal(scale=[3e-4, 3e-4, 2e-3], size=(30, 3))
rvec = rotations.log(rotations.exp(rng.normal(scale=np.radians([0.8, 0.8, 0.1]), size=(30, 3))) @ seen[:, :3, :3])

found = calibrate(arm, Measurements(theta, rvec=rvec, tvec=tvec), camera="tool", tag_size=0.08)
result = found.require(here=True).hand_eye
assert result is not None
off = screws.log(screws.inverse(camera) @ result.camera)
assert np.linalg.norm(off[:3]) < 0.005
assert np.linalg.norm(off[3:]) < np.radians(0.5)
assert np.abs(found.zeros - wrong).max() < np.radians(0.5)
print(f"camera: {1000 * np.linalg.norm(off[:3]):.1f} mm and {np.degrees(np.linalg.norm(off[3:])):.2f}° from the truth")
print(*found.changes(), sep="\n")
print(result.urdf)
