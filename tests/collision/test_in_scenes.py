"""Inverse kinematics and motions in scenes: free answers, true reasons, and nothing passed through."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

from test_scene import SHAPES, joint, link, robot, slider
from twistarm import (
    Arm,
    Dwell,
    FreeMove,
    InputError,
    JointMove,
    LimitError,
    LineMove,
    PathError,
    Position,
    Scene,
    StopReason,
    assert_free,
    load_arm,
    plan,
    plan_joint,
    save_trajectory,
    solve_ik,
    solve_ik_all,
    solve_ik_batch,
)
from twistarm.planning import free_moves


def beside_a_plate(name: str) -> tuple[Arm, Scene]:
    """An arm with a plate of 1 mm before it."""
    arm = load_arm(name, limits={"acceleration": 5.0})
    scene = Scene(arm)
    scene.add_box("plate", (0.001, 0.8, 0.8), (0.45 * arm.reach, 0.0, 0.5 * arm.reach))
    return arm, scene


def at_a_wall(tmp_path: Path, shape: str = SHAPES["sphere"], margin: float = 0.0) -> tuple[Arm, Scene]:
    """A slider with a wall across x, 0.2 m thick, whose top is at z = 1."""
    arm = slider(tmp_path, shape)
    scene = Scene(arm, margin=margin)
    scene.add_box("wall", (0.2, 2.0, 4.0), (0.0, 0.0, -1.0))
    return arm, scene


def free_configurations(scene: Scene, count: int, seed: int) -> np.ndarray:
    thetas = scene.arm.random_theta(seed, 20 * count)
    return np.array([theta for theta in thetas if not scene.collides(theta)][:count])


@pytest.mark.parametrize("name", ["ur5", "rover_arm"])
@pytest.mark.parametrize("whole", [True, False], ids=["pose", "position"])
def test_a_target_that_some_free_configuration_meets_gets_a_free_one(name: str, whole: bool) -> None:
    arm, scene = beside_a_plate(name)
    scene.add_box("table", (0.5 * arm.reach, arm.reach, 0.05), (0.55 * arm.reach, 0.0, 0.2 * arm.reach))
    targets = arm.fk(free_configurations(scene, 40, 3))
    avoided = 0
    for g in targets:
        found = solve_ik(arm, g if whole else Position(g[:3, 3]), scene=scene)
        assert found.converged
        assert not scene.collides(found.theta)
        avoided += any("collides" in note for note in found.notes)
    assert avoided or whole
    asked = targets if whole else [Position(g[:3, 3]) for g in targets]
    batch = solve_ik_batch(arm, asked, scene=scene, threads=2)
    assert batch.converged.all()
    assert not scene.collides(batch.theta).any()


def test_all_configurations_are_marked() -> None:
    """The tool points down 10 cm above the base plane: with the elbow below, the arm goes through it."""
    arm = load_arm("ur5")
    scene = Scene(arm)
    scene.add_plane("ground")
    scene.allow("ground", "base_link")
    g = np.diag([1.0, -1.0, -1.0, 1.0])
    g[:3, 3] = 0.5, 0.1, 0.1
    found = solve_ik_all(arm, g, scene=scene)
    assert found.colliding.tolist() == [scene.collides(theta) for theta in found.theta]
    assert 0 < found.colliding.sum() < len(found)
    assert f"{found.colliding.sum()} of them in collision" in found.explain()


def test_a_target_inside_an_obstacle_names_the_pair_and_the_depth(tmp_path: Path) -> None:
    """The hand, a sphere of radius 0.1, in the middle of a box: 0.5 + 0.1 deep."""
    arm = slider(tmp_path, SHAPES["sphere"])
    scene = Scene(arm)
    scene.add_box("wall", (1.0, 2.0, 2.0), (1.5, 0.0, 0.0))
    found = solve_ik(arm, Position([1.5, 0.0, 0.0]), scene=scene)
    assert (found.stop, found.converged) == (StopReason.IN_COLLISION, False)
    assert [set(contact.links) for contact in found.contacts] == [{"hand", "wall"}]
    assert found.contacts[0].distance == pytest.approx(-0.6, abs=1e-4)
    assert "hand and wall overlap by 600 mm" in found.explain()
    assert solve_ik(arm, Position([0.5, 0.0, 0.0]), scene=scene).converged
    batch = solve_ik_batch(arm, [Position([0.5, 0.0, 0.0]), Position([1.5, 0.0, 0.0])], scene=scene)
    assert batch.converged.tolist() == [True, False]
    assert (batch.stop[1], batch[-1].contacts) == (StopReason.IN_COLLISION, found.contacts)
    for kept, answer in ((pickle.loads(pickle.dumps(found)), found), (pickle.loads(pickle.dumps(batch))[1], batch[1])):
        assert (kept.stop, kept.contacts) == (answer.stop, answer.contacts)


def test_a_scene_of_another_arm_is_refused(tmp_path: Path) -> None:
    scene = Scene(slider(tmp_path, SHAPES["sphere"]))
    other = load_arm("rover_arm")
    with pytest.raises(InputError, match="scene"):
        solve_ik(other, Position([0.5, 0.0, 0.5]), scene=scene)
    with pytest.raises(InputError, match="scene"):
        plan(other, JointMove("ready"), scene=scene)
    twice = load_arm("ur5"), load_arm("ur5")
    assert solve_ik(twice[0], twice[0].home, scene=Scene(twice[1])).converged


@pytest.mark.parametrize("name", ["ur5", "rover_arm", "panda"])
def test_the_first_collision_of_a_motion_is_that_of_dense_samples(name: str) -> None:
    """Also through a plate of 1 mm. Between two samples the tool moves less than 1 mm."""
    arm, scene = beside_a_plate(name)
    ends = free_configurations(scene, 12, 5)
    hits = 0
    for start, goal in zip(ends[::2], ends[1::2], strict=True):
        motion = plan(arm, JointMove(goal), start=start)
        found = scene.first_collision(motion)
        t = np.linspace(0.0, motion.duration, 8000)
        colliding = scene.collides(motion(t), threads=2)
        assert (found is not None) == colliding.any()
        if found is not None:
            hits += 1
            assert found.time == pytest.approx(t[colliding.argmax()], abs=5e-3)
            assert found.contacts
            with pytest.raises(PathError, match=r"segment 1 \(JointMove\): it collides"):
                plan(arm, JointMove(goal), start=start, scene=scene)
    assert hits


def test_a_wall_thinner_than_a_step_is_not_passed(tmp_path: Path) -> None:
    """Thin plates anywhere on the way of a small sphere."""
    arm = slider(tmp_path, '<sphere radius="0.0005"/>')
    for x in np.random.default_rng(0).uniform(-1.8, 1.8, 8):
        scene = Scene(arm)
        scene.add_box("plate", (0.001, 1.0, 1.0), (x, 0.0, 0.0))
        assert not scene.is_free([-1.9, 0.0], [1.9, 0.0])
        assert scene.is_free([-1.9, 0.6], [1.9, 0.6])


def test_a_free_move_goes_round(tmp_path: Path) -> None:
    """A wall across x from the floor to z = 1: the way leads over it, at rest nowhere in it."""
    pytest.importorskip("ompl")
    arm = slider(tmp_path, SHAPES["sphere"])
    arm = load_arm(tmp_path / "slider.urdf", tip="hand", limits={"acceleration": 5.0})
    scene = Scene(arm, margin=0.01)
    scene.add_box("wall", (0.2, 2.0, 4.0), (0.0, 0.0, -1.0))
    segments = [FreeMove([1.0, 0.0], label="there"), Dwell(0.2), LineMove(Position([1.2, 0.0, 0.1])), FreeMove([-1, 0])]
    motion = plan(arm, segments, start=[-1.0, 0.0], scene=scene)
    way = motion(np.linspace(0.0, motion.duration, 5000))
    assert not scene.collides(way).any()
    assert way[:, 1].max() > 1.1  # over the wall
    assert motion.waypoints[0].tolist() == [-1.0, 0.0]
    assert motion.waypoints[-1] == pytest.approx([-1.0, 0.0])
    assert "there" in [label for _, label in motion.labels] or "there" in str(motion.labels)


def test_free_moves_are_planned_every_time(tmp_path: Path) -> None:
    """After a move with a blend, and straight ones, whose timing keeps to the proven way."""
    arm = load_arm("rover_arm", limits={"acceleration": 5.0})
    scene = Scene(arm)
    motion = plan(arm, [JointMove(arm.ready + 0.05, blend=0.01), FreeMove("ready")], scene=scene)
    assert motion.waypoints[-1] == pytest.approx(arm.ready)
    ends = free_configurations(scene, 24, 9)
    for start, goal in zip(ends[::2], ends[1::2], strict=True):
        if scene.is_free(start, goal):
            motion = plan(arm, FreeMove(goal), start=start, scene=scene)
            joint = np.abs(goal - start).argmax()
            share = (motion(np.linspace(0.0, motion.duration, 50)) - start) / (goal - start)[joint]
            assert share == pytest.approx(share[:, [joint]] * (goal - start) / (goal - start)[joint], abs=1e-9)
    with pytest.raises(LimitError):
        plan(arm, FreeMove(arm.ready + 9.0), scene=scene)


@pytest.mark.parametrize(
    ("segments", "message"),
    [
        ([FreeMove([0.0, 0.0])], r"segment 1 .*goal collides: hand and wall overlap by 200 mm"),
        ([FreeMove([1.5, 0.0]), JointMove([0.0, 0.0])], r"segment 2 \(JointMove\): it collides .* hand and wall"),
        ([FreeMove([1.5, 0.0]), FreeMove([9.0, 0.0])], "segment 2 "),
    ],
)
def test_a_refusal_names_segment_and_pair(tmp_path: Path, segments: list[JointMove], message: str) -> None:
    arm, scene = at_a_wall(tmp_path)
    with pytest.raises((PathError, LimitError), match=message):
        plan(arm, segments, start=[1.0, 0.0], scene=scene)


def test_a_refusal_says_how_far_the_tool_comes(tmp_path: Path) -> None:
    """The hand, of radius 0.1, comes from x = 1 on the way to −1 to the face of the wall at 0.1: after 0.8 of 2 m."""
    arm, scene = at_a_wall(tmp_path)
    for move in (LineMove(Position([-1.0, 0.0, 0.0])), JointMove([-1.0, 0.0])):
        with pytest.raises(PathError) as error:
            plan(arm, [JointMove([1.0, 0.0]), move], start=[1.0, 0.5], scene=scene)
        assert error.value.segment == 1
        assert error.value.share == pytest.approx(0.4, abs=1e-3)
        assert error.value.theta == pytest.approx([0.2, 0.0], abs=2e-3)


def test_a_joint_move_to_a_target_ends_in_a_free_configuration(tmp_path: Path) -> None:
    """Two links of 1 m reach √2 m forward with the elbow to the right, the nearer one, where a stone lies, or left."""
    links = link("base"), link("upper", SHAPES["sphere"], "1 0 0"), link("fore"), link("hand", SHAPES["sphere"])
    shoulder = joint("shoulder", "revolute", "base", "upper", "0 0 1")
    elbow = joint("elbow", "revolute", "upper", "fore", "0 0 1", "1 0 0")
    wrist = joint("wrist", "fixed", "fore", "hand", "1 0 0", "1 0 0")
    arm = robot(tmp_path / "two.urdf", "hand", *links, shoulder, elbow, wrist)
    scene, move = Scene(arm), JointMove(Position([np.sqrt(2.0), 0.0, 0.0]))
    scene.add_box("stone", (0.05, 0.05, 0.05), (np.sqrt(0.5), -np.sqrt(0.5), 0.0))
    for given, turned in ((None, -1.0), (scene, 1.0)):
        end = plan(arm, move, start=[-0.6, 1.5], scene=given).waypoints[-1]
        assert end == pytest.approx([turned * np.pi / 4.0, -turned * np.pi / 2.0], abs=1e-4)
    scene.add_box("other stone", (0.05, 0.05, 0.05), (np.sqrt(0.5), np.sqrt(0.5), 0.0))
    with pytest.raises(PathError, match="it collides .* upper and stone"):
        plan(arm, move, start=[-0.6, 1.5], scene=scene)


def test_a_start_in_collision_may_be_left_but_not_deeper(tmp_path: Path) -> None:
    """The hand, a sphere of radius 0.1, overlaps the wall's face at x = 0.1 by 0.05; the wall's middle is at 0."""
    arm, scene = at_a_wall(tmp_path, margin=0.01)
    for away in (FreeMove([1.0, 0.0]), JointMove([0.3, 0.5])):
        assert plan(arm, away, start=[0.15, 0.0], scene=scene).waypoints[-1, 0] == pytest.approx(away.to[0])
    with pytest.raises(PathError, match="it collides"):
        plan(arm, JointMove([-1.0, 0.0]), start=[0.15, 0.0], scene=scene)
    with pytest.raises(PathError, match="ends in collision"):
        plan(arm, JointMove([0.16, 0.0]), start=[0.15, 0.0], scene=scene)


def test_a_link_that_leaves_may_not_bring_in_another_of_its_bodies(tmp_path: Path) -> None:
    """The hand's lower sphere leaves the face of the wall by 0.07 while the upper one sinks 0.01 into its edge."""
    sphere = SHAPES["sphere"]
    two = f'{sphere}</geometry></collision><collision><origin xyz="0 0 0.5"/><geometry>{sphere}'
    arm, scene = at_a_wall(tmp_path, two)
    with pytest.raises(PathError, match="it collides"):
        plan(arm, JointMove([0.22, 0.2]), start=[0.15, 0.7], scene=scene)


def test_a_motion_through_waypoints_is_proven(tmp_path: Path) -> None:
    """The spline through x = 1, 0, −1 at z = 1.5, 1.6, 1.5 passes over the wall, whose top is at z = 1; at 0.9 not."""
    arm, scene = at_a_wall(tmp_path)
    plan_joint(arm, [[1.0, 1.5], [0.0, 1.6], [-1.0, 1.5]], scene=scene)
    with pytest.raises(PathError, match="waypoint 0 to 1"):
        plan_joint(arm, [[1.0, 1.5], [0.0, 0.9], [-1.0, 1.5]], scene=scene)


def test_assert_free_names_time_and_pair(tmp_path: Path) -> None:
    """The hand, of radius 0.1, comes from x = 1 to the face of the wall at 0.1 after 0.8 of 1 m."""
    arm = slider(tmp_path, SHAPES["sphere"])
    (tmp_path / "scene.toml").write_text('[[box]]\nname = "wall"\nsize = [0.2, 2, 4]\nxyz = [0, 0, -1]', "utf-8")
    for x, free in ((0.3, True), (0.15, False)):
        motion = plan_joint(arm, [[1.0, 0.0], [x, 0.0]])
        save_trajectory(motion, tmp_path / "motion.csv")
        for given in (motion, tmp_path / "motion.csv"):
            assert_free(arm, given)
            if free:
                assert_free(arm, given, tmp_path / "scene.toml")
            else:
                with pytest.raises(AssertionError, match=r"slider: it collides .* hand and wall"):
                    assert_free(arm, given, tmp_path / "scene.toml")
    with pytest.raises(AssertionError, match="it collides 0.00 s after the start"):
        assert_free(arm, plan_joint(arm, [[0.15, 0.0]]), tmp_path / "scene.toml")


def test_unwrap_chooses_the_goal_of_a_free_move_by_whole_turns() -> None:
    """3.0 beyond −3.0 is nearer by 0.28 rad than 6.0."""
    arm = load_arm("ur5")
    goal = np.array([-3.0, -1.5, 0.5, -1.5, 0.5, 0.0])
    start = goal + [6.0, 0, 0, 0, 0, 0]
    scene = Scene(arm)
    motion = plan(arm, FreeMove(goal), start=start, scene=scene, unwrap=True)
    assert motion.waypoints[-1, 0] == pytest.approx(-3.0 + 2.0 * np.pi)
    pytest.importorskip("ompl")
    middle = arm.fk(goal * [0, 1, 1, 1, 1, 1])[:3, 3]
    scene.add_box("post", (0.1, 0.1, 0.1), middle)
    with pytest.raises(PathError, match="unwrap=True"):
        plan(arm, FreeMove(goal), start=start, scene=scene, max_time=1e-6)


def test_a_straight_free_move_of_one_joint_is_as_short_as_a_joint_move(tmp_path: Path) -> None:
    arm = slider(tmp_path, SHAPES["sphere"])
    free, joint = (plan(arm, move([1.0, 0.0]), start=[-1.0, 0.0], scene=Scene(arm)) for move in (FreeMove, JointMove))
    assert free.duration == pytest.approx(joint.duration)


def test_a_free_move_without_a_way_ends_in_time(tmp_path: Path) -> None:
    pytest.importorskip("ompl")
    arm = slider(tmp_path, SHAPES["sphere"])
    scene = Scene(arm)
    scene.add_box("wall", (0.2, 2.0, 9.0))  # higher than the slide can go
    with pytest.raises(PathError, match="no free path was found in 0.5 s"):
        plan(arm, FreeMove([1.0, 0.0]), start=[-1.0, 0.0], scene=scene, max_time=0.5)
    with pytest.raises(InputError, match="scene="):
        plan(arm, FreeMove([1.0, 0.0]), start=[-1.0, 0.0])


def test_a_free_move_to_a_target_goes_to_any_configuration_that_meets_it(tmp_path: Path) -> None:
    """A post stands at 1 rad between the start at 0 and the goal at 2 rad. At 2 − 2π rad the hand is there too."""
    pytest.importorskip("ompl")
    links = link("base"), link("bar"), link("hand", SHAPES["sphere"])
    turn = joint("turn", "revolute", "base", "bar", "0 0 1", limit=6.0)
    arm = robot(tmp_path / "swing.urdf", "hand", *links, turn, joint("end", "fixed", "bar", "hand", "1 0 0", "1 0 0"))
    scene, move = Scene(arm), FreeMove(Position([np.cos(2.0), np.sin(2.0), 0.0]))
    scene.add_box("post", (0.1, 0.1, 0.1), (np.cos(1.0), np.sin(1.0), 0.0))
    motion = plan(arm, move, start=[0.0], scene=scene)
    assert motion.waypoints[-1] == pytest.approx([2.0 - 2.0 * np.pi])
    assert motion(np.linspace(0.0, motion.duration, 1000)).max() < 0.9  # the hand's radius is 0.1
    scene.add_box("other post", (0.1, 0.1, 0.1), (np.cos(1.0), -np.sin(1.0), 0.0))
    with pytest.raises(PathError, match="no free path to any configuration of the target was found in 0.2 s"):
        plan(arm, move, start=[0.0], scene=scene, max_time=0.2)


def test_a_goal_near_something_takes_no_clearance_from_the_way(tmp_path: Path) -> None:
    """Over a wall, to a goal 2 mm above a block: at the wall states still keep 30 mm."""
    pytest.importorskip("ompl")
    arm = slider(tmp_path, SHAPES["sphere"])
    scene = Scene(arm)
    scene.add_box("wall", (0.2, 2.0, 1.0))
    scene.add_box("block", (0.1, 2.0, 0.1), (0.8, 0.0, -0.152))
    motion = plan(arm, FreeMove([0.8, 0.0]), start=[-0.8, 0.0], scene=scene, max_time=60.0, clearance=0.03)
    way = motion(np.linspace(0.0, motion.duration, 1000))
    at_wall = [scene.distance(theta).metres for theta in way if abs(theta[0]) < 0.3]
    assert min(at_wall) > 0.015  # a straight way between two states 0.1 apart loses 10 mm at a corner


def test_a_free_move_takes_a_gap_narrower_than_its_clearance(tmp_path: Path) -> None:
    """A sphere of radius 0.1 between two blocks, with 3 mm at each side."""
    pytest.importorskip("ompl")
    arm = slider(tmp_path, SHAPES["sphere"])
    scene = Scene(arm)
    for side in (1.0, -1.0):
        scene.add_box(f"block {side}", (0.2, 2.0, 2.4), (0.0, 0.0, side * 1.303))
    motion = plan(arm, FreeMove([0.6, -0.3]), start=[-0.6, 0.5], scene=scene, max_time=60.0, clearance=0.005)
    way = motion(np.linspace(0.0, motion.duration, 3000))
    assert not scene.collides(way).any()
    assert "comes nearer than clearance=0.005: hand and block" in motion.notes[-1]
    with pytest.raises(InputError, match="clearance"):
        plan(arm, FreeMove([0.6, -0.3]), scene=scene, clearance=-1.0)


def test_a_path_whose_states_lie_on_both_sides_of_a_wall_is_not_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A first path with states 3 m apart goes through the wall."""
    pytest.importorskip("ompl")
    arm, seen = slider(tmp_path, SHAPES["sphere"]), list[float]()
    monkeypatch.setattr(free_moves, "STEPS", (3.0, 0.02))
    scene = Scene(arm)
    scene.add_box("wall", (0.1, 2.0, 1.0))
    moves = [FreeMove([0.6, 0.0]), FreeMove([-0.6, 0.0])]
    motion = plan(arm, moves, start=[-0.6, 0.0], scene=scene, max_time=60.0, progress=seen.append)
    assert seen == pytest.approx([0.25, 0.5, 1.0])
    assert not scene.collides(motion(np.linspace(0.0, motion.duration, 3000))).any()


@pytest.mark.parametrize("beyond", [1e-12, 2.65e-6])
def test_a_free_move_begins_beyond_a_limit_by_rounding(tmp_path: Path, beyond: float) -> None:
    pytest.importorskip("ompl")
    arm = slider(tmp_path, SHAPES["sphere"])
    scene = Scene(arm)
    scene.add_box("wall", (0.2, 2.0, 2.0))
    motion = plan(arm, FreeMove([1.0, 0.0]), start=[-2.0 - beyond, 0.0], scene=scene)
    assert not scene.collides(motion(np.linspace(0.0, motion.duration, 1000))).any()
