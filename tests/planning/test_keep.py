"""Free moves that keep something: what is kept by Pinocchio, the bounds of the proof, and refusals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from joint_arms import KINDS, by_hand, random_chain
from twistarm import (
    Approach,
    Arm,
    FreeMove,
    InputError,
    JointMove,
    Keep,
    PathError,
    Position,
    Scene,
    Trajectory,
    load_arm,
    load_motion,
    plan,
    solve_ik,
)
from twistarm.planning.keep import Constraint, rates
from twistarm.theory import rotations

ARM = load_arm("ur5", limits={"acceleration": 3.0})
DOWN, TOL = np.array([0.0, 0.0, -1.0]), 0.03


def hanging(p: list[float]) -> Approach:
    return Approach(p, DOWN)


START = solve_ik(ARM, hanging([0.5, -0.3, 0.4])).require()
GOAL = hanging([0.5, 0.3, 0.4])


def beside_a_post() -> Scene:
    scene = Scene(ARM)
    scene.add_cylinder("post", 0.04, 1.2, (0.5, 0.0, 0.3))
    return scene


def poses(arm: Arm, motion: Trajectory, samples: int = 10_001) -> np.ndarray:
    """The tool's poses on the way, by Pinocchio."""
    return arm.by_pinocchio(motion(np.linspace(0.0, motion.duration, samples)))[0]


def angles(g: np.ndarray, axis: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Between R @ axis and the direction."""
    return np.arccos(np.clip(g[:, :3, :3] @ axis @ direction, -1.0, 1.0))


@pytest.mark.parametrize(("kind", "tol"), [("s_curve", TOL), ("time_optimal", 0.2 * TOL), ("quintic", 0.1 * TOL)])
def test_a_hanging_tool_stays_so_round_a_post(kind: str, tol: float) -> None:
    scene = beside_a_post()
    straight = plan(ARM, JointMove(GOAL), start=START)
    assert scene.first_collision(straight) is not None
    motion = plan(ARM, FreeMove(GOAL, keep=Keep(direction=DOWN, tol=tol)), start=START, scene=scene, kind=kind)
    g = poses(ARM, motion)
    assert angles(g, np.array([0.0, 0.0, 1.0]), DOWN).max() <= tol + 1e-8
    assert np.allclose(g[-1, :3, 3], GOAL.p, atol=1e-4)
    assert not scene.collides(motion(np.linspace(0.0, motion.duration, 2001))).any()
    assert (motion.peak(1) <= ARM.limits.velocity * (1 + 1e-6)).all()
    assert (motion.peak(2) <= ARM.limits.acceleration * (1 + 1e-6)).all()


def test_several_parts_are_kept_at_once() -> None:
    scene, R = beside_a_post(), ARM.fk(START)[:3, :3]
    box = [[-np.inf, -0.5, 0.35], [0.6, 0.5, np.inf]]
    parts = {"box": box, "plane": [[0.0, 0.0, 0.4], [0.0, 0.0, 2.0]], "position_tol": 0.005}
    R, leaning = rotations.exp([-0.55 * TOL, 0.0, 0.0]) @ R, rotations.exp([0.55 * TOL, 0.0, 0.0]) @ DOWN
    keep = Keep(orientation=R, direction=leaning, tol=TOL, **parts)  # 1.1 tol from each other
    motion = plan(ARM, FreeMove(Position(GOAL.p), keep=keep), start=START, scene=scene)
    g = poses(ARM, motion)
    trace = np.einsum("ij,mij->m", R, g[:, :3, :3])
    assert np.arccos(np.clip(0.5 * (trace - 1.0), -1.0, 1.0)).max() <= TOL + 1e-8
    assert angles(g, np.array([0.0, 0.0, 1.0]), leaning).max() <= TOL + 1e-8
    assert (np.abs(g[:, 2, 3] - 0.4) <= 0.005 + 1e-8).all()
    assert (g[:, :3, 3] >= np.array(box)[0] - 1e-8).all()
    assert (g[:, :3, 3] <= np.array(box)[1] + 1e-8).all()


def test_a_rounded_corner_after_it_keeps_too() -> None:
    """The move after it tips the tool at once: the corner is rounded only if that keeps."""
    keep, tip = Keep.level(TOL), JointMove({"wrist_1_joint": 1.0, "shoulder_lift_joint": -1.2})
    moves = [FreeMove(START, keep=keep), FreeMove(GOAL, keep=keep, blend=0.1), tip]  # the first stays
    motion = plan(ARM, moves, start=START, scene=beside_a_post())
    g = ARM.by_pinocchio(motion(np.linspace(0.0, motion.times[2], 5001)))[0]
    up = ARM.fk(START)[:3, :3].T @ [0.0, 0.0, 1.0]
    assert angles(g, up, np.array([0.0, 0.0, 1.0])).max() <= TOL + 1e-8


def test_an_arm_of_five_joints_keeps_what_it_can_and_says_so() -> None:
    arm = load_arm("rover_arm", limits={"acceleration": 3.0})
    scene, start, axis = Scene(arm), arm.ready, arm.tool_axis
    rolled = start + [0.3, 0.0, 0.0, 0.0, 0.7]  # beside it, and the tool rolls about its axis
    motion = plan(arm, FreeMove(rolled, keep=Keep(orientation=True, tol=TOL)), start=start, scene=scene)
    (note,) = (note for note in motion.notes if "5 joints" in note)
    assert "segment 1" in note
    assert angles(poses(arm, motion), axis, arm.fk(start)[:3, :3] @ axis).max() <= TOL + 1e-8
    with pytest.raises(PathError, match=r"goal.*0\.7 rad off"):
        plan(arm, FreeMove(rolled, keep=Keep.level(TOL)), start=start, scene=scene)


def test_the_bounds_of_speeds_hold_for_all_joint_types() -> None:
    """Bounds of |ω| and |v| of the tool by each coordinate, against a Jacobian anywhere."""
    rng = np.random.default_rng(3)
    for seed in range(20):
        arm = by_hand(*random_chain(rng.permutation(KINDS), seed))
        theta = rng.uniform(-2.0, 2.0, (200, arm.n))
        angular, linear = rates(arm, np.full(arm.n, 2.0))
        J = arm.body_jacobian(theta)
        assert (np.linalg.norm(J[:, 3:], axis=1) <= angular + 1e-9).all()
        assert (np.linalg.norm(J[:, :3], axis=1) <= linear + 1e-9).all()


def test_a_proof_finds_what_samples_miss() -> None:
    """A motion beyond the tolerance for a thousandth of its time is not proven; a still one is."""
    constraint = Constraint(ARM, Keep(direction=True, tol=0.01).at(ARM, ARM.fk(START)))
    t = np.array([0.0, 0.4995, 0.5005, 1.0])
    bump = np.zeros((3, 3, 6))
    bump[-1] = START
    assert not constraint.unproven(bump, np.diff(t)).any()
    bump[0, 1, 3], bump[1, 1, 3] = -0.04 / 0.001**2, 0.04 / 0.001  # up to 0.01 rad halfway
    bump[:2, 1, 3] *= 1.1
    assert constraint.unproven(bump, np.diff(t)).tolist() == [False, True, False]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "what to keep"),
        ({"direction": [0.0, 0.0, 0.0]}, "direction"),
        ({"direction": DOWN, "tol": 0.0}, "tol"),
        ({"direction": DOWN, "tol": 5.0}, "286°"),
        ({"tool_axis": DOWN, "box": [[0, 0, 0], [1, 1, 1]]}, "tool_axis"),
        ({"direction": True, "tool_axis": True}, "direction or tool_axis"),
        ({"orientation": np.ones((3, 3))}, "orientation"),
        ({"box": [[0.0, 0.0, 0.5], [1.0, 1.0, 0.4]]}, "empty along z"),
        ({"plane": [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]}, "normal"),
    ],
)
def test_what_cannot_be_kept_is_refused(given: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        Keep(**given)  # type: ignore[arg-type]


def test_starts_and_goals_that_do_not_keep_are_refused_with_the_angle() -> None:
    scene, keep = beside_a_post(), Keep(direction=DOWN, tol=TOL)
    tipped, apart = START + np.eye(6)[3] * 0.5, rotations.exp([2.01 * TOL, 0.0, 0.0]) @ DOWN
    with pytest.raises(
        PathError, match=r"at its start the tool axis is 0\.5 rad off, and at most 0\.03 rad"
    ) as refused:
        plan(ARM, FreeMove(START, keep=keep), start=tipped, scene=scene)
    assert refused.value.segment == 0
    with pytest.raises(PathError, match=r"at its goal the tool axis is 0\.5 rad off"):
        plan(ARM, FreeMove(tipped, keep=keep), start=START, scene=scene)
    with pytest.raises(PathError, match="at its goal"):
        plan(ARM, FreeMove(Approach(GOAL.p, [1.0, 0.0, -1.0]), keep=keep), start=START, scene=scene)
    for contradictory, words in (
        (Keep(direction=apart, orientation=True, tol=TOL), r"the tool axis is 0\.0603 rad off, and at most 0\.03 rad"),
        (Keep(box=[[-1, -1, 0.6], [1, 1, np.inf]], plane=[[0, 0, 0.4], [0, 0, 1]]), r"the tool's origin is 0\.2 m out"),
    ):
        with pytest.raises(PathError, match=f"at its start {words}"):
            plan(ARM, FreeMove(Position([9.0, 9.0, 9.0]), keep=contradictory), start=START, scene=scene)
    with pytest.raises(InputError, match=r"Keep\.level"):
        FreeMove(START, keep="level")  # type: ignore[arg-type]


def test_a_file_has_what_is_kept(tmp_path: Path) -> None:
    file = tmp_path / "motion.toml"
    file.write_text(
        'degrees = true\n[[segment]]\nfree = "ready"\nkeep = { level = true, tol = 2.0 }\n'
        '[[segment]]\nfree = "ready"\nkeep = { rpy = [180.0, 0.0, 0.0], box = [[-inf, -1, 0], [inf, 1, 1]] }\n'
        '[[segment]]\nfree = "ready"\nkeep = { direction = true, position_tol = 1e-3, '
        "plane = [[0, 0, 0.4], [0, 0, 1]] }\n",
        "utf-8",
    )
    level, boxed, plane = (move.keep for move in load_motion(file, ARM).segments)  # type: ignore[attr-defined]
    assert level.tool_axis is True
    assert np.isclose(level.tol, np.radians(2.0))
    assert np.allclose(boxed.orientation, np.diag([1.0, -1.0, -1.0]))
    assert boxed.box[1, 0] == np.inf
    assert plane.direction is True
    assert plane.position_tol == 1e-3
    for wrong, words in (
        ('joint = "ready"\nkeep = {level = true}', "keep goes with free"),
        ('free = "ready"\nkeep = {level = true, direction = [0, 0, 1]}', "level = true"),
    ):
        file.write_text(f"[[segment]]\n{wrong}\n", "utf-8")
        with pytest.raises(InputError, match=words):
            load_motion(file, ARM)


def test_a_corner_rounded_before_it_keeps_too() -> None:
    """The free move before it keeps nothing, and its corner reaches into the next one."""
    keep = Keep(direction=DOWN, tol=TOL)
    moves = [FreeMove(START, blend=0.05), FreeMove(GOAL, keep=keep)]
    motion = plan(ARM, moves, start=ARM.ready, scene=beside_a_post())
    g = ARM.by_pinocchio(motion(np.linspace(motion.times[1], motion.duration, 5001)))[0]
    assert angles(g, np.array([0.0, 0.0, 1.0]), DOWN).max() <= TOL + 1e-8


def test_a_start_that_collides_is_named_where_no_way_is_found() -> None:
    scene = Scene(ARM)
    scene.add_box("wall", (2.0, 0.02, 4.0), (0.0, 0.05, 0.0))
    with pytest.raises(PathError, match=r"no path.*the start collides: .*wall.*away first"):
        plan(ARM, FreeMove(GOAL, keep=Keep(direction=DOWN, tol=TOL)), start=START, scene=scene, max_time=0.3)


def test_a_goal_that_no_configuration_reaches_exactly_is_taken_within_the_tolerance() -> None:
    six = load_arm("rover_arm_6dof", limits={"acceleration": 3.0})
    keep = Keep(direction=True, tol=np.radians(10.0))
    motion = plan(six, FreeMove(Position([0.9, 0.3, 0.5]), keep=keep), scene=Scene(six))
    off = angles(poses(six, motion), six.tool_axis, six.fk(six.ready)[:3, :3] @ six.tool_axis)
    assert off[-1] > 0.01
    assert off.max() < np.radians(10.0) + 1e-9
    assert np.allclose(poses(six, motion)[-1, :3, 3], [0.9, 0.3, 0.5], atol=2e-5)
