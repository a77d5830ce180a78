"""Poses, states and motors on the chain: with locked joints, followers, and another chain than the arm.toml's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from stream_stand_ins import FakeClock, Says
from twistarm import Arm, ArmBuilder, DescriptionError, load_arm
from twistarm.arm.usual_limits import DEFAULTS, defaults_line, with_defaults
from twistarm.control.servo import JogCommand
from twistarm.control.stream import Setpoint, SimulatedJoints, run
from urdf_text import joint, robot, two_joints, write

TOML = """
source = "arm.urdf"
tip = "tool0"
[limits]
a.velocity = 1.5
b.acceleration = 4.0
[poses.ready]
a = 0.1
b = -0.2
[poses.stowed]
a = 0.5
b = 0.0
[actuators.left]
ratio = { a = 60.0, b = 30.0 }
offset = 0.5
unit = "tick"
ticks_per_turn = 4096
[actuators.right]
ratio = { a = 60.0, b = -30.0 }
limits = { lower = -200.0, upper = 150.0, velocity = 80.0, acceleration = 900.0, effort = 0.0 }
"""


def codes(arm: Arm) -> list[str]:
    return [finding.code for finding in arm.findings]


@pytest.fixture
def toml(tmp_path: Path) -> Path:
    write(tmp_path, two_joints())
    return write(tmp_path, TOML, "arm.toml")


def test_motors_of_an_arm_toml(toml: Path) -> None:
    arm = load_arm(toml)
    motors = arm.actuators
    assert motors is not None
    assert (motors.names, motors.joint_names, motors.units) == (("left", "right"), ("a", "b"), ("tick", "rad"))
    assert motors.G.tolist() == [[60.0, 30.0], [60.0, -30.0]]
    assert motors.offset.tolist() == [0.5, 0.0]
    assert motors.ticks_per_turn.tolist() == [4096.0, pytest.approx(np.nan, nan_ok=True)]
    assert np.allclose(motors.to_theta(motors.to_motor(arm.ready)), arm.ready)
    # Each by name; an effort of 0 is none that was given.
    assert (motors.limits.lower.tolist(), motors.limits.upper.tolist()) == ([-np.inf, -200.0], [np.inf, 150.0])
    assert (motors.limits.velocity.tolist(), motors.limits.acceleration.tolist()) == ([np.inf, 80.0], [np.inf, 900.0])
    assert motors.limits.effort.tolist() == [np.inf, np.inf]
    assert load_arm(toml.parent / "arm.urdf").actuators is None
    assert arm.with_tool(np.eye(4), "pen").actuators is motors


def test_a_locked_joint_stays_in_the_motors_offset_and_in_poses_that_agree(toml: Path) -> None:
    free, arm = load_arm(toml), load_arm(toml, locked_joints={"a": 0.1})
    assert arm.joint_names == ("b",)
    assert {name: theta.tolist() for name, theta in arm.named_states.items()} == {"ready": [-0.2]}
    assert codes(arm) == ["companion-doubtful"]
    assert "pose 'stowed': it moves the locked joint a; it is left out" in str(arm.findings[0])
    assert arm.actuators is not None
    assert free.actuators is not None
    for b in (-0.3, 0.0, 0.4):
        assert np.allclose(arm.actuators.to_motor([b]), free.actuators.to_motor([0.1, b]))


def test_another_chain_than_the_files_takes_what_fits(toml: Path) -> None:
    arm = load_arm(toml, tip="upper")
    assert (arm.joint_names, arm.limits.velocity.tolist()) == (("a",), [1.5])
    assert arm.ready.tolist() == [0.1]
    assert arm.actuators is None
    assert codes(arm) == ["off-the-chain", "off-the-chain"]
    assert "it drives 'b', outside this chain; it is left out" in arm.findings[0].what
    # The same tip by name is the same chain, and nothing is forgiven.
    assert load_arm(toml, tip="tool0").actuators is not None


def test_a_pose_that_says_too_little_of_another_chain_is_left_out(tmp_path: Path) -> None:
    parts = joint("a", "base_link", "upper"), joint("b", "upper", "left"), joint("c", "upper", "right")
    write(tmp_path, robot(*parts, links=("base_link", "upper", "left", "right")))
    path = write(tmp_path, 'source = "arm.urdf"\ntip = "left"\n[poses.ready]\na = 0.1\nb = 0.2', "arm.toml")
    arm = load_arm(path, tip="right")
    assert codes(arm) == ["companion-not-used"]
    assert "no value for joint 'c'" in arm.findings[0].what
    assert load_arm(path).ready.tolist() == [0.1, 0.2]


def test_a_motor_on_a_follower_drives_its_master(tmp_path: Path) -> None:
    parts = (
        joint("a", "base_link", "upper"),
        joint("b", "upper", "tool0", inside='<mimic joint="a" multiplier="-0.5" offset="0.1"/>'),
    )
    write(tmp_path, robot(*parts))
    text = 'source = "arm.urdf"\n[actuators.m]\nratio = { a = 10.0, b = 20.0 }'
    arm = load_arm(write(tmp_path, text, "arm.toml"))
    assert arm.actuators is not None
    # 10 a + 20 (0.1 − a / 2) = 2: the two cancel.
    assert np.allclose(arm.actuators.to_motor([0.7]), [2.0])
    assert arm.actuators.undriven == ("a",)


REFUSED = {
    "an unknown joint": ("ratio = { elbow = 1.0 }", "'elbow'"),
    "no ratio": ("offset = 1.0", "'ratio'"),
    "a ratio of zero": ("ratio = { a = 0.0 }", "actuators.m.ratio.a"),
    "a ratio in words": ('ratio = { a = "100:1" }', "actuators.m.ratio.a"),
    "an unknown entry": ("ratio = { a = 1.0 }\ngear = 3", "unknown entry 'gear' in actuators.m"),
    "a unit that is a number": ("ratio = { a = 1.0 }\nunit = 1", "actuators.m.unit"),
    "limits that are no table": ("ratio = { a = 1.0 }\nlimits = 3", "actuators.m.limits"),
    "a negative limit": ("ratio = { a = 1.0 }\nlimits.effort = -2", "m.limits.effort"),
    "swapped limits": (
        "ratio = { a = 1.0 }\nlimits = { lower = 3, upper = 1 }",
        "actuators.m.limits are swapped: lower 3 >",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_motors_in_one_line(case: str, tmp_path: Path) -> None:
    text, message = REFUSED[case]
    parts = joint("a", "base_link", "upper"), joint("b", "upper", "tool0"), joint("f", "upper", "finger")
    write(tmp_path, robot(*parts, links=("base_link", "upper", "tool0", "finger")))
    with pytest.raises(DescriptionError) as caught:
        load_arm(write(tmp_path, f'source = "arm.urdf"\n[actuators.m]\n{text}', "arm.toml"))
    assert message in str(caught.value)
    assert str(caught.value).startswith(f"{tmp_path}/arm.toml: ")
    assert "\n" not in str(caught.value)
    assert [finding.code for finding in caught.value.findings] == ["companion-unusable"]


def state(name: str, group: str, **values: float) -> str:
    joints = "".join(f'<joint name="{joint}" value="{value}"/>' for joint, value in values.items())
    return f'<group_state name="{name}" group="{group}">{joints}</group_state>'


def with_states(folder: Path, *states: str) -> Path:
    write(folder, f'<robot name="tiny">{"".join(states)}</robot>', "arm.srdf")
    return write(folder, two_joints())


def test_states_that_give_every_coordinate_are_named_states(tmp_path: Path) -> None:
    path = with_states(
        tmp_path,
        state("ready", "arm", a=0.3, b=-0.4),
        state("folded", "all", a=0.1, b=0.2, finger=0.01),
        state("open", "hand", finger=0.02),
        state("half", "arm", a=0.1),
        state("beyond", "arm", a=0.1, b=1.2),
    )
    arm = load_arm(path)
    assert {name: theta.tolist() for name, theta in arm.named_states.items()} == {
        "ready": [0.3, -0.4], "folded": [0.1, 0.2],
    }  # fmt: skip
    assert arm.ready.tolist() == [0.3, -0.4]
    said = {finding.code: str(finding) for finding in arm.findings}
    assert "group_state 'half': no value for joint 'b'; it is left out" in said["companion-not-used"]
    assert "group_state 'beyond': b = 1.2 lies outside its limits [-1, 1]; it is left" in said["outside-limits"]
    assert said["outside-limits"].startswith("warning: ")
    assert "gives 2 named configurations" in said["srdf-found"]


def test_a_state_rounded_beyond_a_limit_is_put_onto_it(tmp_path: Path) -> None:
    arm = load_arm(with_states(tmp_path, state("end", "arm", a=1.0000499, b=-1.00009)))
    assert arm.named_states["end"].tolist() == [1.0, -1.0]
    assert load_arm(with_states(tmp_path, state("end", "arm", a=1.0002, b=0.0))).named_states == {}


def test_the_arms_own_poses_win_over_states_and_its_group_over_others(tmp_path: Path) -> None:
    group = '<group name="arm"><chain base_link="base_link" tip_link="tool0"/></group>'
    path = with_states(tmp_path, state("home", "all", a=0.1, b=0.1), state("home", "arm", a=0.2, b=0.2), group)
    assert load_arm(path).named_states["home"].tolist() == [0.2, 0.2]
    assert load_arm(path, tip="tool0").named_states["home"].tolist() == [0.2, 0.2]
    toml = write(tmp_path, 'source = "arm.urdf"\n[poses.home]\na = 0.3\nb = 0.3', "arm.toml")
    assert load_arm(toml).named_states["home"].tolist() == [0.3, 0.3]


@pytest.fixture(scope="module")
def arm() -> Arm:
    builder = ArmBuilder("crane").revolute("turn", [0, 0, 1], [0, 0, 0], lower=-2, upper=2, velocity=0.5)
    return builder.prismatic("reach", [1, 0, 0], lower=0, upper=0.5).tool(np.eye(4)).build()


def test_what_is_given_stays_and_what_is_not_is_usual(arm: Arm) -> None:
    limits = with_defaults(arm)
    assert limits.velocity.tolist() == [0.5, 0.25]
    assert limits.acceleration.tolist() == [3.0, 1.0]
    for name in ("lower", "upper", "jerk", "effort"):
        assert_array_equal(getattr(limits, name), getattr(arm.limits, name))


BARE = """<robot name="bare"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
<joint name="turn" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>{turn}</joint>
<joint name="swing" type="revolute"><parent link="b"/><child link="c"/><origin xyz="0.3 0 0"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="0" velocity="{velocity}"/></joint>
<joint name="reach" type="prismatic"><parent link="c"/><child link="d"/><axis xyz="1 0 0"/>
<limit lower="0" upper="0.3" effort="0" velocity="{velocity}"/></joint>
</robot>"""


@pytest.mark.parametrize("velocity", ["0", "1e9"])  # zeros and huge numbers are written where no limit is meant
@pytest.mark.parametrize("turn", ["", '<limit effort="0" velocity="0"/>'])
def test_nothing_is_unbounded_in_a_stream_nor_in_simulated_joints(tmp_path: Path, velocity: str, turn: str) -> None:
    file = tmp_path / "bare.urdf"
    file.write_text(BARE.format(turn=turn, velocity=velocity))
    arm, clock = load_arm(file), FakeClock()
    usual = {name: np.array([units[unit] for unit in arm.units]) for name, units in DEFAULTS.items()}
    joints, rates, moved = SimulatedJoints(arm, arm.ready, latency=0.05, clock=clock), [], []

    class Sink:
        def write(self, setpoint: Setpoint) -> None:
            rates.append(setpoint.theta_dot)
            moved.append(joints.theta_dot)
            joints.write(setpoint)

    to_and_fro = Says(lambda now: JogCommand(np.full(arm.n, 50.0 if now % 0.5 < 0.25 else -50.0)))
    report = run(arm, to_and_fro, Sink(), joints, duration=1.5, clock=clock)
    assert report.ok
    assert report.assumed == defaults_line(arm)
    assert report.assumed in report.explain()
    assert (np.abs(rates) <= usual["velocity"] * (1 + 1e-9)).all()
    assert (np.abs(np.diff(rates, axis=0)) <= usual["acceleration"] * 0.01 * (1 + 1e-9)).all()
    # Drives have the reserve that the page says: 1.2 and 2 times.
    assert (np.abs(moved) <= 1.2 * usual["velocity"] * (1 + 1e-9)).all()
    assert np.abs(moved).max() > 0.1
