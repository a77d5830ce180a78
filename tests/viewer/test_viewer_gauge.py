"""How near a driven arm is to what slows a servo: against Pinocchio, NumPy, hand calculation and the servo itself."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from twistarm import Arm, ArmBuilder, load_arm
from twistarm.arm.usual_limits import with_defaults
from twistarm.control.servo import JogCommand, ServoSettings, ServoState, TwistCommand, servo_step
from twistarm.limits.actuators import Actuators
from twistarm.limits.joint_limits import JointLimits
from twistarm.support.checks import Array
from twistarm.viewer.parts.servo import NO_GAUGE, Gauge, servo_words
from twistarm.viewer.parts.show import NO_REPORT
from twistarm.viewer.stage import Stage

BELOW = ServoSettings().singularity_threshold


def gauge(arm: Arm, theta: Any) -> dict[str, Any]:
    stage = Stage(arm, theta)
    stage.set_servo_status(NO_REPORT)
    (message,) = Gauge(arm).messages(stage)
    return message


def by_pinocchio(arm: Arm, theta: Array) -> Array:
    """The singular values of Pinocchio's Jacobian, metres measured in the arm's reach."""
    _, _, J = arm.by_pinocchio(theta)
    slides = np.array(arm.units) == "m"
    scaled = np.diag([1 / arm.reach] * 3 + [1.0] * 3) @ J @ np.diag(np.where(slides, arm.reach, 1.0))
    values: Array = np.linalg.svd(scaled, compute_uv=False)
    return values


def planar(second: float) -> Arm:
    """Two joints that turn about z, links of 0.4 m and `second` [m] along x."""
    tool = np.eye(4)
    tool[0, 3] = 0.4 + second
    builder = ArmBuilder("planar").revolute("a", [0, 0, 1], [0, 0, 0], lower=-3, upper=3)
    return builder.revolute("b", [0, 0, 1], [0.4, 0, 0], lower=-2, upper=1).tool(tool).build()


@pytest.mark.parametrize("name", ["rover_arm", "rover_arm_6dof", "panda"])
def test_the_smallest_singular_value_is_pinocchio_s(name: str) -> None:
    arm = load_arm(name)
    for theta in arm.random_theta(np.random.default_rng(3), 8):
        message = gauge(arm, theta)
        assert message["sigma"] == pytest.approx(by_pinocchio(arm, theta)[-1], abs=1e-5)
        assert message["below"] == BELOW


@pytest.mark.parametrize(("bend", "status"), [(0.1, "SLOWED_SINGULARITY"), (0.3, "OK")])
def test_it_is_near_where_the_servo_slows(bend: float, status: str) -> None:
    """The wrist of the six-joint arm: axes 4 and 6 in line at theta5 = 0; asked for is what is lost there."""
    arm = load_arm("rover_arm_6dof")
    arm = replace(arm, limits=with_defaults(arm))
    theta = arm.ready.copy()
    theta[4] = bend
    message = gauge(arm, theta)
    assert (message["sigma"] < BELOW) == (status == "SLOWED_SINGULARITY")
    slides = np.array(arm.units) == "m"
    U = np.linalg.svd(
        np.diag([1 / arm.reach] * 3 + [1.0] * 3)
        @ arm.hybrid_jacobian(theta)
        @ np.diag(np.where(slides, arm.reach, 1.0))
    )[0]
    lost = U[:, 5] * np.repeat([arm.reach, 1.0], 3)
    seen = set()
    for sign in (-1, 1):
        state = ServoState.at(arm, theta)
        _, output = servo_step(arm, state, TwistCommand(0.05 * sign * lost, "base"), 0.01)
        seen.add(output.status)
    assert ("SLOWED_SINGULARITY" in seen) == (status == "SLOWED_SINGULARITY")
    words = ["along x", "along y", "along z", "about x", "about y", "about z"]
    assert message["lacks"] == words[int(np.argmax(np.abs(U[:, 5])))]


def test_a_direction_that_is_lost_here_alone() -> None:
    arm = planar(0.3)
    assert gauge(arm, [0.0, 0.01])["lacks"] == "along x"
    assert gauge(arm, [np.pi / 2, 0.01])["lacks"] == "along y"
    straight = gauge(arm, [0.0, 0.0])
    assert (straight["sigma"], straight["lacks"]) == (0.0, None)


def test_the_nearest_limit_is_the_joint_with_least_room_for_its_kind() -> None:
    arm = planar(0.3)
    for theta, joint, room, end in [
        ([0.0, 0.9], "b", 0.1, "upper"),
        ([0.0, -1.7], "b", 0.3, "lower"),
        ([-2.95, 0.5], "a", 0.05, "lower"),
    ]:
        message = gauge(arm, theta)
        assert (message["joint"], message["unit"], message["end"]) == (joint, "rad", end)
        assert message["room"] == pytest.approx(room, abs=1e-6)
        assert message["near"] == pytest.approx(0.05 * {"a": 6.0, "b": 3.0}[joint])


def test_a_joint_that_the_servo_calls_limited_is_the_one_of_the_gauge() -> None:
    """The other is nearer to its end, but moves away from it."""
    arm = replace(planar(0.3), limits=with_defaults(planar(0.3)))
    state = ServoState.at(arm, [2.0, 0.95])
    for _ in range(200):
        state, output = servo_step(arm, state, JogCommand([1.0, -0.01]), 0.01)
        if output.joint:
            break
    assert (output.status, output.joint) == ("SLOWED_LIMIT", "a")
    theta = state.theta
    assert 3.0 - theta[0] > 1.5 * (1.0 - theta[1])
    stage, part = Stage(arm, theta), Gauge(arm)
    for report, joint in ((NO_REPORT, "b"), (servo_words(output), "a"), (NO_REPORT, "b")):
        stage.set_servo_status(report)
        (message,) = part.messages(stage)
        assert (message["joint"], message["end"]) == (joint, "upper")
        assert message["room"] == pytest.approx({"a": 3.0, "b": 1.0}[joint] - theta["ab".index(joint)], abs=1e-6)


def test_a_slide_in_metres_and_joints_without_limits() -> None:
    arm = load_arm("rover_arm")
    theta = arm.ready.copy()
    theta[0] = arm.limits.lower[0] + 0.002
    message = gauge(arm, theta)
    assert (message["joint"], message["unit"], message["end"]) == ("slide", "m", "lower")
    assert message["room"] == pytest.approx(0.002, abs=1e-6)
    free = planar(0.3)
    free = replace(free, limits=JointLimits.unbounded(2))
    message = gauge(free, [0.1, 0.2])
    assert message["sigma"] > 0
    assert [message[name] for name in ("joint", "unit", "room", "near", "end")] == [None] * 5


def test_near_is_a_twentieth_of_the_range_or_five_degrees() -> None:
    """5° are 0.08727 rad: a twentieth of the range from ±0.873 rad on."""
    home = np.eye(4)
    home[0, 3] = 0.5
    for half, turn, slide in [(0.2, 0.0872665, 0.02), (0.02, 0.0872665, 0.01), (1.0, 0.1, 0.1)]:
        builder = ArmBuilder("short").revolute("turn", [0, 0, 1], [0, 0, 0], lower=-half, upper=half)
        arm = builder.prismatic("slide", [1, 0, 0], lower=-half, upper=half).tool(home).build()
        for theta, joint, near in [([0.99 * half, 0.0], "turn", turn), ([0.0, 0.999 * half], "slide", slide)]:
            message = gauge(arm, theta)
            assert (message["joint"], message["near"]) == (joint, pytest.approx(near, abs=1e-6))
    free = replace(planar(0.3), limits=replace(JointLimits.unbounded(2), upper=np.array([1.0, np.inf])))
    assert gauge(free, [0.9, 0.2])["near"] == pytest.approx(0.0872665, abs=1e-6)


def test_a_motor_s_limit_counts_too() -> None:
    """A differential: motors a + b and a − b, the first of which may turn by 1 rad."""
    arm = planar(0.3)
    limits = JointLimits.unbounded(2)
    limits = replace(limits, lower=np.array([-1.0, -5.0]), upper=np.array([1.0, 5.0]))
    G = np.array([[1.0, 1.0], [1.0, -1.0]])
    nan = np.full(2, np.nan)
    motors = Actuators(("left", "right"), arm.joint_names, G, np.zeros(2), ("deg", "turn"), nan, limits)
    message = gauge(replace(arm, actuators=motors), [0.5, 0.45])
    assert (message["joint"], message["unit"], message["end"]) == ("left", "rad", "upper")
    assert message["room"] == pytest.approx(0.05, abs=1e-6)


def test_silent_while_no_servo_drives_and_measured_once_per_posture() -> None:
    arm = planar(0.3)
    stage, part = Stage(arm, [0.1, 0.2]), Gauge(arm)
    assert list(part.messages(stage)) == [{"type": "gauge", **NO_GAUGE}]
    stage.set_servo_status(NO_REPORT)
    first, again = [next(iter(part.messages(stage))) for _ in range(2)]
    assert first == again
    assert first["sigma"] > 0
    stage.show(np.array([0.1, 0.5]))
    assert next(iter(part.messages(stage)))["sigma"] > first["sigma"]
    stage.set_servo_status(None)
    assert list(part.messages(stage)) == [{"type": "gauge", **NO_GAUGE}]
