"""The guide: a course in the kinematics of robot arms, with lessons that run on your arm.

A lesson begins with `from twistarm import guide` and calls the names of this package. A program prints it, a notebook
displays it, and `twistarm guide` builds it into a page.
"""

from __future__ import annotations

from .teaching.figures import (
    AMBER,
    BLUE,
    COLOURS,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PINK,
    SKY,
    arm_points,
    axes2,
    axes3,
    plot_arm,
    plot_frame,
    plot_point,
    plot_screw,
    plot_vector,
)
from .teaching.output import figure, predict, rough, say, scene, slider, table, tex
from .teaching.reader import arm, arm_with, bundled, check, practice
from .teaching.svg import plot_motion

__all__ = ["AMBER", "BLUE", "COLOURS", "GREEN", "GREY", "INK", "ORANGE", "PINK", "SKY", "arm", "arm_points", "arm_with",
           "axes2", "axes3", "bundled", "check", "figure", "plot_arm", "plot_frame", "plot_motion", "plot_point",
           "plot_screw", "plot_vector", "practice", "predict", "rough", "say", "scene", "slider", "table",
           "tex"]  # fmt: skip
