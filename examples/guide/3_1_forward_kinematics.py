"""3.1 Forward kinematics: the two-link arm by hand, by product of exponentials, and from its URDF."""

import numpy as np

from twistarm import arm_from_screws, joints, load_arm

arm = load_arm("rr_planar")
first, second = arm.screws.T
tool = arm.home[:3, 3]
# Each axis is parallel to z: its twist (v, w) has w = z and v = −w × q, so q = (−v_y, v_x).
q1, q2 = (np.array([-xi[1], xi[0]]) for xi in (first, second))
l1, l2 = np.linalg.norm(q2 - q1), np.linalg.norm(tool[:2] - q2)

# By hand: x = l1 cos θ1 + l2 cos(θ1 + θ2), y likewise with sines.
theta = np.array([0.4, 0.9])
x = l1 * np.cos(theta[0]) + l2 * np.cos(theta.sum())
y = l1 * np.sin(theta[0]) + l2 * np.sin(theta.sum())
assert np.allclose(arm.fk(theta)[:2, 3] - q1, [x, y])

# By hand as screws: two frames and two axes are all it takes, no Denavit–Hartenberg table.
columns = [joints.revolute([0, 0, 1], [*q, 0]) for q in (q1, q2)]
by_hand = arm_from_screws(np.hstack(columns), arm.home)
assert np.allclose(by_hand.fk(theta), arm.fk(theta))
print(f"forward kinematics: l1 = {l1:.3f} m, l2 = {l2:.3f} m, the tool at x = {x:.4f} m, y = {y:.4f} m")
