# ## Two links: a ring
assert r.max() <= l1 + l2 + 1e-12
assert r.min() >= abs(l1 - l2) - 1e-12
assert r.max() > 0.99 * (l1 + l2)

# ## In every direction
for l3, share in shares.items():
    dextrous = (np.abs(radii - l3) >= abs(l1 - l2)) & (radii + l3 <= l1 + l2)
    assert np.array_equal(share == 1, dextrous)

# ## Your arm
for (_, sign), (end, seen) in short.items():
    assert sign * end >= sign * seen - 1e-3 * arm.reach
