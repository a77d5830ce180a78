"""The notation of the two textbooks, and an arm that stands in both.

MLS: Murray, Li & Sastry, A Mathematical Introduction to Robotic Manipulation, 1994.
L&P: Lynch & Park, Modern Robotics, 2017; its twists are (w, v) and are written that way here.
"""

from __future__ import annotations

import numpy as np

from twistarm import joints, screws

PRINTED_3 = 6e-4
"""Three printed decimals, computed from inputs of three decimals."""

X, Y, Z = np.eye(3)

L0, L1, L2 = 0.4, 0.55, 0.35

THETAS = np.random.default_rng(1).uniform(-3, 3, size=(20, 7))
"""Twenty arbitrary configurations; each arm takes as many columns as it has joints."""


def rot_z(a):
    return np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])


def pose(R, p):
    g = np.eye(4)
    g[:3, :3], g[:3, 3] = R, p
    return g


def sc(*angles):
    """The sines, then the cosines."""
    return [*np.sin(angles), *np.cos(angles)]


def lynch_park(*rows):
    """A (6, m) stack from rows of (w, v), as the book prints them."""
    return screws.from_angular_first(np.array(rows, dtype=float), twists="rows").T


def stanford():
    """MLS §3.4.1, example 3.9 (Stanford arm) and L&P §5.1.1, example 5.3 (RRPRRR): the same arm."""
    q1, qw = [0, 0, L0], [0, L1, L0]
    S = np.hstack([
        joints.revolute(Z, q1), joints.revolute(-X, q1), joints.prismatic(Y),
        joints.revolute(Z, qw), joints.revolute(-X, qw), joints.revolute(Y, qw),
    ])  # fmt: skip
    return S, pose(np.eye(3), qw)
