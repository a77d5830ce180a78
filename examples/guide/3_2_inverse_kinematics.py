"""3.2 Inverse kinematics: both solutions of the two-link arm, and what a numeric solver makes of them."""

import numpy as np

from twistarm import Position, load_arm, solve_ik

arm = load_arm("rr_planar")
q1, q2 = (np.array([-xi[1], xi[0]]) for xi in arm.screws.T)
l1, l2 = np.linalg.norm(q2 - q1), np.linalg.norm(arm.home[:2, 3] - q2)
target = arm.fk([0.5, 1.2])[:3, 3]

# The triangle of l1, l2 and r; α and β keep to their cosines' range when rounding would leave it.
x, y = target[:2] - q1
r = np.hypot(x, y)
alpha = np.arccos(np.clip((l1**2 + l2**2 - r**2) / (2 * l1 * l2), -1, 1))
beta = np.arccos(np.clip((r**2 + l1**2 - l2**2) / (2 * l1 * r), -1, 1))

# The signs go together: mixed ones miss the target.
for sign in (+1, -1):
    theta = np.array([np.arctan2(y, x) + sign * beta, np.pi + sign * alpha])
    theta[1] = (theta[1] + np.pi) % (2 * np.pi) - np.pi
    assert np.allclose(arm.fk(theta)[:3, 3], target), theta
    near = solve_ik(arm, Position(target), theta + 0.05)
    assert near.converged
    assert np.allclose(near.theta, theta, atol=1e-5), "started near a solution, the solver finds that one"
print("inverse kinematics: both solutions found, by the triangle and by damped least squares")
