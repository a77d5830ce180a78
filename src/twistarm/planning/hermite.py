"""Polynomials between given states: each piece has the positions, rates and accelerations given at both its ends.

Coefficients are laid out as in `piecewise`.
"""

from __future__ import annotations

import numpy as np

from ..support.checks import Array


def through(t: Array, theta: Array, theta_dot: Array | None = None, theta_ddot: Array | None = None) -> Array:
    """Coefficients (degree + 1, k − 1, n) through states (k, n) at t (k,) [s]: lines, cubics or quintics.

    Of the least degree that has what is given: positions alone give straight lines, rates too cubics, accelerations too
    quintics. At every t but the last, positions, rates and accelerations are the given ones to the last bit.
    """
    h = np.diff(t)[:, None]
    a, way = theta[:-1], np.diff(theta, axis=0)
    if theta_dot is None:
        return np.stack([way / h, a])
    u = theta_dot[:-1]
    if theta_ddot is None:
        way, faster = way - u * h, np.diff(theta_dot, axis=0)
        return np.stack([(faster * h - 2.0 * way) / h**3, (3.0 * way - faster * h) / h**2, u, a])
    half = 0.5 * theta_ddot[:-1]
    way = way - (u + half * h) * h
    faster = (np.diff(theta_dot, axis=0) - 2.0 * half * h) * h
    bent = 0.5 * np.diff(theta_ddot, axis=0) * h**2
    return np.stack(
        [
            (6.0 * way - 3.0 * faster + bent) / h**5,
            (-15.0 * way + 7.0 * faster - 2.0 * bent) / h**4,
            (10.0 * way - 4.0 * faster + bent) / h**3,
            half,
            u,
            a,
        ]
    )
