"""3.2 Inverse kinematics: both solutions of the two-link arm, by its triangle, by subproblems and by a solver."""

import numpy as np

from twistarm import Position, load_arm, solve_ik, solve_ik_all, subproblems

arm = load_arm("rr_planar")
q1, q2 = (np.array([-xi[1], xi[0]]) for xi in arm.screws.T)
tool = arm.home[:2, 3]
l1, l2 = np.linalg.norm(q2 - q1), np.linalg.norm(tool - q2)


def by_the_triangle(x, y):
    """Both solutions by the law of cosines, with its angles α at the elbow and β at the shoulder."""
    r = np.hypot(x, y)
    # α and β keep to their cosines' range when rounding would leave it.
    alpha = np.arccos(np.clip((l1**2 + l2**2 - r**2) / (2 * l1 * l2), -1, 1))
    beta = np.arccos(np.clip((r**2 + l1**2 - l2**2) / (2 * l1 * r), -1, 1))
    # The signs go together: mixed ones miss the target.
    return [wrapped([np.arctan2(y, x) + sign * beta, np.pi + sign * alpha]) for sign in (+1, -1)]


def by_subproblems(p):
    """θ₂ brings the tool to p's distance from the first axis (subproblem 3); θ₁ turns it to p (subproblem 1)."""
    shoulder, away = np.append(q1, p[2]), np.linalg.norm(p[:2] - q1)
    solutions = []
    for theta_2 in subproblems.subproblem_3(arm.screws[:, 1], arm.home[:3, 3], shoulder, away).values:
        moved = arm.fk([0.0, theta_2])[:3, 3]
        solutions.append(np.array([subproblems.subproblem_1(arm.screws[:, 0], moved, p).values[0], theta_2]))
    return solutions


def wrapped(theta):
    """Angles in [−π, π)."""
    return (np.asarray(theta) + np.pi) % (2 * np.pi) - np.pi


def equal(some, others):
    """Whether two lists hold the same configurations, in whatever order."""
    return len(some) == len(others) and all(min(np.abs(wrapped(a - b)).max() for b in others) < 1e-7 for a in some)


target = arm.fk([0.5, 1.2])[:3, 3]
triangle = by_the_triangle(*(target[:2] - q1))
for theta in triangle:
    assert np.allclose(arm.fk(theta)[:3, 3], target), theta
    near = solve_ik(arm, Position(target), theta + 0.05)
    assert near.converged
    assert np.allclose(near.theta, theta, atol=1e-5), "started near a solution, the solver finds that one"
assert equal(triangle, by_subproblems(target))

found = solve_ik_all(arm, Position(target))
assert equal(triangle, [*found.theta, *found.outside])
assert found.complete

# The workspace is a ring: at its edges the two solutions are one, beyond them there is none.
for r, count in ((l1 + l2, 1), (1.001 * (l1 + l2), 0), (abs(l1 - l2), 1), (0.999 * abs(l1 - l2), 0)):
    if r > 0:
        edge = solve_ik_all(arm, Position([q1[0] + r, q1[1], target[2]]))
        assert len(edge) + len(edge.outside) == count, (r, count)
print("inverse kinematics: both solutions by the triangle, by subproblems, in closed form and by damped least squares")
