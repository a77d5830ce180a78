# ## What makes nine numbers a rotation
assert off < 1e-12
assert np.isclose(np.linalg.det(R), 1.0)
assert np.allclose(mirror.T @ mirror, np.eye(3))

# ## What it does
assert np.isclose(np.linalg.norm(ahead_s), np.linalg.norm(ahead))
assert np.allclose(R.T @ ahead_s, ahead)

# ## Three numbers: Euler angles
for order in orders:
    assert np.allclose(rotations.from_euler(order, rotations.to_euler(order, R)), R)

# ## Where they fail
one, other = np.radians([50.0, 0.0, 20.0]), np.radians([10.0, 0.0, 60.0])
assert np.allclose(rotations.from_euler("ZYZ", one), rotations.from_euler("ZYZ", other))
a, b = 0.7, 1.1
(sa, sb), (ca, cb) = np.sin([a, b]), np.cos([a, b])
written = np.array([[0, -sa, ca * sb], [0, ca, sa * sb], [1, 0, cb]])
assert np.allclose(rotations.euler_rate_map("ZYZ", [a, b, 0.2]), written)
assert np.isclose(np.linalg.det(written), -sb)
c = np.abs(np.cos(beta))
assert np.allclose(condition, np.sqrt((1 + c) / (1 - c))), "the first and third axis make the angle β"
assert np.isclose(fastest, 1 / (2 * np.sin(beta[0] / 2)))

# ## What goes wrong in practice
assert np.allclose(mended.T @ mended, np.eye(3), atol=1e-12)
