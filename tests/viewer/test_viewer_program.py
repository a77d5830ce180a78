"""Recorded poses, the motion planned through them, undo and redo, and the way to a pose: the process's side."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from catalogue import load
from recorded_poses import HOME, LEFT, REACH, ask, done, names, said
from twistarm import Arm, Pose, Position, Trajectory, load_arm, solve_ik, solve_ik_all
from twistarm.planning.joint_space import plan_joint
from twistarm.support.errors import InputError, LimitError, TwistarmError
from twistarm.support.strict_json import LARGEST_MESSAGE, encode
from twistarm.viewer.messages import parse
from twistarm.viewer.parts.pose_list import LARGEST_LIST
from twistarm.viewer.stage import Stage
from viewer_page import swing


def test_names_are_made_up_and_none_comes_twice(stage: Stage) -> None:
    for name in ("", "  home ", "home", "", "pose 4"):
        ask(stage, "record", name=name)
    assert names(stage)[3:] == ["pose 4", "home 2", "home 3", "pose 7", "pose 4 2"]
    number = said(stage, "program")["poses"][0]["id"]
    for name, becomes in (("left", "left 2"), ("left 2", "left 2"), ("home", "home"), ("Ablage 置く", "Ablage 置く")):
        ask(stage, "rename", id=number, name=name)
        assert names(stage)[0] == becomes


@pytest.mark.parametrize(("of", "place", "order"), [(0, 2, "reach left home"), (2, 0, "left home reach"),
                                                    (1, 99, "home left reach"), (1, 1, "home reach left")])  # fmt: skip
def test_a_pose_is_moved_to_a_place(stage: Stage, of: int, place: int, order: str) -> None:
    ask(stage, "reorder", id=said(stage, "program")["poses"][of]["id"], place=place)
    assert names(stage) == order.split()


def test_a_number_that_is_gone_is_refused_in_words_and_never_comes_again(stage: Stage) -> None:
    gone = said(stage, "program")["poses"][2]["id"]
    ask(stage, "delete", id=gone)
    ask(stage, "record", name="new")
    assert names(stage) == ["home", "reach", "new"]
    for kind, fields in (("go", {"ease": False}), ("delete", {}), ("rename", {"name": "x"}), ("reorder", {"place": 0})):
        with pytest.raises(InputError, match=f"no pose number {gone} in the list: it was deleted"):
            ask(stage, kind, id=gone, **fields)
    assert names(stage) == ["home", "reach", "new"]


def test_a_pose_outside_the_limits_is_not_recorded(stage: Stage) -> None:
    stage.show(np.array([0.0, 1.6, 0.0]))
    with pytest.raises(LimitError, match=r"the pose 'far': pitch = 91.6732° is outside its limits"):
        ask(stage, "record", name="far")
    with pytest.raises(LimitError, match="the start puts joint 'pitch'"):
        ask(at_far := Stage(stage.arm, [0.0, -1.75, 0.1]), "record", name="")
    assert names(at_far) == []
    stage.show(np.array([0.0, 1.5 + 5e-7, 0.0]))
    ask(stage, "record", name="edge")
    assert said(stage, "program")["poses"][-1]["theta"] == [0.0, 1.5, 0.0]


@pytest.mark.parametrize("by", ["joint", "line"])
def test_a_motion_from_a_measured_start_beyond_a_limit_returns_inside_first(arm: Arm, by: str) -> None:
    stage = Stage(arm)
    for theta in ((0.0, -1.55, 0.1), (0.5, -1.0, 0.1)):
        stage.show(np.array(theta))
        ask(stage, "record", name="")
    first, second = (pose["id"] for pose in said(stage, "program")["poses"])
    with pytest.raises(LimitError, match="pitch"):
        ask(stage, "reorder", id=first, place=1)
    ask(stage, "move", id=second, by=by)
    motion = planned(stage, corner=0.0)
    program = said(stage, "program")
    assert program["planned"]
    assert "pitch by 2.8648°" in program["note"]
    assert_allclose(motion(0.0), (0.0, -1.55, 0.1), atol=1e-12)
    pitch = motion(np.linspace(0.0, motion.duration, 500))[:, 1]
    assert (np.diff(pitch[pitch < -1.5]) >= 0.0).all()
    assert_allclose(motion(motion.duration), (0.5, -1.0, 0.1), atol=1e-4)
    reloaded = Stage(arm)
    assert not [words for words in reloaded.take_over(stage) if "motion" in words]
    assert reloaded.playback is not None
    assert reloaded.playback.trajectory is motion


def test_a_saved_list_comes_back_by_joint_names(stage: Stage) -> None:
    before = {pose["id"] for pose in said(stage, "program")["poses"]}
    given = [{"name": "a", "theta": [0.1, 2.0, 0.3]}, {"name": "a", "theta": [0.2, 0, 0]}]
    ask(stage, "poses", joints=["slide", "yaw", "pitch"], poses=given)
    poses = said(stage, "program")["poses"]
    assert [(pose["name"], pose["theta"]) for pose in poses] == [("a", [2.0, 0.3, 0.1]), ("a 2", [0.0, 0.0, 0.2])]
    assert before.isdisjoint(pose["id"] for pose in poses)
    ask(stage, "poses", joints=["yaw", "pitch", "slide"], poses=[])
    assert names(stage) == []


@pytest.mark.parametrize(
    ("joints", "theta", "reason"),
    [
        (["yaw", "pitch"], [0, 0], "yaw, pitch; small has yaw, pitch, slide"),
        (["yaw", "pitch", "pitch"], [0, 0, 0], "yaw, pitch, pitch"),
        (["yaw", "pitch", "slide"], [0, 0], "'p' has 2 values"),
        (["yaw", "pitch", "slide"], [0, 0, 0.3], r"'p': slide = 0.3"),
        (["yaw", "pitch", "slide"], [1e9, 0, 0], r"theta\[0\]"),
    ],
)
def test_a_list_that_does_not_fit_is_refused_whole(
    stage: Stage, joints: list[str], theta: list[float], reason: str
) -> None:
    poses = [{"name": "good", "theta": [0.0] * len(joints)}, {"name": "p", "theta": theta}]
    with pytest.raises(TwistarmError, match=reason):
        ask(stage, "poses", joints=joints, poses=poses)
    assert names(stage) == ["home", "reach", "left"]


def test_a_list_is_never_longer_than_one_message(stage: Stage) -> None:
    with pytest.raises(InputError, match="a pose's name has at most 60 characters; got 61"):
        ask(stage, "record", name="x" * 61)
    stage.show(np.array([1 / 3, 1 / 7, 1 / 9]))

    def record_on_and_on() -> None:
        for _ in range(2000):
            ask(stage, "record", name="置" * 40)

    with pytest.raises(InputError, match=rf"a list has at most {LARGEST_LIST} bytes; \d+ poses would have"):
        record_on_and_on()
    poses = said(stage, "program")["poses"]
    saved = [{name: pose[name] for name in ("name", "theta", "by")} for pose in poses]
    again = encode({"type": "poses", "joints": stage.arm.joint_names, "poses": saved, "number": 2**50})
    assert LARGEST_LIST < len(again) + 400 < LARGEST_MESSAGE
    ask(stage, "delete", id=poses[0]["id"])
    stage.handle(parse(again), 0.0)
    assert len(names(stage)) == len(poses)


@pytest.mark.parametrize(("kind", "stop"), [("s_curve", False), ("time_optimal", False), ("time_optimal", True)])
def test_the_plan_is_that_of_plan_joint_and_waits_to_be_played(stage: Stage, kind: Any, stop: bool) -> None:
    shares: list[float] = []
    job = ask(stage, "plan", kind=kind, stop=stop)
    assert job is not None
    assert job.key == "plan"
    result = job.work(shares.append)
    assert not said(stage, "program")["planned"]
    job.finish(result)
    limits = {"acceleration": [3.0, 3.0, 1.0], "velocity": [1.0, 2.0, 0.5]}  # the arm gives velocities but the yaw's
    expected = plan_joint(stage.arm, [HOME, REACH, LEFT], kind=kind, limits=limits, stop_at_waypoints=stop)
    assert stage.playback is not None
    loaded = stage.playback.trajectory
    t = np.linspace(0, expected.duration, 50)
    assert loaded.duration == expected.duration
    assert_array_equal(loaded(t), expected(t))
    assert not stage.running
    assert_array_equal(stage.theta, HOME)
    assert shares[-1] == 1.0
    assert said(stage, "program")["planned"]
    assert [said(stage, "program")[name] for name in ("kind", "stop")] == [kind, stop]
    for used in ("velocity 1 rad/s for yaw", "3 rad/s² for yaw, pitch", "1 m/s² for slide"):
        assert used in said(stage, "program")["note"]
    assert said(stage, "path")["points"][0] == pytest.approx(stage.arm.fk(HOME)[:3, 3].tolist(), abs=1e-6)
    ask(stage, "play")
    assert stage.running


def test_an_edited_list_is_no_longer_that_of_the_motion(stage: Stage) -> None:
    done(ask(stage, "plan", kind="s_curve", stop=False))
    first = said(stage, "program")["poses"][0]["id"]
    ask(stage, "rename", id=first, name="start")
    assert said(stage, "program")["planned"]
    ask(stage, "reorder", id=first, place=2)
    assert not said(stage, "program")["planned"]
    assert "plan again" in said(stage, "program")["note"]
    ask(stage, "reorder", id=first, place=0)
    assert said(stage, "program")["planned"]
    stage.load(swing(stage.arm)).play(0.0)
    assert not said(stage, "program")["planned"]
    assert said(stage, "program")["note"] == ""


def test_what_cannot_be_planned_is_said(stage: Stage) -> None:
    ids = [pose["id"] for pose in said(stage, "program")["poses"]]
    for number in ids[:2]:
        ask(stage, "delete", id=number)
    with pytest.raises(InputError, match="two poses"):
        ask(stage, "plan", kind="s_curve", stop=False)
    ask(stage, "go", id=ids[2], ease=False)
    ask(stage, "record", name="again")
    with pytest.raises(InputError, match="the same"):
        ask(stage, "plan", kind="s_curve", stop=False)


def test_while_a_servo_drives_poses_are_recorded_and_no_motion_is_loaded(stage: Stage) -> None:
    job = ask(stage, "plan", kind="s_curve", stop=False)
    assert job is not None
    result = job.work(lambda share: None)
    stage.take_commands()
    ask(stage, "record", name="jogged")
    assert names(stage)[-1] == "jogged"
    with pytest.raises(InputError, match="not loaded: a servo drives the arm"):
        job.finish(result)
    assert said(stage, "player")["duration"] is None


ARM = load("rover_arm")
HERE = ARM.fk(ARM.ready)[:3, 3]
WAY = 1e-4
"""How far a tool may leave its way [m]."""

Points = NDArray[np.float64]


def meeting(*offset: float) -> Points:
    """A configuration with the tool's origin beside that of the ready one [m]."""
    found = solve_ik(ARM, Position(HERE + offset), ARM.ready)
    assert found.converged
    return found.theta


def recorded(*poses: tuple[Points, str]) -> Stage:
    stage = Stage(ARM, ARM.ready)
    for theta, by in poses:
        stage.show(theta)
        ask(stage, "record", name="")
        ask(stage, "move", id=said(stage, "program")["poses"][-1]["id"], by=by)
    return stage


def planned(stage: Stage, **asked: Any) -> Trajectory:
    done(ask(stage, "plan", **{"kind": "s_curve", "stop": False, "corner": 0.02, **asked}))
    assert stage.playback is not None
    return stage.playback.trajectory


def way(motion: Trajectory) -> Points:
    return ARM.fk(motion(np.linspace(0.0, motion.duration, 2001)))[:, :3, 3]


def off_line(points: Points, a: Points, b: Points) -> Points:
    """Distances of points from the straight piece between a and b."""
    along = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.linalg.norm(points - (a + along[:, None] * (b - a)), axis=1)


def test_lines_are_straight_and_corners_round_within_their_radius() -> None:
    thetas = ARM.ready, meeting(0.0, 0.0, -0.15), meeting(0.0, 0.2, -0.15)
    a, b, c = (ARM.fk(theta)[:3, 3] for theta in thetas)
    stage = recorded(*((theta, "line") for theta in thetas))
    for asked, most in (({"stop": True}, WAY), ({"corner": 0.03}, 0.03)):
        points = way(planned(stage, **asked))
        away = np.minimum(off_line(points, a, b), off_line(points, b, c))
        assert away.max() <= most
        near = np.linalg.norm(points - b, axis=1).min()
        assert near < WAY if "stop" in asked else near > 0.005
        free = np.linalg.norm(points - b, axis=1) > 0.031
        assert away[free].max() <= WAY
    path = said(stage, "path")
    assert_array_equal(path["waypoints"], thetas)
    assert path["ids"] == [pose.id for pose in stage.poses.poses]
    ideal = np.array(path["ideal"])
    assert np.minimum(off_line(ideal, a, b), off_line(ideal, b, c)).max() < 1e-6
    assert np.linalg.norm(ideal - b, axis=1).min() < 1e-6


def test_the_poses_at_which_the_arm_stops_in_place_of_rounding_are_named() -> None:
    """A line straight on is passed; at the end of an arc, whose turn is sharp, the arm stops."""
    back = meeting(0.0, 0.3, -0.15)
    stage = recorded(
        (ARM.ready, "line"), (meeting(0.0, 0.08, -0.08), "via"), (meeting(0.0, 0.16, 0.0), "line"),
        (meeting(0.0, 0.16, -0.15), "line"), (back, "line"), (ARM.ready, "joint"),
    )  # fmt: skip
    motion = planned(stage, corner=0.01)
    at_rest = np.abs(motion(motion.times[1:-1], 1)).max(axis=1) < 1e-9
    assert at_rest.tolist() == [False, False, True]
    assert re.findall(r"Stops at ('.*?'):", said(stage, "program")["note"]) == ["'pose 5'"]
    planned(stage, stop=True)
    assert "stops" not in said(stage, "program")["note"]
    ask(stage, "delete", id=stage.poses.poses[2].id)
    ask(stage, "move", id=stage.poses.poses[-1].id, by="via")
    with pytest.raises(InputError, match="arc .*'pose 6'"):
        planned(stage)


def test_torque_limits_count_with_the_payload_of_the_request() -> None:
    stage = recorded((ARM.ready, "joint"), (ARM.ready + [0.1, -0.4, -0.6, 0.2, 0.5], "joint"))
    free, heavy = planned(stage, kind="time_optimal"), {"torques": True, "payload": 6.0}
    motion = planned(stage, kind="time_optimal", **heavy)
    t = np.linspace(0.0, motion.duration, 1001)
    used = np.abs(
        ARM.inverse_dynamics(*(motion(t, order) for order in range(3)), payload=6.0) / ARM.limits.effort
    ).max()
    assert motion.duration > 1.001 * free.duration
    assert 0.98 < used < 1.001
    assert heavy.items() <= said(stage, "program").items()
    with pytest.raises(LimitError, match="needs .* to hold"):
        planned(stage, torques=True, payload=60.0)


def test_where_a_line_cannot_be_followed_is_drawn_and_named() -> None:
    """From before the arm to behind it: the straight way leads through its base."""
    behind = ARM.ready.copy()
    behind[ARM.joint_names.index("shoulder")] = ARM.limits.lower[ARM.joint_names.index("shoulder")]
    behind[ARM.joint_names.index("elbow")] = 0.5
    stage = recorded((ARM.ready, "line"), (behind, "line"))
    with pytest.raises(InputError, match=r"'pose 2' .*\d+ %"):
        planned(stage)
    path, a, b = said(stage, "path"), HERE, ARM.fk(behind)[:3, 3]
    assert off_line(np.array([path["stopped"]["position"]]), a, b)[0] < WAY
    assert path["stopped"]["words"].startswith("stops at ")
    assert path["points"] == []
    assert off_line(np.array(path["ideal"]), a, b).max() < 1e-6
    g, _, _ = ARM.by_pinocchio(path["stopped"]["arm"])
    assert_allclose(g[:3, 3], path["stopped"]["position"], atol=1e-6)
    assert stage.playback is None


def test_a_line_that_ends_in_another_configuration_is_told() -> None:
    arm = load_arm("ur5")
    flipped = solve_ik_all(arm, Pose(arm.fk(arm.ready)), arm.ready).theta[-1]
    stage, away = Stage(arm, arm.ready), arm.ready.copy()
    away[0] += 0.1
    for theta in (away, flipped, arm.ready):
        stage.show(theta)
        ask(stage, "record", name="")
    for pose, by in zip(stage.poses.poses[1:], ("screw", "joint"), strict=True):
        ask(stage, "move", id=pose.id, by=by)
    motion = planned(stage)
    j = int(np.abs(flipped - motion.waypoints[1]).argmax())
    assert abs(flipped[j] - motion.waypoints[1, j]) > 0.5
    told = re.findall(r"'(pose \d)' is reached in another configuration: (\w+) differs", said(stage, "program")["note"])
    assert told == [("pose 2", arm.joint_names[j])]


def test_how_the_arm_moves_is_saved_undone_and_checked() -> None:
    stage = recorded((ARM.ready, "joint"), (meeting(0.0, 0.0, -0.1), "line"))
    poses = said(stage, "program")["poses"]
    with pytest.raises(InputError, match="by .*'spline'"):
        ask(stage, "move", id=poses[1]["id"], by="spline")
    ask(stage, "move", id=poses[1]["id"], by="screw")
    ask(stage, "undo")
    saved = [{key: pose[key] for key in ("name", "theta", "by")} for pose in said(stage, "program")["poses"]]
    ask(stage, "poses", joints=list(ARM.joint_names), poses=saved)
    assert [pose["by"] for pose in said(stage, "program")["poses"]] == ["joint", "line"]
    with pytest.raises(InputError, match="by of the pose 'pose 1' must be one of joint"):
        ask(stage, "poses", joints=list(ARM.joint_names), poses=[{**saved[0], "by": "jump"}])


def test_every_edit_of_the_list_is_undone_and_redone(stage: Stage) -> None:
    """Back through four edits and forth again the list is what it was, numbers and all."""
    first, second, third = (pose["id"] for pose in said(stage, "program")["poses"])
    ask(stage, "rename", id=first, name="start")
    ask(stage, "reorder", id=third, place=0)
    ask(stage, "delete", id=second)
    ask(stage, "poses", joints=list(stage.arm.joint_names), poses=[{"name": "other", "theta": list(REACH)}])
    stood = stage.theta
    seen = [stage.poses.poses]
    for _ in range(4):
        ask(stage, "undo")
        seen.append(stage.poses.poses)
    assert [[pose.name for pose in poses] for poses in seen] == [
        ["other"], ["left", "start"], ["left", "start", "reach"], ["start", "reach", "left"], ["home", "reach", "left"]
    ]  # fmt: skip
    assert [pose.id for pose in seen[-1]] == [first, second, third]
    assert stage.theta is stood
    for poses in reversed(seen[:-1]):
        ask(stage, "redo")
        assert stage.poses.poses is poses
    with pytest.raises(InputError, match="nothing to redo"):
        ask(stage, "redo")


def test_the_way_to_a_pose_is_straight_eased_and_ends_on_it_to_the_bit(stage: Stage) -> None:
    ask(stage, "theta", theta=list(HOME))
    goal = np.array(REACH)
    ask(stage, "go", id=said(stage, "program")["poses"][1]["id"], ease=True)
    assert not said(stage, "frame")["running"]  # no trajectory plays
    shares = []
    for now in (0.0, 0.01, 0.125, 0.25, 0.375, 0.49):
        stage.advance(now)
        way = stage.theta - np.array(HOME)
        shares.append(float(way @ (goal - HOME) / ((goal - HOME) @ (goal - HOME))))
        assert_allclose(way, shares[-1] * (goal - HOME), atol=1e-12)
    assert_allclose(shares[3], 0.5)
    assert shares[1] < 0.01 < 0.99 < shares[5]  # slow at both ends
    with pytest.raises(LimitError):
        ask(stage, "joint", name=stage.arm.joint_names[2], value=99.0)
    assert stage.moving, "what is refused does not end it"
    stage.advance(0.5)
    assert_array_equal(stage.theta, goal)
    assert not stage.moving


def pause_after_play(stage: Stage) -> None:
    ask(stage, "play")
    assert stage.running
    ask(stage, "pause")


OTHERS: dict[str, Callable[[Stage], Any]] = {
    "joint": lambda stage: ask(stage, "joint", name=stage.arm.joint_names[0], value=0.11),
    "play": pause_after_play,
    "show": lambda stage: stage.show(stage.theta),
    "servo": lambda stage: stage.begin_drive(""),
}


@pytest.mark.parametrize("other", OTHERS)
def test_whatever_else_moves_the_arm_ends_the_way_to_a_pose(stage: Stage, other: str) -> None:
    ask(stage, "theta", theta=list(HOME))
    done(ask(stage, "plan", kind="s_curve", stop=False))
    ask(stage, "go", id=said(stage, "program")["poses"][1]["id"], ease=True)
    stage.advance(0.2)
    there = np.array([0.11, *stage.theta[1:]]) if other == "joint" else stage.theta
    OTHERS[other](stage)
    stage.advance(0.3)
    assert_array_equal(stage.theta, there)
    assert not stage.moving
