# ## The arm in the file, and the arm on the table
assert np.allclose(real_tool(np.zeros_like(hidden), fresh), arm.fk(fresh), atol=1e-12)

# ## Four numbers for an axis, two for a slide
for xi, k in zip(arm.screws.T, changes, strict=True):
    assert k == (2 if np.linalg.norm(xi[3:]) < 1e-9 else 4)

# ## What a measurement shows
h = 1e-6
for j, step in enumerate(h * np.eye(6 * (m + 1)).reshape(-1, m + 1, 6)):
    quotient = (real_tool(step, theta[:3]) - real_tool(-step, theta[:3]))[:, :3, 3] / (2 * h)
    assert np.allclose(quotient, slopes(theta[:3])[:, :, j], atol=1e-8)
assert left < 0.1 * off.mean()

# ## What a log can show
assert rank <= at_most
assert with_base == rank
assert shown >= 0.5 * rank

# ## Least squares in units of the noise
assert 0.4 < np.sqrt(np.mean(surprise**2)) < 2.5

# ## Rows left out of the fit
assert np.all(np.diff(fit_error) < 1e-12)
assert held_out[best] < held_out[0]
assert fit_error[-1] < min(held_out[-1], 1.4 * rough)

# ## All steps in one call
assert found.held_out < 0.5 * found.held_out_before
assert after.mean() < 0.2 * off.mean()

# ## A tape, and a ball in two sockets
errors = [expected(B) for _, _, B in logs]
assert max(errors) == errors[0]
assert errors[2] < errors[1]
assert errors[-1] < 2.5 * noise

# ## What goes wrong in practice
assert away > 2 * expected(tracked(theta, noise))
