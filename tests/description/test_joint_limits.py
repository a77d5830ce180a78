"""Limits of joints in YAML, as MoveIt, ros2_control and UR write them, over the description's; soft limits."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from twistarm import Arm, DescriptionError, crosscheck, load_arm
from twistarm.description.companions.data_files import parse_yaml
from urdf_text import two_joints, write

MOVEIT = """
default_velocity_scaling_factor: 0.1
default_acceleration_scaling_factor: 0.1
joint_limits:
  a:
    has_velocity_limits: true
    max_velocity: 0.5
    has_acceleration_limits: true
    max_acceleration: 3
    has_jerk_limits: true
    max_jerk: 1e2
  b:
    has_velocity_limits: false
    max_velocity: 9.0
    has_position_limits: true
    min_position: !degrees -30
    max_position: !degrees 45
    max_effort: 7.0
  finger:
    max_velocity: 1.0
"""


def codes(arm: Arm) -> list[str]:
    return [finding.code for finding in arm.findings]


def test_what_the_file_gives_replaces_and_what_it_switches_off_does_not(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, two_joints()), limits=write(tmp_path, MOVEIT, "joint_limits.yaml"))
    limits = arm.limits
    assert limits.velocity.tolist() == [0.5, 2.0]
    assert limits.acceleration.tolist() == [3.0, np.inf]
    assert limits.jerk.tolist() == [100.0, np.inf]
    assert limits.effort.tolist() == [3.0, 7.0]
    assert np.allclose(limits.lower, [-1.0, np.radians(-30)])
    assert np.allclose(limits.upper, [1.0, np.radians(45)])
    assert codes(arm) == ["companion-not-used", "companion-doubtful"]
    assert "it has limits for 'finger', and no joint has that name" in arm.findings[1].what
    assert "default_velocity_scaling_factor 0.1 and default_acceleration_scaling_factor 0.1" in arm.findings[0].what


NESTED = {
    "ros2 parameters": "/**:\n  ros__parameters:\n    joint_limits:\n      a: {max_velocity: 0.5}",
    "MoveIt's parameters": (
        "move_group:\n  ros__parameters:\n    robot_description_planning:\n      joint_limits:\n"
        "        a: {has_velocity_limits: true, max_velocity: 0.5}"
    ),
    "ros2_control's": (
        "joint_limits:\n  a: {has_velocity_limits: true, max_velocity: 0.5, has_soft_limits: false, "
        "k_position: 1.0, k_velocity: 1.0, soft_lower_limit: 0.0, soft_upper_limit: 0.1, angle_wraparound: false}"
    ),
}


@pytest.mark.parametrize("case", NESTED)
def test_wherever_the_mapping_stands(case: str, tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, two_joints()), limits=write(tmp_path, NESTED[case], "l.yaml"))
    assert arm.limits.velocity.tolist() == [0.5, 2.0]
    assert codes(arm) == []


@pytest.mark.parametrize("slowing", [0.3, -0.3])  # ros2_control writes a positive number, Pilz's planner a negative one
def test_a_deceleration_limits_the_acceleration_too(slowing: float, tmp_path: Path) -> None:
    text = f"joint_limits: {{a: {{max_acceleration: 2.0, max_deceleration: {slowing}}}, b: {{max_deceleration: 9.0}}}}"
    arm = load_arm(write(tmp_path, two_joints()), limits=write(tmp_path, text, "l.yaml"))
    assert arm.limits.acceleration.tolist() == [0.3, 9.0]
    arm = load_arm(
        arm.source, limits=write(tmp_path, text.replace("{max_a", "{has_deceleration_limits: false, max_a"), "m.yaml")
    )
    assert arm.limits.acceleration.tolist() == [2.0, 9.0]


SOFT_RANGES = {
    "soft_lower_limit: -0.5, soft_upper_limit: 0.25": ((-0.5, 0.25), ["limits-adjusted"]),
    "soft_lower_limit: -5, soft_upper_limit: 0.25": ((-1.0, 0.25), ["limits-adjusted"]),
    "min_position: -0.3, soft_lower_limit: -0.5": ((-0.3, 1.0), ["limits-adjusted"]),
    "has_soft_limits: false, soft_lower_limit: 0": ((-1.0, 1.0), ["companion-not-used"]),
}


@pytest.mark.parametrize("given", SOFT_RANGES)
def test_soft_limits_of_the_file_narrow_the_range(given: str, tmp_path: Path) -> None:
    expected, noted = SOFT_RANGES[given]
    file = write(tmp_path, f"joint_limits: {{a: {{{given}}}}}", "l.yaml")
    arm = load_arm(write(tmp_path, two_joints()), limits=file)
    assert (arm.limits.lower[0], arm.limits.upper[0]) == expected
    assert codes(arm) == noted


def test_soft_limits_that_leave_no_room_are_refused(tmp_path: Path) -> None:
    file = write(tmp_path, "joint_limits: {a: {soft_lower_limit: 2, soft_upper_limit: 3}}", "l.yaml")
    with pytest.raises(DescriptionError, match=r"l\.yaml: .*soft limits of a leave no room"):
        load_arm(write(tmp_path, two_joints()), limits=file)


def test_arm_toml_names_a_file_and_corrects_it(tmp_path: Path) -> None:
    """Description, then the file, then [limits], then the caller."""
    write(tmp_path, two_joints())
    write(tmp_path, "joint_limits: {a: {max_velocity: 0.5, max_acceleration: 3.0}}", "l.yaml")
    text = 'source = "arm.urdf"\njoint_limits = "l.yaml"\n[limits]\na.acceleration = 4.0\n'
    path = write(tmp_path, text, "arm.toml")
    arm = load_arm(path)
    assert (arm.limits.velocity.tolist(), arm.limits.acceleration.tolist()) == ([0.5, 2.0], [4.0, np.inf])
    assert load_arm(path, limits={"velocity": {"a": 0.1}}).limits.velocity.tolist() == [0.1, 2.0]
    file = write(tmp_path, "joint_limits: {a: {max_velocity: 0.2}}", "m.yaml")
    arm = load_arm(path, limits=str(file))
    assert (arm.limits.velocity.tolist(), arm.limits.acceleration.tolist()) == ([0.2, 2.0], [4.0, np.inf])
    with pytest.raises(DescriptionError, match="arm.toml: joint_limits 'no.yaml' does not exist beside it"):
        load_arm(write(tmp_path, text.replace("l.yaml", "no.yaml"), "arm.toml"))


def test_zero_means_not_given_and_an_unknown_entry_is_said(tmp_path: Path) -> None:
    path = write(tmp_path, two_joints())
    arm = load_arm(path, limits=write(tmp_path, "joint_limits: {a: {max_velocity: 0, max_effort: 0.0}}", "l.yaml"))
    assert arm.limits.velocity.tolist() == [2.0, 2.0]
    assert codes(arm) == ["companion-not-used"]
    arm = load_arm(path, limits=write(tmp_path, "joint_limits: {a: {max_velocty: 1}}", "l.yaml"))
    assert codes(arm) == ["companion-doubtful", "companion-not-used"]
    assert "unknown and left out; closest: 'max_velocity'" in str(arm.findings[0])


REFUSED = {
    "joint_limits: [a, b]": "joint_limits",
    "joint_limits: {a: {max_velocity: fast}}": "max_velocity",
    "joint_limits: {x: {max_velocity: 1}}": "'x'",
    "x: {joint_limits: {a: {}}}\ny: {joint_limits: {a: {}}}": "2 places",
    "joint_limits: {a: {max_velocity: -1}}": "max_velocity",
    "joint_limits: {a: {has_velocity_limits: 'on'}}": "has_velocity_limits",
    "joint_limits: {a: {min_position: 1, max_position: -1}}": "min_position 1",
    "joint_limits: {a: {min_position: 2}}": "limits of a ",
    "joint_limits: {a: 1.0}": "joint_limits.a",
}


@pytest.mark.parametrize("text", REFUSED)
def test_refused_in_one_line(text: str, tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match=r"joint_limits.yaml: ") as caught:
        load_arm(write(tmp_path, two_joints()), limits=write(tmp_path, text, "joint_limits.yaml"))
    assert REFUSED[text] in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.findings[-1].code == "companion-unusable"


def test_files_that_are_none(tmp_path: Path) -> None:
    large = write(tmp_path, "joint_limits:\n" + "#" * 300_000, "big.yaml")
    for path, what in ((tmp_path / "no.yaml", "no.yaml"), (tmp_path, "a folder"), (large, "300,014")):
        with pytest.raises(DescriptionError, match=what):
            load_arm(write(tmp_path, two_joints()), limits=path)


# -- soft limits, by the rule of MoveIt's joint model ----------------------------------------------------------------

SOFT = '<safety_controller {} k_position="100" k_velocity="40"/>'


def arm_with(folder: Path, given: str, **changes: str) -> Arm:
    return load_arm(write(folder, two_joints(inside=SOFT.format(given), **changes)))


def as_moveit(soft: tuple[float, float]) -> tuple[float, float]:
    """jointBoundsFromURDF of moveit_core, for a joint of -1 … 1."""
    return max(soft[0], -1.0), min(soft[1], 1.0)


RANGES = {
    'soft_lower_limit="-0.5" soft_upper_limit="0.6"': as_moveit((-0.5, 0.6)),
    'soft_lower_limit="-3" soft_upper_limit="0.6"': as_moveit((-3, 0.6)),
    'soft_lower_limit="-0.5"': as_moveit((-0.5, 0)),
    'soft_lower_limit="0" soft_upper_limit="0"': (-1.0, 1.0),
    "": (-1.0, 1.0),
    'soft_lower_limit="2" soft_upper_limit="3"': (-1.0, 1.0),
}


@pytest.mark.parametrize("given", RANGES)
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_the_narrower_of_soft_and_hard_limits_counts(given: str, kind: str, tmp_path: Path) -> None:
    arm = arm_with(tmp_path, given, kind=kind)
    assert (arm.limits.lower[0], arm.limits.upper[0]) == RANGES[given]
    assert (arm.limits.lower[1], arm.limits.upper[1]) == (-1.0, 1.0)
    told = [one.what for one in arm.findings if one.code == "limits-adjusted"]
    assert len(told) == (RANGES[given] != (-1.0, 1.0))
    assert ("outside-limits" in [one.code for one in arm.findings]) == ('"2" soft_upper_limit="3"' in given)
    assert crosscheck(arm, 5).ok  # Pinocchio as written knows the hard ones


def test_a_continuous_joint_keeps_none(tmp_path: Path) -> None:
    arm = arm_with(tmp_path, 'soft_lower_limit="-0.5" soft_upper_limit="0.5"', kind="continuous")
    assert np.isinf(arm.limits.upper[0])


FILE = Path("limits.yaml")


def test_units_and_exponents() -> None:
    text = "{a: !degrees 180, b: !radians 1.5, d: 1e-3, e: 2E2, f: -1e3, g: 1.5, h: yes, i: x1e3}"
    read = parse_yaml(text, FILE)
    assert np.isclose(read.pop("a"), np.pi)
    assert read == {"b": 1.5, "d": 1e-3, "e": 200.0, "f": -1000.0, "g": 1.5, "h": True, "i": "x1e3"}
    assert yaml.safe_load("1e3") == "1e3", "the tags and numbers hold for the whole process"
    assert "!" not in yaml.SafeLoader.yaml_multi_constructors


def test_anchors_and_merges() -> None:
    read = parse_yaml("all: &all {max_velocity: 1.0}\na: *all\nb: {<<: *all, max_jerk: 2.0}", FILE)
    assert read["a"] == {"max_velocity": 1.0}
    assert read["b"] == {"max_velocity": 1.0, "max_jerk": 2.0}


REFUSED_YAML = {
    "an object": ("!!python/object/apply:os.system ['true']", 1),
    "an unknown tag": ("a: 1\nb: !degree 1", 2),
    "a tab": ("a:\n\tb: 1", 2),
    "a key twice": ("a:\n  b: 1\n  b: 2", 2),
    "two documents": ("a: 1\n---\nb: 2", 2),
    "too deep": ("[" * 5000, None),
    "an unclosed list": ("{\n", 2),
    "no number behind a unit": ("a: !degrees x", None),
}


@pytest.mark.parametrize("case", REFUSED_YAML)
def test_refused_in_one_line_yaml(case: str) -> None:
    text, line = REFUSED_YAML[case]
    with pytest.raises(DescriptionError) as caught:
        parse_yaml(text, FILE)
    assert "\n" not in str(caught.value)
    (finding,) = caught.value.findings
    assert finding.code == "companion-unusable"
    assert line is None or finding.place.line == line
