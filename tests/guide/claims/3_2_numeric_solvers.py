# ## What a small turn of each joint does
for i, step in enumerate(h * np.eye(2)):  # a small turn of one joint after the other
    moved = planar.fk(theta + step)[:2, 3] - planar.fk(theta - step)[:2, 3]
    assert np.allclose(moved / (2 * h), tip_jacobian(theta)[:, i])
for i, step in enumerate(h * np.eye(arm.n)):
    motion = screws.inverse(arm.fk(arm.ready - step)) @ arm.fk(arm.ready + step)
    column = screws.log(motion) / (2 * h)
    assert np.allclose(column, arm.body_jacobian(arm.ready)[:, i], atol=1e-5)

# ## The error twist
way = pin.log6(pin.SE3(np.linalg.solve(arm.fk(start), g_d))).vector
assert np.allclose(gap, way, atol=1e-9)
assert abs(predicted - 1000 * l2 * np.radians(1.0)) < 1e-9  # the elbow's circle
assert abs(made - 2000 * l2 * np.sin(np.radians(0.5))) < 1e-9  # its chord

# ## Least squares
assert np.allclose(one_slide, [30])
assert np.allclose(two_slides, [15, 15])

# ## Newton's step
assert size(arm, gaps)[-1] < 1e-9, "Newton arrives"
assert np.allclose(arm.fk(reached), g_d, atol=1e-8)

# ## What each direction costs
assert np.isclose(sigma[0] * sigma[1], abs(np.linalg.det(tip_jacobian(stretched))))
assert np.isclose(np.hypot(*sigma), np.linalg.norm(tip_jacobian(stretched)))

# ## Where Newton's method fails
straight = np.radians([20.0, 0.0])
inward = -0.1 * planar.fk(straight)[:2, 3]
assert np.allclose(newton_step(tip_jacobian(straight), inward), 0.0, atol=1e-9)
assert abs(np.degrees(leap[1])) > 180
assert np.allclose(J @ leap, e)

# ## Damping
stacked = np.vstack([J, 0.05 * np.eye(2)])  # the same, one least-squares problem
by_lstsq = np.linalg.lstsq(stacked, np.append(e, [0, 0]), rcond=None)[0]
assert np.allclose(damped_step(J, e, 0.05), by_lstsq)
assert np.allclose(np.linalg.solve(J.T @ J + 0.05**2 * np.eye(2), J.T @ e), by_lstsq)
assert (np.linalg.norm(first, axis=1) <= np.linalg.norm(e) / (2 * dampings) + 1e-12).all()
assert best < len(dampings) - 1

# ## Out of reach
assert by_newton[20:].max() > 3 * least
assert abs(by_damped[-1] - least) < 0.02 * planar.reach

# ## Five joints
assert answers["`Position`, 3 numbers"].converged

# ## What solve_ik says when it cannot
assert far.converged or far.stop.name in ("OUT_OF_REACH", "BLOCKED_BY_LIMITS")
assert cases[-1][1].converged
assert all(arm.limits.contains(answer.theta) for _, answer in cases)
