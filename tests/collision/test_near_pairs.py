"""The near pairs of a scene: none is left out, and their approach is the derivative of the distance."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from test_scene import joint, link, robot
from twistarm import Scene, ServoState, TwistCommand, load_arm, servo_step
from twistarm.collision.near_pairs import LOOK
from twistarm.support.errors import UnitsWarning

STEP = 1e-5


@pytest.mark.parametrize("name", ["ur5", "rover_arm", "stanford"])
def test_no_near_pair_is_left_out_and_approaches_are_derivatives(name: str) -> None:
    arm = load_arm(name)
    scene, reach = Scene(arm, margin=0.02), np.full(arm.n, 0.05)
    scene.add_sphere("ball", 0.1, (0.5 * arm.reach, 0.1, 0.3))
    scene.add_box("box", (0.2, 0.3, 0.4), (-0.4 * arm.reach, 0.2, 0.2))
    scene.add_plane()
    for k, at in enumerate(np.random.default_rng(3).uniform(-arm.reach, arm.reach, (8, 3))):
        scene.add_box(f"box {k}", (0.05, 0.1, 0.15), at)
    pairs, compared = scene.near_pairs, 0
    theta = arm.random_theta(1)
    for way in np.random.default_rng(2).normal(scale=0.02, size=(25, arm.n)):
        theta = np.clip(theta + way, arm.limits.lower, arm.limits.upper)
        found = pairs.near(theta, reach, 8)
        first = found.closest
        pairs.distances(arm.pinocchio.q(arm.ready))  # the same bodies elsewhere
        found.measure(np.arange(len(found.pairs)))
        rows = np.flatnonzero(found.distances < np.inf)
        near, (distances, approach) = found.pairs[rows], pairs.measured(theta, found.pairs[rows])
        steps = STEP * np.vstack([np.zeros(arm.n), np.eye(arm.n), -np.eye(arm.n)])
        here, *beside = (pairs.distances(arm.pinocchio.q(theta + step)) for step in steps)
        assert scene.distance(theta).metres == pytest.approx(here.min(), abs=1e-12)
        assert found.distances[rows].tolist() == distances.tolist()
        assert found.approach.tolist() == pairs.measured(theta, found.pairs[first])[1].tolist()
        assert sorted(near) == np.flatnonzero(here < 0.02 + LOOK + pairs.speeds @ reach).tolist()
        assert found.distances[first] == pytest.approx(np.sort(here[near])[:8], abs=1e-6)
        slopes = (np.array(beside[: arm.n]) - beside[arm.n :]).T[near] / (2.0 * STEP)
        separate = distances > 0.001
        assert distances == pytest.approx(here[near], abs=1e-6)
        # Where nearest points jump within the step, the distance has no derivative.
        differing = np.abs(approach + slopes)[separate].max(axis=1, initial=0.0) > 1e-3
        assert differing.mean() < 0.1
        compared += separate.sum()
    assert compared > 25


def test_triangles_approach_too() -> None:
    arm = load_arm("panda")
    pairs, theta = Scene(arm, exact=True).near_pairs, arm.ready + 0.1
    kinds = np.array(["BVH" in type(body.shape).__name__ for body in pairs.bodies])
    both = np.flatnonzero([kinds[i] and kinds[j] for i, j in pairs.pairs])
    distances, approach = pairs.measured(theta, both)
    beside = [pairs.measured(theta + step, both)[0] for step in STEP * np.vstack([np.eye(arm.n), -np.eye(arm.n)])]
    slopes = (np.array(beside[: arm.n]) - beside[arm.n :]).T / (2.0 * STEP)
    assert (distances > 0.001).sum() > 3
    assert np.median(np.abs(approach + slopes)[distances > 0.001].max(axis=1)) < 1e-3


def test_a_scene_without_bodies_is_free(tmp_path: Path) -> None:
    parts = link("base"), link("tool"), joint("j", "revolute", "base", "tool", "0 0 1")
    scene = Scene(robot(tmp_path / "bare.urdf", "tool", *parts))
    assert scene.distance([0.1]).metres == np.inf
    assert not scene.collides([0.1])
    assert scene.is_free([0.1], [0.2])


def test_a_scene_without_pairs_bounds_nothing() -> None:
    arm = load_arm("scara")
    scene, state = Scene(arm), ServoState.at(arm, arm.ready)
    command = TwistCommand([0.05, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert scene.distance(arm.ready).metres == np.inf
    free, bound = (servo_step(arm, state, command, 0.01, scene=around)[1] for around in (None, scene))
    assert bound.theta_dot.tolist() == free.theta_dot.tolist()


@pytest.mark.parametrize("form", [list, np.array])
def test_angles_in_degrees_are_told_in_any_form(form: Callable[[list[float]], Any]) -> None:
    scene = Scene(load_arm("ur5"))
    for ask in (scene.collides, scene.distance, scene.contacts):
        with pytest.warns(UnitsWarning):
            ask(form([90.0] * 6))
