"""Assertions for a team's own tests: an arm that is as it was, and a motion that collides with nothing."""

from __future__ import annotations

import os
from typing import Any

from ..arm.arm import Arm, require_arm
from ..arm.loading.load import load_arm
from ..collision import Scene, require_scene
from ..planning import Trajectory, load_trajectory
from ..planning.free_moves import first_collision
from ..support.checks import require
from ..support.errors import ComparisonError
from .crosscheck import crosscheck
from .difference import compare
from .other_readers import require_yourdfpy


def assert_arm(
    source: str | os.PathLike[str], *, against: str | os.PathLike[str] | None = None, samples: int = 200, **load: Any
) -> Arm:
    """Load an arm, prove product of exponentials = Pinocchio = yourdfpy, and that it is still the one frozen.

    In a test::

        def test_our_arm():
            assert_arm("arm/rover.urdf.xacro", against="arm/rover.golden.json")

    Args:
        source: As in `load_arm`.
        against: A golden file written by `freeze`, or whatever else `compare` takes. None for the cross-check alone.
        samples: Number of random configurations.
        **load: The options of `load_arm`.

    Returns:
        The arm.

    Raises:
        AssertionError: Engines disagree, or the arm has changed. The message gives every difference.
        MissingExtraError: yourdfpy is not installed: a proof that leaves an engine out is none.
    """
    __tracebackhide__ = True
    arm = load_arm(source, **load)
    check = crosscheck(arm, samples)
    require_yourdfpy()
    try:
        check.require()
        if against is not None:
            compare(arm, against).require()
    except ComparisonError as error:
        raise AssertionError(str(error)) from error
    return arm


def assert_free(
    arm: Arm, trajectory: Trajectory | str | os.PathLike[str], scene: Scene | str | os.PathLike[str] | None = None
) -> None:
    """Assert that a motion collides with nothing, without gaps between samples.

    In a test::

        def test_our_routine():
            assert_free(load_arm("arm/rover.urdf.xacro"), "arm/stow.csv", "arm/chassis.toml")

    Args:
        arm: The arm.
        trajectory: A `Trajectory`, or a file that `load_trajectory` reads.
        scene: A `Scene` of the arm or a scene file. None for the robot alone.

    Raises:
        AssertionError: The motion collides. The message gives the time, the pair and the depth.
        InputError: The motion or the scene is of another arm.
    """
    __tracebackhide__ = True
    if scene is None:
        scene = Scene(require_arm(arm))
    elif isinstance(scene, (str, os.PathLike)):
        scene = Scene.load(arm, scene)
    if isinstance(trajectory, (str, os.PathLike)):
        trajectory = load_trajectory(arm, trajectory)
    motion = require(trajectory, Trajectory, "trajectory", "from plan, plan_joint or load_trajectory")
    hit = first_collision(require_scene(scene, arm), motion)
    if hit is not None:
        raise AssertionError(f"{arm.name}: {hit}")
