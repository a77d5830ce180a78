"""Designs side by side: known ratios of reach, volume, payload, mass and time, and what is unknown."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import twistarm
from catalogue import load
from twistarm import Position, arm_from_screws, compare_designs, joints
from twistarm.arm.engine import MOST_JOINTS
from twistarm.support.errors import InputError


def elbow(scale: float) -> twistarm.Arm:
    """A shoulder that turns about z and y, and an elbow: its tool fills a ball."""
    home = np.eye(4)
    home[0, 3] = scale
    axes = [([0, 0, 1], 0.0), ([0, 1, 0], 0.0), ([0, 1, 0], 0.5 * scale)]
    return arm_from_screws(np.hstack([joints.revolute(axis, [x, 0, 0]) for axis, x in axes]), home)


def test_a_larger_arm_reaches_farther_and_sweeps_the_cube_of_it() -> None:
    small, large = compare_designs([elbow(1.0), elbow(1.2)])
    assert np.isclose(small.farthest, 1.0, rtol=1e-5)
    assert np.isclose(large.farthest, 1.2, rtol=1e-5)
    assert np.isclose(large.volume, 4 / 3 * np.pi * 1.2**3, rtol=0.01)
    assert np.isclose(small.volume, 4 / 3 * np.pi, rtol=0.01)
    assert np.isclose(small.condition, large.condition)
    ours = elbow(1.0)
    measured = ours.manipulability(ours.random_theta(1, 4000))
    assert np.isclose(small.condition, np.median(measured.condition), rtol=0.05)
    assert small.singular == large.singular
    assert np.isnan(small.payload)
    assert any("no Pinocchio model" in each for each in small.notes)
    assert small.name != large.name


def test_weaker_and_slower_joints(rover: twistarm.Arm) -> None:
    limits = {"effort": 0.5 * rover.limits.effort, "velocity": 0.5 * rover.limits.velocity}
    weak = replace(rover, name="weak", limits=rover.limits.with_(limits, rover.joint_names))
    near, far = ([0.8, 0.1, 0.7], [0.8, -0.3, 0.5])
    strong, other = compare_designs([rover, weak], [Position(p) for p in (near, far, near)])
    assert strong.mass == other.mass
    assert strong.volume == other.volume
    # Half the torque holds less than half, because the arm carries itself too.
    assert other.payload < 0.5 * strong.payload
    assert other.median_payload < 0.5 * strong.median_payload
    assert other.duration > strong.duration
    beyond = compare_designs([rover, weak], [Position(near), Position([3.0, 0, 0])])
    assert np.isnan(beyond[0].duration)
    assert any("no motion: " in each for each in beyond[0].notes)


@pytest.mark.parametrize("sides", [(0.3, 1.7, 0.9), (1.0, 1.0, 0.2)])
def test_slides_sweep_their_box(sides) -> None:
    """Its faces lie between the centres of cubes."""
    names = ["a", "b", "c"]
    limits = {"lower": dict.fromkeys(names, 0.0), "upper": dict(zip(names, sides, strict=True))}
    screws = np.hstack([joints.prismatic(axis) for axis in np.eye(3)])
    box, flat = compare_designs([arm_from_screws(screws, np.eye(4), joints=names, limits=limits), load("rr_planar")])
    assert np.isclose(box.volume, np.prod(sides), rtol=0.03)
    assert np.isclose(box.farthest, np.linalg.norm(sides), rtol=1e-4)
    assert flat.volume == 0.0


def test_an_arm_beyond_the_core_has_no_volume() -> None:
    axes = [joints.revolute(np.eye(3)[i % 3], [0.02 * i, 0, 0]) for i in range(MOST_JOINTS + 1)]
    long, _ = compare_designs([arm_from_screws(np.hstack(axes), np.eye(4)), elbow(1.0)])
    assert np.isnan(long.volume)
    assert long.farthest > 0.0
    assert any("no volume: " in each for each in long.notes)


@pytest.mark.parametrize(
    ("arms", "poses"), [([], ()), (None, ()), (["rover_arm"] * 2, ()), ([elbow(1.0)] * 2, [np.eye(4)])]
)
def test_wrong_arguments(arms, poses) -> None:
    with pytest.raises(InputError):
        compare_designs(arms, poses)
