"""All configurations of a target: what a page asks for, where the arm goes, and what every page is told."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from recorded_poses import ask, done
from test_viewer_target import xyzw
from twistarm import Approach, Arm, InputError, load_arm, solve_ik_all
from twistarm.viewer import Viewer
from twistarm.viewer.stage import Stage
from viewer_page import Page

ROVER, ELBOW = load_arm("rover_arm"), load_arm("elbow")


def pose_at(arm: Arm, theta: Any) -> dict[str, Any]:
    g, _, _ = arm.by_pinocchio(theta)
    return {"position": g[:3, 3].tolist(), "xyzw": xyzw(g[:3, :3])}


def told(stage: Stage) -> tuple[dict[str, Any], int | None]:
    messages = {message["type"]: message for message in stage.messages()}
    return messages["solutions"], messages["solution"]["at"]


def asked(arm: Arm, kind: str = "pose", theta: Any = None) -> Stage:
    """A stage that was asked for all configurations of the pose that the tool has at theta."""
    stage = Stage(arm)
    done(ask(stage, "solutions", kind=kind, **pose_at(arm, arm.ready if theta is None else theta)))
    return stage


@pytest.mark.parametrize(("arm", "kind"), [(ROVER, "approach"), (ELBOW, "pose")], ids=["rover", "elbow"])
def test_every_step_meets_the_target_elsewhere(arm: Arm, kind: str) -> None:
    theta = arm.random_theta(4)
    stage = asked(arm, kind, theta)
    message, _ = told(stage)
    inside = [i for i, place in enumerate(message["places"]) if not place["beyond"]]
    assert inside
    assert len(message["theta"]) == len(message["places"])
    wanted, _, _ = arm.by_pinocchio(theta)
    stood = []
    for place in inside:
        ask(stage, "solution", place=place, ease=False)
        assert told(stage)[1] == place
        assert arm.limits.contains(stage.theta)
        assert_array_equal(message["theta"][place], stage.theta)
        g, _, _ = arm.by_pinocchio(stage.theta)
        assert_allclose(g[:3, 2:], wanted[:3, 2:], atol=1e-8)
        assert kind != "pose" or np.abs(g - wanted).max() < 1e-8
        stood.append(np.exp(1j * stage.theta))
    assert all(np.abs(a - b).max() > 0.01 for i, a in enumerate(stood) for b in stood[:i])


def test_beyond_the_limits_the_arm_does_not_go() -> None:
    stage = asked(ROVER, "approach", np.radians([0.0, 29.64, -111.9, -97.74, 0.0]))
    message, _ = told(stage)
    beyond = [i for i, place in enumerate(message["places"]) if place["beyond"]]
    assert beyond
    ask(stage, "solution", place=0, ease=False)
    before = stage.theta
    ask(stage, "solution", place=beyond[0], ease=False)
    assert told(stage)[1] == beyond[0]
    assert_array_equal(stage.theta, before)
    (said,) = message["places"][beyond[0]]["beyond"]
    name, value, sign, limit = said.split()
    i = ROVER.joint_names.index(name)
    bound = ROVER.limits.upper[i] if sign == ">" else ROVER.limits.lower[i]
    assert float(limit.rstrip("°")) == pytest.approx(np.degrees(bound), abs=0.05)
    assert (float(value.rstrip("°")) > float(limit.rstrip("°"))) == (sign == ">")


def test_what_moves_the_arm_otherwise_lets_them_go() -> None:
    stage = asked(ROVER, "approach")
    kept, _ = told(stage)
    assert kept["requested"]
    assert told(stage)[0] is kept
    ask(stage, "joint", name="wrist_roll", value=0.3)
    assert told(stage)[0]["requested"] is False
    with pytest.raises(InputError, match="press All configurations again"):
        ask(stage, "solution", place=0, ease=False)
    stage = asked(ROVER, "approach")
    theta = stage.theta
    ask(stage, "solutions_end")
    assert told(stage)[0]["requested"] is False
    assert stage.theta is theta


def test_none_is_an_answer() -> None:
    stage = Stage(ROVER)
    done(ask(stage, "solutions", kind="position", position=[9.0, 0.0, 0.0], xyzw=[0, 0, 0, 1]))
    message, at = told(stage)
    assert message["requested"]
    assert message["places"] == message["theta"] == []
    assert "that is certain" in message["words"]
    assert at is None
    with pytest.raises(InputError, match="quaternion of length 1"):
        ask(stage, "solutions", kind="pose", position=[0.0, 0.0, 1.0], xyzw=[0, 0, 0, 2])


def test_joints_that_the_target_leaves_free_stay_where_they_are() -> None:
    start = ROVER.ready + [0.0, 0.0, 0.0, 0.1, 0.2]
    stage = Stage(ROVER, start)
    done(ask(stage, "solutions", kind="position", **pose_at(ROVER, start)))
    message, _ = told(stage)
    assert "stay where they are" in message["words"]
    assert "there may be more" not in message["words"]
    ask(stage, "solution", place=len(message["places"]) - 1, ease=False)
    assert_allclose(stage.theta[3:], start[3:], atol=1e-12)


def test_a_program_shows_them() -> None:
    solutions = solve_ik_all(ROVER, Approach([0.8, 0.1, 0.7], direction=[1, 0, 0]))
    with Viewer(ROVER, open_browser=False) as viewer:
        viewer.show_solutions(solutions)
        assert_array_equal(viewer.theta, solutions[0])
        with Page(viewer) as page:
            page.until(lambda: page.latest.get("solution", {}).get("at") == 0)
            assert len(page.latest["solutions"]["places"]) == len(solutions) + len(solutions.outside)
            viewer.show_solutions(None)
            page.until(lambda: not page.latest["solutions"]["requested"])
        assert_array_equal(viewer.theta, solutions[0])
        with pytest.raises(InputError, match="configurations of another arm"):
            viewer.show_solutions(solve_ik_all(ELBOW, ELBOW.fk(ELBOW.ready)))
