# ## Three small questions
assert np.isclose(turn_to(xi, finger, moved), 0.7)
assert np.isclose(subproblems.subproblem_1(xi, finger, moved).values[0], 0.7)
by_library = subproblems.subproblem_3(xi, finger, moved, half_way).values
assert np.allclose(both, [0.4, 1.0])
assert np.allclose(np.sort(by_library % (2 * np.pi)), both)
axes = (np.array([0, 0, 0, 0, 0, 1.0]), np.array([0, 0, 0, 1.0, 0, 0]))
p = np.array([0.45, 0.6, 0.45])
q = (screws.exp(axes[0], 1.1) @ screws.exp(axes[1], -0.5) @ np.append(p, 1))[:3]
by_library = subproblems.subproblem_2(*axes, p, q).values
assert len(by_library) == len(crossings) == 2
for crossing in crossings:
    pair = [turn_to(axes[0], crossing, q), turn_to(axes[1], p, crossing)]
    assert np.abs(by_library - pair).max(axis=1).min() < 1e-9
assert len(meetings) == 2

# ## A wrist divides the problem
assert len(eight) == 8
assert np.allclose(elbow_arm.fk(eight), g_d, atol=1e-9)


def wrap(angle):
    """The same direction, in (−π, π]."""
    return np.pi - (np.pi - angle) % (2 * np.pi)


by_twistarm = solve_ik_all(elbow_arm, g_d)
everything = np.array([*by_twistarm, *by_twistarm.outside])
assert by_twistarm.complete
assert len(everything) == len(eight)
for theta in eight:
    assert np.abs(wrap(everything - theta)).max(axis=1).min() < 1e-6
from twistarm import rotations

zyz = np.array([0.5, 0.8, -0.3])
flip = np.array([zyz[0] + np.pi, -zyz[1], zyz[2] + np.pi])
assert np.allclose(rotations.from_euler("ZYZ", zyz), rotations.from_euler("ZYZ", flip))

# ## Your arm
assert np.abs(found.theta - theta).max(axis=1).min() < 1e-4 if len(found) else False, "theta itself is among them"
assert (found.position_error < 1e-6).all()
assert (found.orientation_error < 1e-6).all()
from twistarm import Approach

rover = guide.bundled("rover_arm")
g = rover.fk(rover.ready)
same_place = Approach(g[:3, 3], g[:3, :3] @ rover.tool_axis)
flips = solve_ik_all(rover, same_place, rover.ready, fixed_joints={"wrist_roll": rover.ready[4]})
both = np.array([*flips, *flips.outside])
assert flips.complete
assert len(both) == 2
assert np.isclose(both[0, 2], -both[1, 2])  # the elbow bends to the other side by as much
assert np.isclose(both[0, 1:4].sum(), both[1, 1:4].sum())  # the tool points the same way

# ## What goes wrong in practice
assert {"joint_4", "joint_6"} <= set(free_at[0]), "two joints turn against each other"
assert "joint_1" in free_at[1], "the base joint may stand anywhere"
