# ## The formula at work
assert off < 1e-9

# ## The same from the tool's side
assert np.allclose(from_the_tool, g)
assert np.allclose(body, arm.body_screws)

# ## By hand
y = l1 * np.sin(pair[0]) + l2 * np.sin(pair.sum())
assert np.allclose(planar.fk(pair)[:2, 3] - q1[:2], [x, y])
turned = np.radians([25.0, 50.0, again, -50.0])
first, other = (planar.fk(turned[k : k + 2])[:3, 3] for k in (0, 2))
assert np.allclose(first, other)
