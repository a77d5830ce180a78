"""How far a point is from being stationary inside the limits and with some rows held."""

import numpy as np
from scipy.optimize import lsq_linear


def residual(slope, rows, theta, limits):
    """‖slope + rowsᵀ y + μ‖ at best, y free, μ pointing outward at the bounds theta stands at: 0 if optimal."""
    at_lower, at_upper = theta <= limits.lower + 1e-9, theta >= limits.upper - 1e-9
    n = len(theta)
    A = np.hstack([rows.T, np.eye(n)])
    low = np.concatenate([np.full(len(rows), -np.inf), np.where(at_lower, -np.inf, -1e-300)])
    high = np.concatenate([np.full(len(rows), np.inf), np.where(at_upper, np.inf, 1e-300)])
    return np.linalg.norm(lsq_linear(A, -slope, bounds=(low, high), tol=1e-15).fun)
