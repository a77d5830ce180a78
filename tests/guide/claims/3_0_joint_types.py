# ## One freedom: revolute, prismatic, helical
p = np.array([0.7, 0.1, 0.2])
for xi in (columns[:, 0] for columns in one_each.values()):
    velocity = np.cross(xi[3:], p) + xi[:3]  # what the twist says
    eps = 1e-6
    ahead, behind = ((screws.exp(xi, x) @ np.append(p, 1))[:3] for x in (eps, -eps))
    assert np.allclose((ahead - behind) / (2 * eps), velocity, atol=1e-8)
after_a_turn = screws.exp(joints.helical(axis, point, pitch)[:, 0], 2 * np.pi)
assert np.allclose(after_a_turn[:3, 3], [0, 0, lead])
assert np.allclose(after_a_turn[:3, :3], np.eye(3))

# ## Several freedoms: cylindrical, planar, spherical
assert list(freedoms.values()) == [1, 1, 1, 2, 3, 3]

# ## Does the order matter?
turn, slide = several["cylindrical"].T
either_way = both_orders(turn, slide, 1.2, 0.3)
assert np.allclose(*either_way)
assert distance > 0.1

# ## The ball and its coordinates
assert ranks == [3, 3, 2]

# ## Build all six
assert all(proof.ok for proof in proofs.values())
assert [one.n for one in arms.values()] == list(freedoms.values())

# ## What goes wrong in practice
assert np.isclose(with_pitch, turns * lead)
assert np.isclose(tool_of_held, 0)
