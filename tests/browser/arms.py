"""The arms that the page is tried with: one in the quick tests, in the long ones the others too; how they are drawn."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from twistarm import Arm, available_arms, load_arm

ARMS = ("rover_arm", *(pytest.param(name, marks=pytest.mark.slow) for name in ("rover_arm_6dof", "panda")))

# Meshcat takes a matrix apart into position, quaternion and scale: a few roundings in double precision.
DRAWN = 1e-12


@functools.cache
def load(name: str) -> Arm:
    """An arm of the catalogue, once."""
    if name == "panda" and name not in available_arms():
        pytest.skip("example-robot-data is not installed")
    return load_arm(name)


def assert_drawn(page: Any, arm: Arm, theta: Any = None, tol: float = DRAWN) -> None:
    """Every link's node, and the tool's frame, stand in the scene where arm.poses has them at what the page shows."""
    # One evaluation: a frame that arrives between two would make them tell of different moments.
    shown, links, drawn = page.evaluate(
        """() => {
          const { links } = twistarm.state.hello;
          const nodes = [...Object.values(links), "/frames/tool"];
          return [twistarm.state.frame, links, nodes.map((path) => twistarm.view.drawn(path))];
        }"""
    )
    poses = arm.poses(shown["theta"] if theta is None else theta, shown["others"])
    assert set(links) == set(arm.description.links if arm.description else ())
    for name, columns in zip([*links, arm.tip], drawn, strict=True):
        assert_allclose(np.array(columns).reshape(4, 4).T, poses[name], atol=tol, err_msg=name)
