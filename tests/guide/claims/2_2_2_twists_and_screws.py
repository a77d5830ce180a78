# ## What a joint does to a point
assert np.allclose(screws.hat(kinds["helical"]) @ [*p, 1], [*(np.cross(axis, p - q) + pitch * axis), 0])
# any point on the axis will do
assert np.allclose(kinds["revolute"], joints.revolute(axis, q + 3 * axis)[:, 0])
assert np.allclose(origin_rate, kinds["revolute"][:3])

# ## The twists of your arm
for xi in arm.screws.T:
    v, w = xi[:3], xi[3:]
    if np.linalg.norm(w) > 0.5:
        assert np.isclose(screws.to_screw(xi).pitch, w @ v / (w @ w))
        assert np.allclose(screws.to_screw(xi).point, np.cross(w, v) / (w @ w))

# ## The exponential
for xi in [*kinds.values(), *arm.screws.T]:
    assert np.allclose(exponential(xi, 0.7), expm(screws.hat(xi) * 0.7))
    assert np.allclose(exponential(xi, 0.7), pin.exp6(xi * 0.7).homogeneous)
    assert np.allclose(exponential(xi, 0.7), screws.exp(xi, 0.7))
if np.count_nonzero(arm.coupling.A[:, 0]) == 1 == arm.coupling.A[0, 0]:
    assert np.allclose(moved, arm.fk(step * np.eye(arm.n)[0]))

# ## Back again: the logarithm, and Chasles' theorem
assert np.allclose(xi, screws.log(end @ screws.inverse(start)))
assert np.allclose(path[-1], end)
assert np.allclose(screws.exp(pin.log6(pin.SE3(end @ screws.inverse(start))).vector) @ start, end)
assert np.allclose(screw.twist, xi)
assert length > straight - 1e-9
if not np.isinf(screw.pitch):
    along = (places - screw.point) @ screw.axis
    radius = np.linalg.norm(places - screw.point - along[:, None] * screw.axis, axis=1)
    assert np.ptp(radius) < 1e-7  # the tool keeps its distance from the line
assert np.isclose(bent.pitch, 0)
assert np.isinf(shifted.pitch)
