# ## Your tool in four numbers
by_scipy = np.roll(Rotation.from_matrix(R).as_quat(), 1)  # SciPy puts the scalar last
assert np.allclose(abs(Q @ by_scipy), 1)
assert np.allclose(Q, [np.cos(angle / 2), *(axis * np.sin(angle / 2))])
assert np.allclose(moved, [0, *(R @ p)])
assert np.allclose(product(Q, by_scipy), rotations.quaternion_product_wxyz(Q, by_scipy))

# ## Why half the angle
assert np.allclose(rotations.from_quaternion_wxyz(Q), rotations.from_quaternion_wxyz(-Q))

# ## Your arm as a product of quaternions
off = np.degrees(rotations.angle_between(rotations.from_quaternion_wxyz(whole), R))
assert off < 1e-5
assert np.isclose(abs(whole @ Q), 1)

# ## The norm, and the inverse
assert np.allclose(right, [1, 0, 0, 0])
assert np.isclose(literal, 1 / 30)
assert np.allclose(rotations.quaternion_inverse_wxyz(four), conjugate(four) / square)
assert np.isclose(growth, 1.05**2)

# ## The sign in your recordings
assert np.abs(np.diff(mended, axis=0)).max() < 0.02 < 0.5 < np.abs(np.diff(logged, axis=0)).max()
assert np.allclose(rotations.from_quaternion_wxyz(mended), turned)
assert np.isclose(short + long, 360)
assert np.isclose(short, np.degrees(rotations.angle_between(R, R_2)), atol=1e-4)
half = np.radians(short) / 2
third = (np.sin(2 / 3 * half) * Q1 + np.sin(1 / 3 * half) * Q2) / np.sin(half)
assert np.allclose(rotations.from_quaternion_wxyz(third), rotations.exp(rotations.log(R_2 @ R.T) / 3) @ R)
