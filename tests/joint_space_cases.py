"""An arm with a slide and two hinges, waypoints and limits for it, and what a plan may miss them by."""

import numpy as np

from twistarm import arm_from_screws

LAWS, SPLINES = ("s_curve", "time_optimal"), ("cubic", "quintic")
WAYS = [(law, stop) for law in LAWS for stop in (False, True)]
TIMED = [(kind, stop) for kind in SPLINES for stop in (False, True)]

RATE = 1e-9  # Relative excess over a rate limit that is rounding: what the planner promises.
MET = 1e-3  # Relative: a limit that is met, but for the grid of a time-optimal law.
PASSES = 1e-9  # A waypoint is passed to the rounding of a spline's solution [rad, m].

RATES = {
    "velocity": {"slide": 0.5, "shoulder": 1.0, "elbow": 1.5},
    "acceleration": {"slide": 1, "shoulder": 2, "elbow": 4},
}


def make_arm(**limits):
    """A slide and two turning joints, with position limits only, unless `limits` says more."""
    ranges = {
        "lower": {"slide": -0.5, "shoulder": -2.0, "elbow": -2.5},
        "upper": {"slide": 0.5, "shoulder": 2.0, "elbow": 2.5},
    }
    screws = [[0, 1, 0, 0, 0, 0], [0, 0, 0, 0, 1, 0], [0, 0, -0.5, 0, 1, 0]]
    joints = ("slide", "shoulder", "elbow")
    home = np.eye(4)
    home[0, 3] = 0.8
    return arm_from_screws(np.transpose(screws), home, joints=joints, limits=ranges | limits)


ARM = make_arm()
PATH = np.array([[0.0, 0.0, 0.0], [0.2, 0.8, -0.5], [0.1, 1.0, 1.0], [-0.3, -0.5, 0.5]])


def use(motion, limits, kind="time_optimal"):
    """The largest part of a limit that the motion uses. Only an s-curve limits the jerk, by default to a in 0.1 s."""
    rates = [limits.velocity, limits.acceleration]
    if kind == "s_curve":
        rates.append(np.where(np.isinf(limits.jerk), limits.acceleration / 0.1, limits.jerk))
    return max((motion.peak(order) / rate).max() for order, rate in enumerate(rates, start=1))
