"""The servo at singularities: calm on the way in, free on the way out, and said."""

from itertools import pairwise

import numpy as np
import pytest

from catalogue import load
from servo_drives import DT, driven, pose
from twistarm import JointLimits, arm_from_screws, joints
from twistarm.control.servo import ServoReason, ServoSettings, ServoState, TwistCommand, servo_step

BENT = {
    "rr_planar": [0.3, 0.9],
    "scara": [0.3, 0.9, 0.2, 0.05],
    "rover_arm": [0.1, 0.7, -0.9, 0.4, 0.3],
    "so101": [0.3, -0.4, 0.9, -0.5, 0.4],
    "ur5": [0.3, -0.9, 1.2, 0.5, 1.3, 0.2],
}
"""Postures off any singularity."""

# What these arms have at no posture, by their geometry: along or about which of the base's axes.
LACKING = [("rr_planar", "move", 2), *((name, "turn", k) for name in ("rr_planar", "scara") for k in (0, 1))]


def pushed(name, theta, twist, frame="base"):
    """What the servo says of this twist after 0.4 s, from rest."""
    arm = load(name)
    state, output = ServoState.at(arm, theta), None
    for _ in range(40):
        state, output = servo_step(arm, state, TwistCommand(twist, frame), DT)
    return output


@pytest.mark.parametrize(("name", "half", "k"), LACKING)
def test_what_an_arm_has_at_no_posture_is_impossible_and_no_singularity(name, half, k):
    """Bent, and stretched, where it is singular too."""
    twist = 0.05 * np.eye(6)[k + 3 * (half == "turn")]
    held, done = (
        ("with the position held, ", "turns the tool about") if half == "turn" else ("", "moves the tool along")
    )
    for theta in (BENT[name], np.zeros(len(BENT[name]))):
        output = pushed(name, theta, twist)
        assert output.status == "IMPOSSIBLE_DIRECTION"
        assert output.lost_share == pytest.approx(1.0, abs=1e-3)
        assert output.explain() == f"this arm cannot {half} that way: {held}no joint {done} the base's {'xyz'[k]} axis"


@pytest.mark.parametrize("name", ["rover_arm", "so101"])
def test_five_joints_lack_the_third_turn_in_whatever_posture(name):
    """By Pinocchio's Jacobian: with the position held, the rotations are a plane, and its normal is what is missing."""
    g, _, J = load(name).by_pinocchio(BENT[name])
    turns = np.linalg.svd(J[3:] @ np.linalg.svd(J[:3])[2][3:].T)[0]
    missing = "this arm cannot turn that way: with the position held, no joint turns the tool about"
    for frame, R in (("tool", np.eye(3)), ("base", g[:3, :3])):
        output = pushed(name, BENT[name], np.r_[0, 0, 0, 0.05 * R @ turns[:, 2]], frame)
        assert output.status == "IMPOSSIBLE_DIRECTION"
        assert output.explain().startswith(missing)
    partly = pushed(name, BENT[name], np.r_[0, 0, 0, 0.05 * (turns[:, 2] + turns[:, 0])], "tool")
    assert partly.status == "OK"
    assert partly.explain().startswith(missing)


def test_a_motion_that_the_arm_has_elsewhere_is_a_singularity():
    """Stretched, ur5 has no motion about base x, and rr_planar none along itself: bent they have."""
    for name, twist, way in (
        ("ur5", [0, 0, 0, 0.3, 0, 0], "turn about"),
        ("rr_planar", [0.1, 0, 0, 0, 0, 0], "move along"),
    ):
        output = pushed(name, np.zeros(len(BENT[name])), twist)
        assert output.status == "SLOWED_SINGULARITY"
        assert f"this arm can hardly {way} the base's x axis from here" in output.explain()
    assert pushed("ur5", BENT["ur5"], [0, 0, 0, 0.1, 0, 0]).explain() == "moving as commanded"


def test_a_planar_arm_turns_its_tool_on_the_way_and_says_so():
    twist = [0.02, 0, 0, 0, 0, 0]
    output = pushed("rr_planar", BENT["rr_planar"], twist)
    assert output.status == "OK"
    assert output.explain() == "this arm cannot move that way without turning the tool about the base's z axis"
    arm = load("rr_planar")
    held = TwistCommand(twist, "base", hold="orientation")
    _, output = servo_step(arm, ServoState.at(arm, BENT["rr_planar"]), held, DT)
    assert "cannot move that way: with the orientation held, no joint moves the tool along" in output.explain()


def test_leaving_a_singularity_is_called_ok():
    arm = load("ur5")
    theta = np.array([0.0, -0.6, 0.08, 0.3, 0.4, 0.0])
    g = arm.by_pinocchio(theta)[0]
    inward = -g[:3, 3] / np.linalg.norm(g[:3, 3])
    _, in_ = servo_step(arm, ServoState.at(arm, theta), TwistCommand([*0.1 * inward, 0, 0, 0], "base"), DT)
    _, out = servo_step(arm, ServoState.at(arm, theta), TwistCommand([*-0.1 * inward, 0, 0, 0], "base"), DT)
    assert in_.status == "OK"
    assert out.status == "SLOWED_SINGULARITY"


def test_outward_until_stretched_and_back():
    """UR5 pushed outward: the elbow closes in on straight, rates stay calm, the reason is steady, and it returns."""
    arm = load("ur5")
    out = TwistCommand([0.2, 0, 0, 0, 0, 0], "base")
    state, rates, reasons = ServoState.at(arm, arm.ready), [], []
    for _ in range(1200):
        state, output = servo_step(arm, state, out, DT)
        rates.append(state.theta_dot)
        reasons.append(output.reason)
    assert output.status == "SLOWED_SINGULARITY"
    assert output.explain() != output.reason.value
    assert ServoReason.SINGULARITY in reasons
    assert sum(reason is not before for before, reason in pairwise(reasons)) < 10
    assert abs(state.theta[2]) < 0.05  # stretched
    assert np.abs(np.diff(rates, axis=0))[5:].max() < 0.35  # rad/s from one cycle to the next
    before = pose(arm, state)
    state, _ = driven(arm, state, TwistCommand([-0.2, 0, 0, 0, 0, 0], "base"), 100)
    assert pose(arm, state)[0, 3] < before[0, 3] - 0.13
    state, output = servo_step(arm, state, None, DT)
    assert (output.reason, output.explain()) == (ServoReason.STALE, "no command")


@pytest.mark.parametrize("name", ["ur5", "elbow", "rr_planar"])
def test_an_arm_leaves_a_posture_that_is_exactly_singular(name):
    """Stretched at theta = 0, the tool is pulled back toward the base, where no joint rates lead to first order."""
    arm = load(name)
    g = arm.by_pinocchio(np.zeros(arm.n))[0]
    base = np.zeros(3) if name == "rr_planar" else np.array([0, 0, g[2, 3]])
    inward = (base - g[:3, 3]) / np.linalg.norm(base - g[:3, 3])
    state, _ = driven(arm, ServoState.at(arm, np.zeros(arm.n)), TwistCommand([*0.1 * inward, 0, 0, 0], "base"), 300)
    assert inward @ (pose(arm, state)[:3, 3] - g[:3, 3]) > 0.2


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_an_arm_leaves_to_the_side_where_it_has_room(side):
    """Two links, stretched: both bends of the elbow pull the tool in, and one of them ends at a limit soon."""
    free = np.full(2, np.inf)
    ends = np.sort(side * np.array([[0.15, 0.15], [-2.0, -2.0]]), axis=0)
    screws = np.hstack([joints.revolute([0, 0, 1], [0, 0, 0]), joints.revolute([0, 0, 1], [0.5, 0, 0])])
    home = np.eye(4) + 0.9 * np.eye(4, k=3)
    limits = JointLimits(np.array([-3.0, ends[0, 1]]), np.array([3.0, ends[1, 1]]), free, np.full(2, 5.0), free, free)
    arm = arm_from_screws(screws, home, limits=limits, name="two links")
    state, _ = driven(arm, ServoState.at(arm, np.zeros(2)), TwistCommand([-0.1, 0, 0, 0, 0, 0], "base"), 300)
    a, b = state.theta
    assert 0.5 * np.cos(a) + 0.4 * np.cos(a + b) < 0.75


def test_the_length_is_stated_and_can_be_set():
    """With metres measured in ten times the reach, damping begins earlier."""
    arm = load("ur5")
    theta = arm.ready.copy()
    theta[2] = 0.4
    twist = TwistCommand([0.0, 0.05, 0.05, 0, 0, 0], "base")
    plain, longer = (
        servo_step(arm, ServoState.at(arm, theta), twist, DT, settings=settings)[1]
        for settings in (ServoSettings(), ServoSettings(length=10 * arm.reach))
    )
    assert plain.status == "OK"
    assert longer.status == "SLOWED_SINGULARITY"
