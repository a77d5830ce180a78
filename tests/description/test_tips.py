"""Base and tip where nobody names them, on descriptions laid out as public ones are; and what is asked instead."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from twistarm import DescriptionError, load_arm
from twistarm.description.tips import choose_ends, note_choice
from twistarm.description.tree import Description
from twistarm.description.urdf import read_description
from urdf_text import joint, robot, write

SIX = "base R> l1 R> l2 R> l3 R> l4 R> l5 R> l6"
WHEELS = "C> front_left_wheel | C> front_right_wheel | C> rear_left_wheel | C> rear_right_wheel"
ROCKER = "R> {0}_rocker [R> {0}_bogie [C> {0}_wheel_1 | C> {0}_wheel_2] | C> {0}_wheel_3]"
FINGERS = "P> left_finger | Pm> right_finger"

TIPS = {
    "behind a slash": ("/base R> /l1 R> /l2 -> /fingers [P> /left | Pm> /right | -> /ee_gripper]", "/ee_gripper"),
    "two alike behind each other": (f"{SIX} -> arm_tool_link -> wrist_ft_tool_link", "wrist_ft_tool_link"),
    "nothing but ornaments": (f"{SIX} [-> camera_link -> camera_optical_frame | -> imu]", "l6"),
    "a rod beside it": ("base R> l1 [R> l2 R> l3 [R> l4 R> l5 | Rm> link_b] | Rm> link_a]", "l5"),
    # names, behind prefixes and namespaces, in an order
    "a usual name": (f"{SIX} [-> tool0 | -> camera]", "tool0"),
    "behind a namespace": (f"ns/base R> ns/l1 R> ns/l2 [-> ns/ee_gripper_link | {FINGERS}]", "ns/ee_gripper_link"),
    "behind a prefix": (f"{SIX} [-> arm_link_tool0 | -> arm_link_flange]", "arm_link_tool0"),
    "in capitals": ("BaseLink R> LinkOne R> LinkTwo [-> EndEffectorLink | -> WristBracket]", "EndEffectorLink"),
    "an effector behind its flange": (f"{SIX} -> end_effector_flange_link -> end_effector_link", "end_effector_link"),
    "a tool on a tool0": (f"{SIX} -> flange -> tool0 -> gripper_base [{FINGERS} | -> grasp_link]", "grasp_link"),
    "a name in the middle is none": ("base R> l1 R> ee_link R> l3 R> l4 R> l5", "l5"),
    "nor on a stand": (f"world [-> board -> board_tcp | -> {SIX} -> flange]", "flange"),
    "nor on a camera": (f"{SIX} [-> camera_tool0 | -> gripper_body*]", "gripper_body"),
    # fingers
    "fingers on their palm": (f"{SIX} -> hand [{FINGERS}]", "hand"),
    "fingers on the last link": (f"{SIX} [P> l7 | P> l8]", "l6"),
    "a frame between them": (f"{SIX} -> hand [{FINGERS} | -> between]", "between"),
    "three fingers and a frame": (
        f"{SIX} [-> end_effector | R> f1 R> tip_1 | R> f2 R> tip_2 | R> f3 R> tip_3]", "end_effector"
    ),
    "jointed fingers that follow": (
        f"{SIX} [P> middle | Rm> left_1 P> left_2 R> left_3 | Rm> right_1 Pm> right_2 Rm> right_3]", "l6"
    ),
    "a hand with a longer thumb": (
        f"{SIX} -> wrist [R> a1 R> a2 | R> b1 R> b2 | R> c1 R> c2 | R> d1 R> d2 R> d3]", "wrist"
    ),
    "a jaw against a frame": (f"{SIX} [-> gripper_frame_link | R> moving_jaw]", "gripper_frame_link"),
    "a claw with grippers": ("base C> a R> b R> c C> d R> e C> claw [R> leftgripper | Rm> rightgripper]", "claw"),
    "fixed fingers": (f"{SIX} -> palm [-> finger_left | -> finger_right]", "palm"),
    "a jaw without a name": (f"{SIX} [-> gripper_frame_link | R> l7]", "gripper_frame_link"),
    "a jaw with rods": (f"{SIX} [-> tool_frame | R> horn Rm> rod]", "tool_frame"),
    "a jaw beside a gripper's site": (f"{SIX} [-> gripper | R> l7 -> l7_tip]", "gripper"),
    "a jaw on the gripper": ("base R> l1 R> l2 R> l3 R> l4 R> gripper R> jaw", "gripper"),
    "no jaw but a last joint with the tool": (f"{SIX} [-> ee_mount | R> l7 -> tool0]", "tool0"),
    # what hangs on
    "ornaments": ("base [-> lamp | R> l1 [-> motor1 | R> l2 [-> led_ring | -> april_tag | -> imu | -> pen]]]", "pen"),
    "a name before the roll": ("base R> l1 R> l2 R> l3 -> ee_link R> gripper_roll_link", "gripper_roll_link"),
    "a head beside the arm": (f"torso [R> neck R> head -> camera | -> {SIX}]", "l6"),
    "a pan and tilt beside it": ("base [R> pan R> tilt -> camera | R> s1 R> s2 R> s3]", "s3"),
    "cylinders beside it": (
        "base R> boom [R> stick [R> bucket | R> bucket_cylinder P> bucket_rod] | R> boom_cylinder P> boom_rod]",
        "bucket",
    ),
    "a flange behind a sensor": (f"{SIX} [-> flange | -> ft_frame]", "flange"),
    "a palm behind a flange": (f"{SIX} -> flange -> hand [{FINGERS}]", "hand"),
    "parts with a shape": (f"{SIX} [-> bracket* | -> plate*]", "l6"),
}  # fmt: skip

ROVERS = {
    "wheels": (f"base_link [{WHEELS} | -> arm_base R> a1 R> a2 R> a3 R> a4 -> hand [{FINGERS}]]", "arm_base", "hand"),
    "a mount": (f"base_link [{WHEELS} | -> ur_base -> ur_base_inertia R> s R> u R> f -> tool0]", "ur_base", "tool0"),
    "an arm on the chassis itself": (f"chassis [{WHEELS} | R> a1 R> a2 R> a3]", "chassis", "a3"),
    "rockers, a bar and a mast": (
        f"chassis [{ROCKER.format('left')} | {ROCKER.format('right')} | R> diff_bar | R> mast_pan R> mast_tilt -> "
        "mast_tool_link | -> arm/base R> arm/1 R> arm/2 R> arm/3 C> arm/4 R> arm/5 [R> claw_l | R> claw_r]]",
        "arm/base", "arm/5",
    ),
    "a base that floats": (f"world F> body [{WHEELS} | -> arm_base R> a1 R> a2 R> a3 -> ee]", "arm_base", "ee"),
    "legs": (
        "body [" + "".join(f"R> {n}_hip R> {n}_thigh R> {n}_calf -> {n}_foot | " for n in ("fl", "fr", "rl", "rr"))
        + "-> l0 R> l1 R> l2 R> l3 R> l4 R> l5]", "l0", "l5",
    ),
    "a lift with a head": (
        f"foot -> base_link [{WHEELS} | -> column P> lift [R> head_1 R> head_2 -> eye | R> a1 R> a2 R> a3 -> tcp]]",
        "column", "tcp",
    ),
}  # fmt: skip

ASKED = {
    "two arms": ("torso [R> l1 R> l2 -> l_tool0 | R> r1 R> r2 -> r_tool0]", ("l_tool0", "r_tool0")),
    "an arm and a longer one": (
        "t [R> l1 R> l2 R> l3 R> l4 R> l5 R> l6 R> l7 | R> r1 R> r2 R> r3 R> r4]", ("l7", "r4")
    ),
    "two frames": (f"{SIX} [-> a_tcp | -> b_tcp]", ("a_tcp", "b_tcp")),
    "a rod that follows an inner joint": ("base R> l1 R> l2 R> l3 R> l4 [Rm> x | R> l5]", ("x", "l5")),
    "a rover without an arm": (f"base_link [{WHEELS} | -> lidar]", ()),
    "with a camera on a mast": (f"base_link [{WHEELS} | R> pan R> tilt -> camera]", ()),
    "legs": ("body [R> a_hip R> a_knee R> a_foot | R> b_hip R> b_knee R> b_foot]", ()),
    "fingers alone": ("palm [P> left_finger | Pm> right_finger]", ("left_finger", "right_finger")),
}  # fmt: skip


def described(text: str, folder: Path) -> Description:
    return read_description(write(folder, skeleton(text)))


@pytest.mark.parametrize("case", TIPS)
def test_the_tip_is_the_link_that_a_person_would_name(case: str, tmp_path: Path) -> None:
    text, tip = TIPS[case]
    description = described(text, tmp_path)
    choice = choose_ends(description)
    assert (choice.base, choice.tip) == (description.root, tip)
    assert tip not in choice.others


@pytest.mark.parametrize("case", ROVERS)
def test_on_a_rover_the_arm_is_taken_from_its_own_first_link(case: str, tmp_path: Path) -> None:
    text, base, tip = ROVERS[case]
    path = write(tmp_path, skeleton(text))
    arm = load_arm(path)
    assert (arm.base, arm.tip) == (base, tip)
    assert load_arm(path, base=arm.base).tip == tip
    assert load_arm(path, tip=tip, base=base).joint_names == arm.joint_names


@pytest.mark.parametrize("case", ASKED)
def test_what_is_equal_is_asked(case: str, tmp_path: Path) -> None:
    text, equal = ASKED[case]
    with pytest.raises(DescriptionError) as caught:
        choose_ends(described(text, tmp_path))
    (asked,) = caught.value.findings
    assert asked.code == "no-tip"
    assert all(repr(link) in asked.what for link in equal)
    assert not equal or repr(equal[0]) in asked.remedy


def test_what_does_not_turn_against_each_other_is_no_pair_of_fingers(tmp_path: Path) -> None:
    """Two short branches beyond a wrist are fingers only if their axes are parallel."""
    text = skeleton(f"{SIX} [R> l7 | R> l8]")
    assert choose_ends(read_description(write(tmp_path, text))).tip == "l6"
    before, joint, after = text.partition('<joint name="to l8"')
    path = write(tmp_path, before + joint + after.replace('axis xyz="0 0 1"', 'axis xyz="1 0 0"', 1))
    with pytest.raises(DescriptionError) as caught:
        choose_ends(read_description(path))
    assert "'l7'" in caught.value.findings[0].remedy


def test_a_single_jaw_is_known_by_its_joint_too(tmp_path: Path) -> None:
    text = skeleton("base R> l1 R> l2 -> tool0 P> left").replace('"to left"', '"finger"')
    assert choose_ends(read_description(write(tmp_path, text))).tip == "tool0"


def test_with_a_base_the_tip_is_looked_for_beyond_it(tmp_path: Path) -> None:
    description = described("torso [-> l0 R> l1 R> l2 -> l_tcp | -> r0 R> r1 R> r2 -> r_tcp]", tmp_path)
    assert choose_ends(description, "r0").tip == "r_tcp"
    with pytest.raises(DescriptionError):
        choose_ends(description, "torso")


def test_the_choice_is_a_finding_with_the_base_and_the_others(tmp_path: Path) -> None:
    description = described(f"base_link [{WHEELS} | -> arm_base R> a1 R> a2 R> a3 [-> ee | -> tool0 | -> x]]", tmp_path)
    choice = choose_ends(description)
    assert choice.others[:3] == ("ee", "x", "front_left_wheel")
    (found,) = note_choice(description, choice)
    assert (found.code, found.severity, found.place.name) == ("several-tips", "info", "tool0")
    assert all(repr(link) in found.what for link in ("arm_base", *choice.others))


@pytest.mark.parametrize("text", [SIX, f"{SIX} -> tool0", "base R> l1 R> claw"])
def test_without_a_choice_there_is_no_finding(text: str, tmp_path: Path) -> None:
    description = described(text, tmp_path)
    assert note_choice(description, choose_ends(description)) == ()


KINDS = {"R": "revolute", "C": "continuous", "P": "prismatic", "F": "floating", "-": "fixed"}
SHAPE = '<visual><geometry><box size=".1 .1 .1"/></geometry></visual>'


def skeleton(text: str) -> str:
    """The URDF of a description written as one line."""
    links: list[str] = []
    parts: list[str] = []
    forks: list[list[int]] = []  # the link that branches, and which branch this is
    on, kind, master = -1, "", ""
    for token in re.findall(r"[\[\]|]|[RCPF-]m?>|[^\s\[\]|]+", text):
        if token == "[":
            forks.append([on, 0])
        elif token == "|":
            forks[-1][1] += 1
            on = forks[-1][0]
        elif token == "]":
            on = forks.pop()[0]
        elif token.endswith(">"):
            kind = token
        else:
            branch = forks[-1][1] if forks and forks[-1][0] == on else None
            links.append(token)
            if kind:
                parts.append(_joint(links[on], token, kind, branch, master))
                master = master if "m" in kind or kind == "->" else f"to {token.rstrip('*')}"
            on = len(links) - 1
    shaped = robot(*parts, links=tuple(link.rstrip("*") for link in links))
    for link in links:
        name = f'<link name="{link.rstrip("*")}"'
        shaped = shaped.replace(f"{name}/>", f"{name}>{SHAPE}</link>") if link.endswith("*") else shaped
    return shaped


def _joint(parent: str, child: str, kind: str, branch: int | None, master: str) -> str:
    side = 0.0 if branch is None else 0.05 * (-1) ** branch
    axis = f"0 {1 if branch is None else (-1) ** branch} 0" if kind[0] == "P" or branch is None else "0 0 1"
    inside = f'<mimic joint="{master}"/>' if "m" in kind else ""
    inside += "" if KINDS[kind[0]] in ("fixed", "floating") else f'<axis xyz="{axis}"/>'
    if KINDS[kind[0]] in ("revolute", "prismatic"):
        inside += '<limit lower="-1" upper="1" velocity="2" effort="3"/>'
    parent, child = parent.rstrip("*"), child.rstrip("*")
    return joint(f"to {child}", parent, child, KINDS[kind[0]], inside, xyz=f"0.05 {side} 0.2")
