"""An arm with a slide and two hinges, waypoints and limits for it, and what a plan may miss them by."""

import numpy as np

from twistarm import arm_from_screws

KINDS = ("cubic", "quintic", "trapezoid")
WAYS = [(kind, stop) for kind in KINDS for stop in (False, True)]
STRAIGHT = [way for way in WAYS if way[1] or way[0] == "trapezoid"]

RATE = 1e-9
"""Relative excess over a rate limit that is rounding: what the planner promises."""

MET = 1e-9
"""Relative: a limit that is met exactly, but for the planner's own margin of 1e-10 per power of time."""

PASSES = 1e-9
"""A waypoint is passed to the rounding of a spline's solution [rad, m]."""

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


def with_rates(arm, **changes):
    return arm.limits.with_(RATES | changes, arm.joint_names)


def use(motion, limits):
    """The largest part of a velocity or acceleration limit that the motion uses."""
    return max((motion.peak(1) / limits.velocity).max(), (motion.peak(2) / limits.acceleration).max())
