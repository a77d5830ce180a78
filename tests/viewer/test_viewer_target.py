"""The tool's target: what a page has solved, what the arm shows, and what every page is told."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio
import pytest
from numpy.testing import assert_array_equal

from recorded_poses import ask, said
from twistarm import InputError, load_arm
from twistarm.planning.joint_space import plan_joint
from twistarm.support.errors import LimitError
from twistarm.viewer.stage import Stage

ROVER = load_arm("rover_arm")
MOTION = plan_joint(ROVER, [ROVER.ready, 0.9 * ROVER.ready], limits={"velocity": 1, "acceleration": 2})
THETA = [0.1, 0.2, -0.3, 0.4, 0.5]
SOLVED: dict[str, Any] = {
    "kind": "approach", "position": [0.5, 0.0, 0.6], "xyzw": [0.0, 0.0, 0.0, 1.0],
    "theta": THETA, "converged": False, "words": "out of reach\nby far", "ghost": [0.1, 0.2, -9.3, 0.4, 0.5],
}  # fmt: skip


def xyzw(R: Any) -> list[float]:
    """Pinocchio's quaternion of a rotation."""
    numbers: list[float] = pinocchio.Quaternion(np.array(R)).coeffs().tolist()
    return numbers


@pytest.mark.parametrize("ghost", [SOLVED["ghost"], None], ids=["ghost", "none"])
def test_what_a_page_has_solved_is_shown_and_told_to_all(ghost: Any) -> None:
    stage = Stage(ROVER)
    stage.load(MOTION, loop=True).play(0.0)
    assert ask(stage, "target", stage=stage.number, **{**SOLVED, "ghost": ghost or []}) is None
    assert not stage.running
    assert_array_equal(stage.theta, THETA)
    given = {name: SOLVED[name] for name in ("kind", "position", "xyzw")}
    assert said(stage, "target") == {
        "type": "target",
        "given": given,
        "converged": False,
        "words": SOLVED["words"],
        "ghost": ghost,
    }
    assert said(stage, "target") is said(stage, "target")


MOVES: dict[str, Callable[[Stage], Any]] = {
    "slider": lambda stage: ask(stage, "joint", name="wrist_roll", value=0.3),
    "release": lambda stage: ask(stage, "release"),
    "trajectory": lambda stage: stage.load(MOTION).play(0.0),
}


@pytest.mark.parametrize("moved", MOVES)
def test_what_moves_the_arm_otherwise_lets_the_target_go(moved: str) -> None:
    stage = Stage(ROVER)
    ask(stage, "target", stage=stage.number, **SOLVED)
    MOVES[moved](stage)
    assert said(stage, "target")["given"] is None


@pytest.mark.parametrize(
    ("spoilt", "reason"),
    [
        ({"xyzw": [0, 0, 0, 0]}, "length 0"),
        ({"xyzw": [0, 0, 0, 2]}, "length 2"),
        ({"theta": THETA[:4]}, "wrist_roll; got"),
        ({"theta": [0.6, *THETA[1:]]}, "slide = 0.6 is outside its limits"),
        ({"ghost": [1.0]}, "wrist_roll; got"),
        ({"stage": 0}, "another arm"),
    ],
)
def test_what_can_be_no_answer_is_refused_and_changes_nothing(spoilt: dict[str, Any], reason: str) -> None:
    stage = Stage(ROVER)
    before = stage.theta
    with pytest.raises((InputError, LimitError), match=reason):
        ask(stage, "target", **{"stage": stage.number, **SOLVED, **spoilt})
    assert stage.theta is before
    assert said(stage, "target")["given"] is None


def test_tolerances_hold_until_others_are_chosen() -> None:
    stage = Stage(ROVER)
    for tolerance, kept in ((0.5, {"position_tol": 0.5}), (0.0, {})):
        ask(stage, "tolerances", position=tolerance, orientation=0.0)
        assert said(stage, "tolerances") == {"type": "tolerances", "position": tolerance, "orientation": 0.0}
        assert stage.tolerances == kept
    with pytest.raises(InputError, match="position"):
        ask(stage, "tolerances", position=-1.0, orientation=0.0)
