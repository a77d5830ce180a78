# ## The law
assert np.allclose(np.linalg.det(J), l1 * l2 * np.sin(bends))

# ## What the elbow must do
r = np.sqrt(l1**2 + l2**2 + 2 * l1 * l2 * np.cos(nearly))
assert np.allclose(rates, np.degrees(r * outward / (l1 * l2 * np.sin(nearly))))

# ## Rates that cancel
assert np.allclose(null, np.array([-l2, l1 + l2]) / np.hypot(l2, l1 + l2))  # by the lever arms
assert np.allclose(J @ null, 0, atol=1e-12)

# ## A force that no motor feels
assert np.allclose(J.T @ along, 0, atol=1e-12)
assert np.allclose(J.T @ across, 10 * np.array([l1 + l2, l2]))

# ## The worst configuration inside your limits
assert np.allclose(sigma, arm.manipulability(beside).singular_values)
felt = J.T @ lost
assert np.isclose(np.linalg.norm(felt), sigma[rank - 1])  # as little as the arm can feel

# ## Three patterns to know by sight
assert list(ranks.values()) == [6, 5, 5, 6, 5]

# ## Driving through
assert np.all(damped <= 1 / (2 * damping) + 1e-9)
# The twist that suits the joints least has the numbers of that wrench. Checked on the whole matrix:
V = lost
whole = J.T @ np.linalg.solve(J @ J.T + damping**2 * np.eye(6), V)
assert np.isclose(np.linalg.norm(whole), sigma[rank - 1] / (sigma[rank - 1] ** 2 + damping**2))

# ## Strength near a singularity
assert np.isclose(stretched[0], 0, atol=1e-9)  # the force passes through the base
