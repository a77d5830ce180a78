"""Which group of an SRDF is the arm: the choice by hand on one small robot."""

from __future__ import annotations

from pathlib import Path

import pytest

from twistarm import DescriptionError, load_arm
from twistarm.description.companions.arm_group import arm_groups
from twistarm.description.companions.srdf import read_srdf
from twistarm.description.urdf import read_description
from urdf_text import joint, robot, write

LINKS = ("base_link", "upper", "fore", "wrist", "flange", "camera", "left_finger", "right_finger")
ROBOT = robot(
    joint("a", "base_link", "upper"),
    joint("b", "upper", "fore"),
    joint("c", "fore", "wrist"),
    joint("flange_joint", "wrist", "flange", kind="fixed"),
    joint("camera_joint", "wrist", "camera", kind="fixed"),
    joint("left", "flange", "left_finger"),
    joint("right", "flange", "right_finger"),
    links=LINKS,
)
ARM = '<group name="arm"><joint name="a"/><joint name="b"/><joint name="c"/></group>'
HAND = '<group name="hand"><joint name="left"/><joint name="right"/></group>'
CHAIN = '<group name="chain"><chain base_link="upper" tip_link="flange"/></group>'
EFFECTOR = '<end_effector name="grip" parent_link="{}" group="{}"/>'

CHOICE = {
    "a list of joints ends at the last one's link": (ARM, {"arm": (None, "wrist")}),
    "fixed joints beyond it lead on": (
        '<group name="arm"><joint name="c"/><joint name="flange_joint"/><joint name="a"/><link name="fore"/></group>',
        {"arm": (None, "flange")},
    ),
    "unless they branch": (
        '<group name="arm"><joint name="c"/><link name="flange"/><link name="camera"/></group>',
        {"arm": (None, "wrist")},
    ),
    "a chain has a base": (CHAIN, {"chain": ("upper", "flange")}),
    "a chain wins over a list": (ARM + CHAIN, {"chain": ("upper", "flange")}),
    "an end effector's group is no arm": (
        ARM + '<group name="hand"><joint name="left"/></group>' + EFFECTOR.format("wrist", "hand"),
        {"arm": (None, "wrist")},
    ),
    "what an end effector hangs on wins": (
        '<group name="low"><joint name="a"/></group>' + ARM + HAND + EFFECTOR.format("wrist", "hand"),
        {"arm": (None, "wrist")},
    ),
    "several that could be": (
        '<group name="low"><joint name="a"/></group>' + ARM,
        {"low": (None, "upper"), "arm": (None, "wrist")},
    ),
    "groups that hold each other": (
        '<group name="x"><group name="y"/></group><group name="y"><group name="x"/><joint name="a"/></group>',
        {"y": (None, "upper")},
    ),
    "nothing that moves": ('<group name="g"><joint name="flange_joint"/></group>', {}),
    "unless it does not hang on what it should": (
        ARM + '<group name="hand"><joint name="left"/></group>' + EFFECTOR.format("left_finger", "hand"),
        {"hand": (None, "left_finger")},
    ),
    "a chain the wrong way": ('<group name="g"><chain base_link="flange" tip_link="upper"/></group>', {}),
    "a chain to nowhere": ('<group name="g"><chain base_link="base_link" tip_link="tool9"/></group>', {}),
}


@pytest.mark.parametrize("case", CHOICE)
def test_the_arm_among_the_groups(case: str, tmp_path: Path) -> None:
    groups, expected = CHOICE[case]
    description = read_description(write(tmp_path, ROBOT))
    semantics = read_srdf(write(tmp_path, f'<robot name="tiny">{groups}</robot>', "arm.srdf"))
    assert {group.name: (group.base, group.tip) for group in arm_groups(semantics, description)} == expected


def test_base_and_tip_come_from_the_group_where_nobody_says_otherwise(tmp_path: Path) -> None:
    path = write(tmp_path, ROBOT)
    assert (load_arm(path).base, load_arm(path).tip) == ("base_link", "flange"), "chosen, where nobody says"
    write(tmp_path, f'<robot name="tiny">{CHAIN}</robot>', "arm.srdf")
    arm = load_arm(path)
    assert (arm.base, arm.tip, arm.joint_names) == ("upper", "flange", ("b", "c"))
    # The chain's base belongs to the chain's tip: another tip starts at the root again.
    arm = load_arm(path, tip="camera")
    assert (arm.base, arm.joint_names) == ("base_link", ("a", "b", "c"))
    assert load_arm(path, base="base_link").joint_names == ("a", "b", "c")
    toml = write(tmp_path, 'source = "arm.urdf"\ntip = "wrist"', "arm.toml")
    assert (load_arm(toml).base, load_arm(toml).tip) == ("base_link", "wrist")


def test_several_groups_are_offered_in_the_error(tmp_path: Path) -> None:
    two = "".join(f'<group name="{name}"><joint name="{name}"/></group>' for name in "bc")
    write(tmp_path, f'<robot name="tiny">{two}</robot>', "arm.srdf")
    parts = joint("a", "base_link", "torso"), joint("b", "torso", "left"), joint("c", "torso", "right")
    with pytest.raises(DescriptionError) as caught:
        load_arm(write(tmp_path, robot(*parts, links=("base_link", "torso", "left", "right"))))
    assert str(caught.value).endswith("so could the groups of its SRDF: 'b' (left), 'c' (right); pass tip='left'")
    assert [finding.code for finding in caught.value.findings] == ["no-tip"]
