# ## A group
assert np.isclose(halves, 0, atol=1e-5)

# ## A point goes round
assert np.allclose(rotations.skew(omega) @ p0, np.cross(omega, p0))
assert np.allclose(orbit, rotations.exp(omega, times) @ p0)
rates = np.gradient(orbit, times, axis=0)[1:-1]
assert np.abs(rates - np.cross(omega, orbit[1:-1])).max() < 1e-3

# ## The series becomes Rodrigues' formula
angle = 2.1
assert np.allclose(rodrigues(omega, angle), Rotation.from_rotvec(omega * angle).as_matrix())
assert np.allclose(rodrigues(omega, angle), expm(rotations.skew(omega) * angle))
assert np.allclose(np.linalg.matrix_power(rotations.skew(omega), 3), -rotations.skew(omega))
assert np.allclose(np.linalg.matrix_power(rotations.skew(omega), 2), np.outer(omega, omega) - np.eye(3))
assert np.allclose(careful, expm(rotations.skew(long_axis) * np.radians(30)))

# ## The shafts of your arm
for shaft, unit in zip(shafts.T, np.eye(turning.n), strict=True):
    if np.isclose(np.linalg.norm(shaft), 1):
        assert np.allclose(rodrigues(shaft, step) @ before, turning.fk(pose + step * unit)[:3, :3])
        assert np.allclose(rotations.skew(shaft) @ shaft, 0)

# ## The way back: the logarithm
assert np.allclose(rotations.exp(w) @ start, end)
assert np.isclose(turn, np.linalg.norm(Rotation.from_matrix(change).as_rotvec()))
if 0.01 < turn < np.pi - 0.01:  # where the formula above may be used
    vee = np.array([change[2, 1] - change[1, 2], change[0, 2] - change[2, 0], change[1, 0] - change[0, 1]])
    assert np.allclose(vee / (2 * np.sin(turn)) * np.arccos((np.trace(change) - 1) / 2), w)
tiny = np.argmin(abs(sizes - 1e-9))
assert by_cosine[tiny] == 0
assert np.abs(by_log / sizes - 1).max() < 1e-6

# ## In use: which way is down?
assert np.allclose(R @ a_t, a_s)
assert np.allclose(a_t, Rotation.from_matrix(R).inv().apply(a_s))
