"""What is plotted of a trajectory."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import ArrayLike, NDArray

from recorded_poses import HOME, LEFT, REACH, ask, done, said
from twistarm import Arm
from twistarm.arm.usual_limits import with_defaults
from twistarm.planning.joint_space import plan_joint
from twistarm.planning.trajectory import Trajectory
from twistarm.viewer.parts.playback import Playback
from twistarm.viewer.parts.plots import MOST_POINTS, plots
from twistarm.viewer.stage import Stage
from viewer_page import swing

ROUNDED = 0.5000001e-6
"""Plots have six decimals."""


@pytest.mark.parametrize("kind", ["cubic", "trapezoid"])
def test_plots_are_samples_of_the_trajectory_and_of_what_limits_it(stage: Stage, kind: Any) -> None:
    assert said(stage, "plots")["times"] == []
    done(ask(stage, "plan", kind=kind, stop=False))
    message = said(stage, "plots")
    motion = plan_joint(stage.arm, [HOME, REACH, LEFT], kind=kind, limits=with_defaults(stage.arm))
    times = np.array(message["times"])
    assert (times[0], times[-1]) == (0.0, motion.duration)
    assert (np.diff(times) > 0).all()
    assert len(times) <= MOST_POINTS
    for order, rate in enumerate(("position", "velocity", "acceleration")):
        assert_allclose(np.transpose(message[rate]), motion(times, order), rtol=0, atol=ROUNDED)
        worst = np.abs(motion(np.linspace(0, motion.duration, 20_001), order)).max(axis=0)
        assert_allclose([joint["peak"][rate] for joint in message["joints"]], worst, rtol=1e-3)
    yaw, pitch, slide = message["joints"]
    assert (yaw["name"], yaw["unit"], slide["unit"]) == ("yaw", "rad", "m")
    assert yaw["limits"] == {"position": [None, None], "velocity": 1.0, "acceleration": 3.0}
    assert yaw["usual"] == ["velocity", "acceleration"]
    assert_allclose(yaw["range"], [-np.pi, np.pi])
    assert pitch["limits"] == {"position": [-1.5, 1.5], "velocity": 2.0, "acceleration": 3.0}
    assert slide["usual"] == ["acceleration"]


def test_a_jump_is_plotted_as_a_jump(arm: Arm) -> None:
    """A trapezoid's acceleration changes at once: between two samples a nanosecond of the motion apart."""
    motion = plan_joint(arm, [HOME, REACH], kind="trapezoid", limits={"velocity": 1.0, "acceleration": 2.0})
    message = plots(arm, Playback(motion))
    times, values = np.array(message["times"]), np.array(message["acceleration"])
    jumps = np.abs(np.diff(values, axis=1)).max(axis=0) > 1e-6
    assert jumps.sum() == len(motion.breakpoints) - 2
    assert np.diff(times)[jumps].max() < 1e-8


def test_a_trajectory_of_python_is_plotted_against_the_arm_s_own_limits(arm: Arm) -> None:
    stage = Stage(arm)
    stage.load(swing(arm), 1.0, False, 0.0)
    joints = said(stage, "plots")["joints"]
    assert [joint["limits"]["velocity"] for joint in joints] == [None, 2.0, 0.5]
    assert [joint["limits"]["acceleration"] for joint in joints] == [None] * 3
    assert all(joint["usual"] == [] for joint in joints)


def test_a_motion_of_many_pieces_and_one_of_none(arm: Arm) -> None:
    rng = np.random.default_rng(4)
    many = plan_joint(arm, arm.random_theta(rng, size=200), kind="trapezoid", limits=with_defaults(arm))
    assert len(plots(arm, Playback(many))["times"]) == MOST_POINTS <= 300  # about a plot's width in pixels
    still = plan_joint(arm, [HOME, HOME], limits=with_defaults(arm))
    assert plots(arm, Playback(still))["times"] == [0.0]


class Odd(Trajectory):
    """A motion of Python's own, one of whose rates, or one of whose peaks, is no number."""

    at: int
    number: float
    of_peak: bool

    def __call__(self, t: ArrayLike, order: int = 0) -> NDArray[np.float64]:
        values = np.array(super().__call__(t, order))
        if order == self.at and not self.of_peak:
            values[..., -1, 1] = self.number
        return values

    def peak(self, order: int) -> NDArray[np.float64]:
        values = np.array(super().peak(order))
        if order == self.at and self.of_peak:
            values[1] = self.number
        return values


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("at", [0, 1, 2])
@pytest.mark.parametrize("of_peak", [False, True])
def test_one_value_that_is_no_number_is_enough(arm: Arm, number: float, at: int, of_peak: bool) -> None:
    motion = swing(arm)
    odd = Odd(**{field.name: getattr(motion, field.name) for field in fields(Trajectory)})
    for name, value in {"at": at, "number": number, "of_peak": of_peak}.items():
        object.__setattr__(odd, name, value)
    message = plots(arm, Playback(odd))
    assert (message["times"], message["joints"], message["velocity"]) == ([], [], [])
