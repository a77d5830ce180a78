"""2.1 Rotations: Euler angles, rotation matrices, quaternions and the exponential, each told by another."""

from functools import partial

import numpy as np

from twistarm import rotations

alpha, beta, gamma = 0.3, 1.1, -0.4

# ZYZ Euler angles are three rotations, each about the axes as the ones before have left them.
R = rotations.from_euler("ZYZ", [alpha, beta, gamma])
Rz, Ry = (partial(rotations.exp, axis) for axis in ([0, 0, 1], [0, 1, 0]))
assert np.allclose(R, Rz(alpha) @ Ry(beta) @ Rz(gamma))

# SO(3): RᵀR = I and det R = +1; columns of R_ab are B's axes seen from A.
assert np.allclose(R.T @ R, np.eye(3))
assert np.isclose(np.linalg.det(R), 1.0)

# At beta = 0 only alpha + gamma matters: two different triples, one rotation.
assert np.allclose(rotations.from_euler("ZYZ", [0.5, 0, 0.2]), rotations.from_euler("ZYZ", [0.1, 0, 0.6]))

# Q and −Q are the same rotation: a double cover, not a global parametrisation.
Q = rotations.to_quaternion_wxyz(R)
assert np.allclose(rotations.from_quaternion_wxyz(-Q), R)

# A point carried by the rotation at unit speed about w: q̇ = w × q, so q(t) = e^{ŵt} q(0).
w, q0, t, h = np.array([0.6, 0.0, 0.8]), np.array([1.0, 2.0, 3.0]), 0.7, 1e-6
rate = (rotations.exp(w * (t + h)) @ q0 - rotations.exp(w * (t - h)) @ q0) / (2 * h)
assert np.allclose(rate, np.cross(w, rotations.exp(w * t) @ q0), atol=1e-8)
print("rotations: every claim holds")
