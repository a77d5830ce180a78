# ## Two velocities of one motion
assert np.allclose(V_s, arm.spatial_jacobian(theta) @ rates, atol=1e-6)
assert np.allclose(V_b, arm.body_jacobian(theta) @ rates, atol=1e-6)
assert np.allclose(g[:3, :3] @ V_b[:3], g_dot[:3, 3], atol=1e-6)
assert np.allclose(V_s[:3] + np.cross(V_s[3:], g[:3, 3]), g_dot[:3, 3], atol=1e-6)

# ## The Adjoint
Ad = np.block([[R, screws.hat(p) @ R], [np.zeros((3, 3)), R]])
assert np.allclose(Ad, pin.SE3(g).action)  # Pinocchio's order is (v, ω) too
assert np.allclose(Ad @ V_b, V_s, atol=1e-6)
assert np.allclose(np.linalg.inv(Ad), screws.adjoint(screws.inverse(g)))

# ## What depends on the frames
assert np.allclose(same, V_s, atol=1e-6)
assert np.allclose(other, screws.adjoint(screws.inverse(g_tn)) @ V_b, atol=1e-6)
assert np.allclose(total, V_s, atol=1e-6)

# ## Wrenches
assert np.allclose(F_s, [*(R @ F_t[:3]), *np.cross(p, R @ F_t[:3])])
assert np.isclose(F_s @ V_s, F_t @ V_b, atol=1e-5)
assert np.allclose(pin.SE3(g).act(pin.Force(F_t)).vector, F_s)
force = R @ F_t[:3]
# How far does the point of the pull go along the force when one joint moves a little?
work = [(arm.fk(theta + eps * e) - arm.fk(theta - eps * e))[:3, 3] @ force / (2 * eps) for e in np.eye(arm.n)]
assert np.allclose(torques, work, atol=1e-5)
