"""The nearest configuration to a target by SciPy's SLSQP from many starts."""

import numpy as np
import pinocchio as pin
from scipy.optimize import minimize

from ik_targets import errors
from twistarm.ik import TolerancedPose

POSITION_TOL, ANGLE_TOL = 1e-6, 1e-5
"""How exactly SLSQP finds a minimum [m, rad]: it stops on the value, which is flat there."""


def components(target, g):
    """Errors of position and rotation, component by component, as the definitions have them."""
    R_g, p_g = (target.g[:3, :3], target.g[:3, 3]) if hasattr(target, "g") else (np.eye(3), target.p)
    p, w = g[:3, 3] - p_g, pin.log3(g[:3, :3] @ R_g.T)
    return (R_g.T @ p, R_g.T @ w) if isinstance(target, TolerancedPose) and target.frame == "target" else (p, w)


def by_slsqp(arm, target, rng, starts):
    """Least position error, and least rotation error with it held, from many starts of SciPy's SLSQP."""
    bounds = [
        tuple(b if np.isfinite(b) else None for b in pair)
        for pair in zip(arm.limits.lower, arm.limits.upper, strict=True)
    ]
    tolerance = target.tolerance[:3] if isinstance(target, TolerancedPose) else np.zeros(3)

    def off(theta):
        return errors(target, arm.fk(theta))

    def first(theta):
        return minimize(lambda x: off(x)[0] ** 2, theta, method="SLSQP", bounds=bounds, options={"ftol": 1e-16}).x

    ends = [first(theta) for theta in arm.random_theta(rng, starts)]
    least = min(off(theta)[0] for theta in ends)

    def inside_tolerance(theta):
        p = components(target, arm.fk(theta))[0]
        return np.concatenate([tolerance - p, tolerance + p])

    held = {"type": "ineq", "fun": lambda x: (least + 1e-13) ** 2 - off(x)[0] ** 2}
    if least < POSITION_TOL:
        exact = not tolerance.any()
        held = (
            {"type": "eq", "fun": lambda x: components(target, arm.fk(x))[0]}
            if exact
            else {"type": "ineq", "fun": inside_tolerance}
        )
    best = np.inf
    for theta in ends:
        if off(theta)[0] > least + 1e-4:
            continue
        end = minimize(
            lambda x: 1 - np.cos(off(x)[1]), theta, method="SLSQP", bounds=bounds, constraints=held,
            options={"ftol": 1e-15, "maxiter": 300},
        ).x  # fmt: skip
        if off(end)[0] <= least + POSITION_TOL and arm.limits.contains(end, 1e-9):
            best = min(best, off(end)[1])
    return least, best
