"""`plan`: the tool on its curves, limits everywhere, corners, labels, and refusals that say how far it gets."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.spatial import cKDTree

from test_hard_motions import arm_of, judge
from twistarm import (
    Approach,
    ArcMove,
    Dwell,
    JointMove,
    LineMove,
    PathError,
    Pose,
    Position,
    ScrewMove,
    Trajectory,
    active_limits,
    arm_from_dh,
    load_arm,
    plan,
    rotations,
    screws,
)
from twistarm.planning.curves import MovingTarget, line
from twistarm.planning.following import Blocked, Node
from twistarm.planning.refusal import refusal
from twistarm.support.errors import InputError, LimitError, NotConvergedError, UnknownNameError

RATES = {"velocity": 1.2, "acceleration": 3.0, "jerk": 40.0}
KINDS = ("s_curve", "time_optimal", "quintic")
ARM = load_arm("rover_arm_6dof", limits=RATES)
G = ARM.fk(ARM.ready)


def moved(offset: list[float], turn: list[float] | None = None) -> Pose:
    g = G.copy()
    g[:3, 3] += offset
    if turn is not None:
        g[:3, :3] = rotations.exp(turn) @ g[:3, :3]
    return Pose(g)


def dense(motion: Trajectory, times: int = 20) -> np.ndarray:
    """Instants at `times` as many places as the motion has breakpoints, those included."""
    steps = np.diff(motion.breakpoints)[:, None]
    return np.unique((motion.breakpoints[:-1, None] + steps * np.linspace(0.0, 1.0, times)).ravel())


def beside(g: np.ndarray, start: np.ndarray, goal: np.ndarray) -> np.ndarray:
    """How far along the line from start to goal the tool is, nowhere farther than 0.1 mm from it."""
    offset, way = g[:, :3, 3] - start[:3, 3], goal - start[:3, 3]
    s = (offset @ way) / (way @ way)
    assert np.abs(offset - s[:, None] * way).max() <= 1e-4
    return s


@pytest.mark.parametrize("kind", KINDS)
def test_a_tour_keeps_every_limit_and_ends_at_rest(kind):
    tour = [
        JointMove(moved([0.0, 0.05, 0.0])),
        LineMove(moved([0.0, -0.05, 0.05]), blend=0.01),
        LineMove(moved([0.05, 0.0, 0.0], [0.0, 0.0, 0.2]), linear_speed=0.1, label="close gripper"),
        Dwell(0.25, label="wait"),
        ScrewMove.about([0, 0, 1], G[:3, 3], 0.3, 0.05),
        JointMove({ARM.joint_names[0]: 0.0}, velocity_scaling=0.5),
        JointMove("ready"),
    ]
    motion = plan(ARM, tour, kind=kind)
    judge(motion, ARM.limits, jerk=kind == "s_curve")
    np.testing.assert_allclose(motion(motion.duration), ARM.ready)
    assert np.abs(motion([0.0, motion.duration], 1)).max() == 0.0
    assert [label for _, label in motion.labels] == ["close gripper", "wait"]
    assert motion.labels[0][0] == pytest.approx(motion.times[3])
    assert motion.times[4] - motion.times[3] == pytest.approx(0.25)
    t = np.linspace(motion.times[2], motion.times[3], 400)
    v = (ARM.body_jacobian(motion(t)) @ motion(t, 1)[..., None])[:, :3, 0]
    assert np.linalg.norm(v, axis=1).max() <= 0.1
    assert np.abs(motion(dense(motion), 1)[:, 0] / ARM.limits.velocity[0]).max() <= 1.0


def test_usual_limits_stand_in_for_missing_ones_and_are_named():
    free, move = load_arm("rover_arm", limits={"acceleration": np.inf}), LineMove.by([0.0, 0.0, 0.05])
    usual = {"acceleration": [{"m": 1.0, "rad": 3.0}[unit] for unit in free.units]}
    motion, explicit = plan(free, move), plan(free, move, limits=usual)
    assert motion.duration == explicit.duration
    assert explicit.notes == ()
    assert "acceleration 3 rad/s²" in motion.notes[0]
    assert active_limits(free, motion) == active_limits(free, motion, limits=usual)


def test_a_line_is_straight_and_turns_in_proportion():
    goal = moved([0.1, -0.08, 0.05], [0.2, -0.3, 0.1])
    motion = plan(ARM, LineMove(goal))
    g = ARM.fk(motion(dense(motion)))
    s = beside(g, G, goal.g[:3, 3])
    slerp = rotations.exp(s[:, None] * np.array([0.2, -0.3, 0.1])) @ G[:3, :3]
    assert np.degrees(rotations.angle_between(slerp, g[:, :3, :3])).max() <= 0.05
    np.testing.assert_allclose(g[-1], goal.g, atol=1e-6)


def test_arcs_and_screws_keep_to_their_axis():
    axis, centre = np.array([1.0, 0.0, 0.0]), G[:3, 3] - [0.0, 0.0, 0.1]
    for move, turned in (
        (ArcMove.about(axis, centre, 0.5), 0.5),
        (ArcMove.about(axis, centre, 0.5, turn=False), 0.0),
        (ScrewMove.about(axis, centre, 0.5, pitch=0.04), 0.5),
    ):
        motion = plan(ARM, move, kind="time_optimal")
        g = ARM.fk(motion(dense(motion)))
        radius = np.linalg.norm(np.cross(g[:, :3, 3] - centre, axis), axis=1)
        np.testing.assert_allclose(radius, 0.1, atol=1e-4)
        along = (g[:, :3, 3] - G[:3, 3]) @ axis
        pitch = 0.04 if isinstance(move, ScrewMove) else 0.0
        assert along[-1] == pytest.approx(0.5 * pitch, abs=1e-4)
        assert rotations.angle_between(G[:3, :3], g[-1, :3, :3]) == pytest.approx(turned, abs=1e-3)


def test_segments_that_go_nowhere_are_told_and_the_motion_goes_on():
    there, on = moved([0.0, 0.05, 0.0]), moved([0.0, 0.05, 0.05])
    here, way = LineMove(moved([0, 0, 0])), [LineMove(there), LineMove(on)]
    twice = [here, LineMove(there, blend=0.01), LineMove(there, blend=0.01), LineMove(on), LineMove(on)]
    motion = plan(ARM, twice)
    assert motion.duration == pytest.approx(plan(ARM, way).duration)
    assert [note.split(":")[0] for note in motion.notes] == [f"segment {i} (LineMove)" for i in (1, 3, 5)]
    np.testing.assert_allclose(ARM.fk(motion(motion.duration)), on.g, atol=1e-6)
    assert plan(ARM, [LineMove(moved([0, 0, 0])), JointMove(there), LineMove(there)]).duration > 0.0
    assert plan(ARM, LineMove(moved([0, 0, 0]))).duration == 0.0


@pytest.mark.parametrize("off", [0.0, 1e-5])
def test_no_arc_is_planned_whose_plane_rounding_chooses(off):
    start, end = G[:3, 3], moved([0.0, 0.1, 0.0])
    near = moved([off, 0.0, 0.0])
    for arc in (
        ArcMove(start + [off, 0.0, 0.0], end),
        ArcMove(end.g[:3, 3] + [0.0, 0.0, off], end),
        ArcMove(start + [0.0, 0.05, off], end),
        ArcMove(start + [0.0, 0.05, 0.05], near),
    ):
        with pytest.raises(InputError, match="do not lie on a line"):
            plan(ARM, arc)


def test_a_circle_may_be_given_twice_and_a_gentle_arc_is_one():
    """A circle of two arcs through points 5 cm from its centre, and an arc of 1 mm on 10 cm."""
    way = [
        ArcMove(G[:3, 3] + [0, 0.05, 0.05], moved([0, 0.1, 0])),
        ArcMove(G[:3, 3] + [0, 0.05, -0.05], moved([0, 0, 0])),
    ]
    motion = plan(ARM, way * 2)
    p = ARM.fk(motion(dense(motion)))[:, :3, 3]
    np.testing.assert_allclose(np.linalg.norm(p - (G[:3, 3] + [0, 0.05, 0]), axis=1), 0.05, atol=1e-4)
    assert motion.times[2] == pytest.approx(0.5 * motion.duration, rel=1e-3)
    gentle = plan(ARM, ArcMove(G[:3, 3] + [0, 0.05, 1e-3], moved([0, 0.1, 0])))
    assert np.abs(ARM.fk(gentle(dense(gentle)))[:, 2, 3] - G[2, 3]).max() == pytest.approx(1e-3, abs=1e-4)


def test_a_blend_stays_in_its_ball_and_does_not_stop():
    corner = moved([0.0, 0.0, 0.08])
    end = moved([0.0, 0.08, 0.08])
    stops = plan(ARM, [LineMove(corner), LineMove(end)])
    motion = plan(ARM, [LineMove(corner, blend=0.02), LineMove(end)])
    assert motion.duration < stops.duration
    t = dense(motion)
    p = ARM.fk(motion(t))[:, :3, 3]
    off = np.minimum(
        np.linalg.norm((p - G[:3, 3])[:, :2], axis=1), np.linalg.norm((p - corner.g[:3, 3])[:, [0, 2]], axis=1)
    )
    inside = np.linalg.norm(p - corner.g[:3, 3], axis=1) <= 0.02 + 1e-9
    assert off[~inside].max() <= 1e-4
    v = np.linalg.norm(motion(t[(t > 0.05) & (t < motion.duration - 0.05)], 1), axis=1)
    assert v.min() > 0.0
    jumps = motion(motion.breakpoints[1:-1], 2) - motion(motion.breakpoints[1:-1] - 1e-9, 2)
    assert np.abs(jumps).max() <= 1e-4 * ARM.limits.acceleration.max()


@pytest.mark.parametrize("name", ["rover_arm", "rover_arm_6dof", "elbow", "scara", "stanford"])
def test_a_blend_of_any_size_plans_where_a_stop_does(name):
    """Through random poses, of which one only turns the tool. The way leaves that of the stopping motion near poses."""
    arm, rng = load_arm(name, limits=RATES), np.random.default_rng(7)
    for kinds in ((ScrewMove, JointMove, LineMove, JointMove), (JointMove, JointMove, JointMove, ScrewMove)):
        way = [arm.ready]
        for turn in (False, True, False, False):
            theta = arm.ready + 0.15 * (arm.random_theta(rng) - arm.ready)
            way.append(np.append(way[-1][:-1], theta[-1]) if turn else theta)

        def motion(blend, way=way, kinds=kinds):
            blends = [blend, blend, blend, 0.0]
            moves = [make(theta, blend=b) for make, theta, b in zip(kinds, way[1:], blends, strict=True)]
            return plan(arm, moves, start=way[0])

        stops = motion(0.0)
        ideal = cKDTree(arm.fk(stops(np.linspace(0.0, stops.duration, 2000)))[:, :3, 3])
        poses = cKDTree(arm.fk(way)[:, :3, 3])
        for blend in (1e-3, 0.02, 1.0):
            rounded = motion(blend)
            judge(rounded, arm.limits, jerk=True)
            assert rounded.duration <= stops.duration * (1 + 1e-9)
            p = arm.fk(rounded(np.linspace(0.0, rounded.duration, 5000)))[:, :3, 3]
            off, near = ideal.query(p)[0], poses.query(p)[0]
            assert off[near > blend].max(initial=0.0) <= 2e-3  # the ideal has 2000 points


def test_a_motion_says_at_which_corners_it_stops_though_they_were_to_be_rounded():
    """By its own velocity there, and only where one was asked for. To round one of them alone is no faster."""
    kinds = (JointMove, JointMove, JointMove, LineMove, JointMove)
    goals = ARM.ready + 0.2 * np.random.default_rng(2).uniform(-1.0, 1.0, (5, ARM.n))
    for blend in (0.01, 0.1):
        motion = plan(
            ARM, [make(q, blend=blend * (i < 4)) for i, (make, q) in enumerate(zip(kinds, goals, strict=True))]
        )
        rests = np.flatnonzero(np.abs(motion(motion.times[1:-1], 1)).max(axis=1) < 1e-9) + 1
        stops = [note for note in motion.notes if note.startswith("stops at")]
        assert len(stops) == bool(len(rests))
        if len(rests) not in (0, 4):
            assert [int(number) for number in re.findall(r"segment (\d+)", stops[0])] == rests.tolist()
        elif stops:
            assert "every corner" in stops[0]
        for only in rests:
            others = {*range(1, 5)} - {*rests.tolist()} | {int(only)}
            moves = [
                make(q, blend=blend * (i in others)) for i, (make, q) in enumerate(zip(kinds, goals, strict=True), 1)
            ]
            assert plan(ARM, moves).duration >= motion.duration * (1 - 1e-9)
    assert not plan(ARM, [JointMove(q) for q in goals]).notes


def test_what_a_target_leaves_free_an_arm_of_five_joints_uses():
    arm = load_arm("rover_arm", limits=RATES)
    g = arm.fk(arm.ready)
    goal = g[:3, 3] + [0.1, 0.05, -0.05]
    for target in (Position(goal), Approach(goal, g[:3, :3] @ arm.tool_axis)):
        motion = plan(arm, LineMove(target))
        h = arm.fk(motion(dense(motion)))
        beside(h, g, goal)
        if isinstance(target, Approach):
            axis = h[:, :3, :3] @ arm.tool_axis
            assert np.degrees(np.linalg.norm(axis - target.direction, axis=1)).max() <= 0.05


def test_an_arm_of_five_joints_keeps_as_much_of_a_pose_as_it_can():
    arm = load_arm("rover_arm", limits=RATES)
    to = {arm.joint_names[0]: 0.1, "elbow": float(arm.ready[2]) + 0.2}
    for move in (LineMove(to), LineMove.by([0.0, 0.0, 0.05])):
        motion = plan(arm, move, kind="time_optimal")
        end = arm.fk({**arm.theta_to_dict(arm.ready), **to} if move.to is not None else arm.ready)[:3, 3]
        start = arm.fk(arm.ready)
        goal = end if move.to is not None else end + 0.05 * start[:3, 2]
        s = beside(arm.fk(motion(dense(motion))), start, goal)
        assert s[-1] == pytest.approx(1.0, abs=1e-4)


def test_a_joint_move_to_a_target_ends_in_the_nearest_configuration():
    """By hand: θ and, with the elbow to the other side, θ₁ turned by twice the angle to the hand, and −θ₂."""
    arm = arm_from_dh([[0.4, 0, 0, 0], [0.3, 0, 0, 0]], "standard")
    for theta, start in zip(arm.random_theta(0, 20), arm.random_theta(1, 20), strict=True):
        beyond = np.arctan2(0.3 * np.sin(theta[1]), 0.4 + 0.3 * np.cos(theta[1]))
        both = np.array([theta, [theta[0] + 2.0 * beyond, -theta[1]]])
        away = np.linalg.norm((both - start + np.pi) % (2.0 * np.pi) - np.pi, axis=1)
        motion = plan(arm, JointMove(Position(arm.fk(theta)[:3, 3])), start=start, limits=RATES)
        assert np.linalg.norm(motion.waypoints[-1] - start) == pytest.approx(away.min(), abs=1e-4)


def test_the_branch_is_chosen_for_the_whole_run():
    """From the nearest configuration at the first pose the line ends at a limit; another one follows all of it."""
    arm = load_arm("ur5", limits={"acceleration": 3.0})
    rng = np.random.default_rng(1)
    chosen = 0
    for _ in range(6):
        theta = arm.random_theta(rng)
        g = arm.fk(theta)
        g1 = g.copy()
        g1[:3, 3] *= 0.9
        try:
            motion = plan(arm, [JointMove(Pose(g)), LineMove(Pose(g1))], kind="time_optimal")
        except PathError:
            continue
        chosen += 1
        judge(motion, arm.limits, jerk=False)
        np.testing.assert_allclose(arm.fk(motion.waypoints[1]), g, atol=1e-6)
        np.testing.assert_allclose(arm.fk(motion.waypoints[2]), g1, atol=1e-6)
    assert chosen >= 3


def test_a_joint_that_the_target_leaves_free_stays():
    """The turn about the tool's axis is free, and costs no time while another joint takes longer: it stays."""
    arm = load_arm("rover_arm", limits=RATES)
    motion = plan(arm, [JointMove(Approach([0.9, 0.1, 0.6], [1.0, 0.0, 0.0])), LineMove.by([0.0, 0.0, 0.05])])
    np.testing.assert_allclose(motion.waypoints[:, 4], arm.ready[4], atol=1e-6)


def test_a_turn_in_place_is_followed_or_refused_but_never_left_out():
    """What arms of fewer than six joints may leave out of a pose is never all of the move."""
    arm = load_arm("rover_arm", limits=RATES | {"lower": {"wrist_roll": -2.0}, "upper": {"wrist_roll": 2.0}})
    g = arm.fk(arm.ready)
    roll, p = g[:3, :3] @ arm.tool_axis, g[:3, 3]
    turned = arm.fk(plan(arm, ScrewMove.about(roll, p, 1.5)).waypoints[-1])
    np.testing.assert_allclose(turned[:3, :3], rotations.from_axis_angle(roll, 1.5) @ g[:3, :3], atol=1e-6)
    with pytest.raises(PathError, match="'wrist_roll' comes to its upper limit 2 rad; .* certain") as error:
        plan(arm, ScrewMove.about(roll, p, 2.5))
    assert error.value.share == pytest.approx(2.0 / 2.5, abs=1e-3)
    with pytest.raises(PathError, match="0 rad of 0.5 rad .0 %. and no farther: this arm cannot turn that way"):
        plan(arm, ScrewMove.about([0.0, 0.0, 1.0], p, 0.5))


def test_what_lies_beyond_the_end_of_a_path_says_why_it_ends():
    """The tool of a stretched arm is out of reach a little farther on: no leap would help."""
    arm = load_arm("rr_planar", limits=RATES)
    start = arm.fk([0.0, 0.4])[:3, 3]
    with pytest.raises(PathError) as error:
        plan(arm, LineMove(Position(3.0 * start)), start=[0.0, 0.4])
    assert error.value.reason == "out of reach"
    reach = np.linalg.norm(arm.fk([0.0, 0.0])[:3, 3])
    assert error.value.share == pytest.approx((reach / np.linalg.norm(start) - 1.0) / 2.0, abs=1e-3)


def test_a_leap_has_a_reason_of_its_own():
    """No joint is at a limit, and the configuration is far from singular: neither of them is the reason."""
    arm = load_arm("ur5", limits={"acceleration": 3.0})
    g = arm.fk(arm.ready)
    moving = MovingTarget(line(g, g @ screws.exp([0.0, 0.0, 0.1, 0.0, 0.0, 0.0])), Pose(g))
    error = refusal(arm, arm.limits, Blocked(Node(moving, 0.0, arm.ready, 0.0), 0.1, leap=True), 0, "", others=False)
    assert (error.reason, error.joint) == ("leap", None)
    assert "leap to another configuration" in str(error)


@pytest.mark.parametrize(
    ("segments", "options", "error", "words"),
    [
        ([], {}, InputError, "one or more of JointMove"),
        ([JointMove(np.zeros(6)), 3], {}, InputError, "segment 2 must be"),
        ([LineMove(moved([0.0, 0.0, 0.01]), blend=0.2)], {}, InputError, "segment 1 .*cannot blend"),
        ([JointMove(np.full(6, 50.0))], {}, LimitError, "segment 1 .JointMove. puts joint"),
        ([JointMove(Position([9.0, 0.0, 0.0]))], {}, NotConvergedError, "segment 1 .JointMove."),
        ([JointMove("ready"), JointMove("redy")], {}, UnknownNameError, "^segment 2 .JointMove.: no conf.* 'redy'"),
        ([JointMove({"elbw": 1.0})], {}, UnknownNameError, "^segment 1 .JointMove.: no joint 'elbw'"),
        ([JointMove([1.0, 2.0])], {}, InputError, "^segment 1 .JointMove.: its goal must have shape"),
        ([JointMove("ready")], {"kind": "fast"}, InputError, "kind must be"),
        ([JointMove("ready")], {"linear_speed": -1.0}, InputError, "linear_speed"),
    ],
)
def test_what_cannot_be_planned_is_refused(segments, options, error, words):
    with pytest.raises(error, match=words):
        plan(ARM, segments, **options)


def test_segments_refuse_what_makes_no_sense():
    for make, words in (
        (lambda: LineMove(moved([0, 0, 0.1]), orientation_tol=3), "172°"),
        (lambda: LineMove(moved([0, 0, 0.1]), velocity_scaling=2.0), "share of the joints' velocity limits"),
        (lambda: LineMove(moved([0, 0, 0.1]), blend=-1.0), "blend"),
        (lambda: LineMove(moved([0, 0, 0.1]), label="a\nb"), "one line of text"),
        (lambda: ScrewMove.about([0, 0, 0], [0, 0, 0], 1.0), "zero vector"),
        (lambda: ScrewMove.about([0, 0, 1], [0, 0, 0], np.nan), "angle"),
        (lambda: Dwell(-1.0), "seconds"),
        *((lambda tol=tol: LineMove(G, position_tol=tol), "position_tol") for tol in (0.0, -1e-6, np.nan, "much")),
        (lambda: JointMove(None), "to must be a goal"),  # type: ignore[arg-type]
    ):
        with pytest.raises(InputError, match=words):
            make()


@pytest.mark.parametrize("radius", [0.002, 0.1])
@pytest.mark.parametrize("kind", KINDS)
def test_a_rounded_corner_never_takes_longer_than_stopping(kind, radius):
    limits = {"velocity": 1.0, "acceleration": 2.0, "jerk": 20.0}
    corners = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]

    def duration(blend):
        moves = [LineMove(Position(p), blend=blend * (i < 2)) for i, p in enumerate(corners)]
        return plan(arm_of("two"), moves, start=[0, 0], limits=limits, kind=kind).duration

    assert duration(radius) <= duration(0.0) * (1 + 1e-9)
    # From stop to stop of 1 m each at 1 m/s, 2 m/s² and 20 m/s³: 1/1 + 1/2 + 2/20 s (Biagiotti & Melchiorri §3.4).
    assert kind != "s_curve" or duration(0.0) == pytest.approx(3 * 1.6, rel=1e-6)
    assert radius < 0.1 or duration(radius) < 0.99 * duration(0.0) or kind == "quintic"
