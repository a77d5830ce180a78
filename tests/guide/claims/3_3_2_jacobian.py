# ## One joint, one column
assert off < 1e-9
assert off_difference < 1e-7
assert by_last == 0
assert by_first < count

# ## Read the first three rows with care
quotient = (arm.fk(theta + step) - arm.fk(theta - step))[:3, 3] / (2 * h)
assert np.allclose(p_dot, quotient, atol=1e-7)

# ## The same from the tool's side
assert np.allclose(J_b, arm.body_jacobian(theta))
for i, step in enumerate(h * np.eye(arm.n)):
    V_hat = screws.inverse(g) @ (arm.fk(theta + step) - arm.fk(theta - step)) / (2 * h)
    V = [*V_hat[:3, 3], V_hat[2, 1], V_hat[0, 2], V_hat[1, 0]]
    assert np.allclose(J_b[:, i], V, atol=1e-7)
assert unchanged < 1e-9 or not alone

# ## The joystick
assert np.allclose(moved_by, dt * hybrid[:3] @ rates, atol=1e-4 * arm.reach)

# ## The transpose holds the load
# Whoever knows no Jacobian: the work that lifts the stone, joint by joint.
steps = h * np.eye(arm.n)
lifts = (arm.fk(theta + steps) - arm.fk(theta - steps))[:, 2, 3] / (2 * h)
assert np.allclose(torques, mass * gravity * lifts, atol=1e-6)
F_s = np.append(f, np.cross(p, f))  # the same wrench, seen from the base
assert np.allclose(J_s.T @ F_s, torques)
