# ## The law
for theta in (up, down):
    assert np.allclose(tip(*theta), cross)
    assert np.allclose(planar.fk(theta)[:2, 3], q1[:2] + cross)
from twistarm import Position, solve_ik_all

target = np.append(q1[:2] + cross, planar.home[2, 3])
found = solve_ik_all(planar, Position(target))
assert found.complete
assert len(found) == 2
for theta in (up, down):
    assert np.abs(wrap(found.theta - theta)).max(axis=1).min() < 1e-7

# ## The signs go together
assert np.isclose(miss, 2 * l2 * np.sin(alpha))
assert np.isclose(np.hypot(*tip(*mixed)), np.hypot(*cross))

# ## At the edges
assert 0 < lost < len(many)
assert np.isfinite(np.arccos(np.clip(cosine, -1, 1))).all()

# ## The two links inside your arm
assert carried_off < 2e-3 * arm.reach, "forward kinematics: what the two links carry stays where it was"

# ## What goes wrong in practice
assert np.isclose(np.linalg.norm(tip(*by_atan) - behind), 2 * np.hypot(*behind))
