"""SRDF and the other files beside a description: what they say, and which are taken."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from catalogue import load
from twistarm import Arm, DescriptionError, InputError, load_arm
from twistarm.description.companions.srdf import arm_groups, read_srdf
from twistarm.description.urdf import ReadOptions, read_description
from urdf_text import joint, robot, two_joints, write

SRDF = """<?xml version="1.0"?>
<robot name="tiny">
  <virtual_joint name="world_joint" type="fixed" parent_frame="world" child_link="base_link"/>
  <group name="arm"><chain base_link="base_link" tip_link="upper"/></group>
  <group name="hand"><joint name="b"/><link name="tool0"/></group>
  <group name="all"><group name="arm"/><group name="hand"/></group>
  <group_state name="home" group="arm"><joint name="a" value="0.5"/><joint name="ball" value="0 0 0 1"/></group_state>
  <end_effector name="gripper" parent_link="upper" group="hand" parent_group="arm"/>
  <passive_joint name="spring"/>
  <disable_collisions link1="upper" link2="base_link" reason="Adjacent"/>
  <disable_default_collisions link="tool0"/>
  <enable_collisions link1="tool0" link2="base_link"/>
  <link_sphere_approximation link="upper"><sphere center="0 0 0" radius="1"/></link_sphere_approximation>
</robot>"""


def test_what_it_says(tmp_path: Path) -> None:
    semantics = read_srdf(write(tmp_path, SRDF, "arm.srdf"))
    assert semantics.name == "tiny"
    assert list(semantics.groups) == ["arm", "hand", "all"]
    assert semantics.groups["arm"].chains == (("base_link", "upper"),)
    assert (semantics.groups["hand"].joints, semantics.groups["hand"].links) == (("b",), ("tool0",))
    assert semantics.groups["all"].subgroups == ("arm", "hand")
    (effector,) = semantics.end_effectors
    assert (effector.name, effector.parent_link, effector.group, effector.parent_group) == (
        "gripper", "upper", "hand", "arm",
    )  # fmt: skip
    (state,) = semantics.states
    assert (state.name, state.group, state.values) == ("home", "arm", {"a": 0.5})
    assert semantics.passive_joints == ("spring",)
    assert semantics.virtual_joints == {"world_joint": ("world", "base_link")}
    assert semantics.disabled == {("base_link", "upper"): "Adjacent"}


def test_pairs_that_need_no_check(tmp_path: Path) -> None:
    """tool0 collides with nothing by default, but for base_link; links that are not there do not count."""
    semantics = read_srdf(write(tmp_path, SRDF, "arm.srdf"))
    assert semantics.disabled_collisions(["base_link", "upper", "tool0", "camera"]) == {
        ("base_link", "upper"), ("tool0", "upper"), ("camera", "tool0"),
    }  # fmt: skip
    assert semantics.disabled_collisions(["upper"]) == frozenset()


def test_xacro_is_expanded_with_the_arguments_it_takes(tmp_path: Path) -> None:
    text = """<robot name="tiny" xmlns:xacro="http://www.ros.org/wiki/xacro">
      <xacro:arg name="name" default="x"/><xacro:arg name="prefix" default=""/>
      <group name="$(arg name)"><joint name="$(arg prefix)a"/></group></robot>"""
    path = write(tmp_path, text, "arm.srdf.xacro")
    semantics = read_srdf(path, ReadOptions(xacro_args={"name": "arm", "prefix": "left_", "ur_type": "ur5e"}))
    assert semantics.groups["arm"].joints == ("left_a",)
    assert read_srdf(path).groups["x"].joints == ("a",)


def tiny(inside: str) -> str:
    return f'<robot name="tiny">\n{inside}</robot>'


REFUSED = {
    "a group without a name": (tiny('<group><joint name="a"/></group>'), "arm.srdf:2: group"),
    "a group twice": (tiny('<group name="g"/><group name="g"/>'), "arm.srdf:2: group 'g'"),
    "another root": ("<sdf/>", "<sdf>"),
    "no name": ("<robot/>", "arm.srdf:1: robot"),
    "a document type": ("<!DOCTYPE r [<!ENTITY a 'b'>]><robot name='t'/>", "<!DOCTYPE r>"),
    "too large": ("<robot name='t'>" + " " * 1_000_000 + "</robot>", "1,000,024 bytes"),
}


def test_of_a_bad_number_only_that_state_is_lost_and_named(tmp_path: Path) -> None:
    state = '<group_state name="{}" group="g"><joint name="a" value="{}"/><joint name="b" value="0"/></group_state>\n'
    text = tiny("".join(state.format(*row) for row in (("home", "0.5"), ("up", "0,5"), ("stowed", "-0.5"))))
    arm = load_arm(write(tmp_path, two_joints()), srdf=write(tmp_path, text, "arm.srdf"))
    assert {name: theta.tolist() for name, theta in arm.named_states.items()} == {
        "home": [0.5, 0.0], "stowed": [-0.5, 0.0],
    }  # fmt: skip
    (noted,) = [finding for finding in arm.findings if finding.code == "companion-doubtful"]
    assert (noted.place.line, noted.place.name) == (3, "up")


@pytest.mark.parametrize("case", REFUSED)
def test_refused_with_its_line(case: str, tmp_path: Path) -> None:
    text, message = REFUSED[case]
    with pytest.raises(DescriptionError) as caught:
        read_srdf(write(tmp_path, text, "arm.srdf"))
    assert message in str(caught.value)
    codes = {"a document type": "xml-malformed", "too large": "file-unreadable"}
    assert [finding.code for finding in caught.value.findings] == [codes.get(case, "companion-unusable")]


@pytest.mark.parametrize("name", ["xarm7", "panda"])
def test_named_states_are_pinocchios_reference_configurations(name: str) -> None:
    import pinocchio

    arm = load(name)
    assert arm.description is not None
    assert arm.description.path is not None
    model = pinocchio.buildModelFromUrdf(str(arm.description.path))
    path = next((arm.description.path.parents[1] / "srdf").glob(f"{name}.srdf"))
    pinocchio.loadReferenceConfigurations(model, str(path), False)
    references = {entry.key(): entry.data() for entry in model.referenceConfigurations}
    assert set(arm.named_states) == set(references)
    for state, theta in arm.named_states.items():
        q = references[state]
        expected = [q[model.joints[model.getJointId(joint)].idx_q] for joint in arm.joint_names]
        assert np.allclose(theta, expected, atol=1e-12)
    written = {(e.get("link1"), e.get("link2")) for e in ET.parse(path).getroot().iter("disable_collisions")}
    links = set(arm.description.links)
    assert arm.disabled_collisions == {tuple(sorted(pair)) for pair in written if set(pair) <= links}
    assert len(arm.disabled_collisions) > 10


# -- which group is the arm ---------------------------------------------------------------------------------------

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
    "a chain has a base": (CHAIN, {"chain": ("upper", "flange")}),
    "a part of another group is none, also as a chain": (ARM + CHAIN, {"arm": (None, "wrist")}),
    "a chain wins over a list of its joints": (
        '<group name="g"><chain base_link="base_link" tip_link="flange"/></group>' + ARM,
        {"g": ("base_link", "flange")},
    ),
    "a hand that lists the arm's last joint is none": (
        '<group name="hand"><joint name="c"/><joint name="left"/></group>' + ARM,
        {"arm": (None, "wrist")},
    ),
    "nor is the arm with its hand": (
        ARM + '<group name="hand"><joint name="left"/></group><group name="all"><joint name="a"/><joint name="b"/>'
        '<joint name="c"/><joint name="left"/></group>' + EFFECTOR.format("wrist", "hand"),
        {"arm": (None, "wrist")},
    ),
    "two arms, by a list and by a chain": (
        '<group name="one"><joint name="left"/></group><group name="two"><chain base_link="flange" '
        'tip_link="right_finger"/></group>',
        {"one": (None, "left_finger"), "two": ("flange", "right_finger")},
    ),
    "an end effector's group is no arm": (
        ARM + '<group name="hand"><joint name="left"/></group>' + EFFECTOR.format("wrist", "hand"),
        {"arm": (None, "wrist")},
    ),
    "what an end effector hangs on wins": (
        '<group name="low"><joint name="a"/></group>' + ARM + HAND + EFFECTOR.format("wrist", "hand"),
        {"arm": (None, "wrist")},
    ),
    "several that could be": (
        ARM + '<group name="hand"><joint name="left"/></group>',
        {"arm": (None, "wrist"), "hand": (None, "left_finger")},
    ),
    "an arm and a hand that also make up a group": (
        ARM + '<group name="hand"><joint name="left"/></group><group name="all"><group name="arm"/><group name="hand"/>'
        "</group>",
        {"arm": (None, "wrist"), "hand": (None, "left_finger")},
    ),
    "groups that hold each other": (
        '<group name="x"><group name="y"/></group><group name="y"><group name="x"/><joint name="a"/></group>',
        {"y": (None, "upper")},
    ),
    "nothing that moves": ('<group name="g"><joint name="flange_joint"/></group>', {}),
    "an end effector that hangs on itself does not count": (
        ARM + '<group name="hand"><joint name="left"/></group>' + EFFECTOR.format("left_finger", "hand"),
        {"arm": (None, "wrist"), "hand": (None, "left_finger")},
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


def test_states_of_a_gripper_are_named_as_left_out(tmp_path: Path) -> None:
    state = '<group_state name="open" group="hand"><joint name="left" value="0.1"/></group_state>'
    arm = load_arm(write(tmp_path, ROBOT), srdf=write(tmp_path, tiny(ARM + HAND + state), "arm.srdf"))
    assert dict(arm.named_states) == {}
    (noted,) = (finding for finding in arm.findings if finding.code == "companion-not-used")
    assert "'open'" in noted.what


STATE = '<group_state name="{}" group="g"><joint name="a" value="0.1"/><joint name="b" value="0.2"/></group_state>'


def srdf(folder: Path, name: str = "tiny", state: str = "home", file: str = "arm.srdf") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    return write(folder, f'<robot name="{name}">{STATE.format(state)}</robot>', file)


def codes(arm: Arm) -> list[str]:
    return [finding.code for finding in arm.findings]


@pytest.fixture
def urdf(tmp_path: Path) -> Path:
    folder = tmp_path / "workspace" / "arm_description" / "urdf"
    folder.mkdir(parents=True)
    return write(folder, two_joints())


PLACES = {
    "in the folder": ".",
    "in config below": "config",
    "in srdf one above": "../srdf",
    "in a MoveIt package beside the description's": "../../arm_moveit_config/config",
    "in a MoveIt package beside the folder": "../arm_moveit_config/config",
}


@pytest.mark.parametrize("place", PLACES)
def test_found_where_packages_keep_it(place: str, urdf: Path) -> None:
    srdf(urdf.parent / PLACES[place])
    arm = load_arm(urdf)
    assert arm.named_states["home"].tolist() == [0.1, 0.2]
    assert codes(arm) == ["srdf-found", "ready-named"]


def test_another_robots_is_left_alone(urdf: Path) -> None:
    srdf(urdf.parent, name="other")
    srdf(urdf.parents[2] / "elsewhere")
    arm = load_arm(urdf)
    assert (codes(arm), dict(arm.named_states)) == ([], {})


def test_of_several_none_is_used_and_that_is_said(urdf: Path) -> None:
    first, second = srdf(urdf.parent), srdf(urdf.parents[1] / "config", state="stowed", file="old.srdf")
    arm = load_arm(urdf)
    assert dict(arm.named_states) == {}
    assert codes(arm) == ["companion-not-used"]
    assert "'arm.srdf', '../config/old.srdf'" in arm.findings[0].what
    assert list(load_arm(urdf, srdf=second).named_states) == ["stowed"]
    assert list(load_arm(urdf, srdf=str(first)).named_states) == ["home"]


def test_a_xacro_is_never_run_unasked(urdf: Path) -> None:
    text = f'<robot name="tiny" xmlns:xacro="http://www.ros.org/wiki/xacro">{STATE.format("home")}</robot>'
    path = write(urdf.parent, text, "arm.srdf.xacro")
    assert dict(load_arm(urdf).named_states) == {}
    assert list(load_arm(urdf, srdf=path).named_states) == ["home"]


def test_one_that_is_named_wins_and_may_be_another_robots(urdf: Path) -> None:
    srdf(urdf.parent)
    other = srdf(urdf.parents[2] / "elsewhere", name="other", state="stowed")
    arm = load_arm(urdf, srdf=other)
    assert list(arm.named_states) == ["stowed"]
    assert codes(arm) == ["companion-doubtful", "srdf-found", "ready-named"]
    assert "'other'" in arm.findings[0].what
    toml = write(urdf.parent, 'source = "arm.urdf"\nsrdf = "../../elsewhere/arm.srdf"', "arm.toml")
    assert list(load_arm(toml).named_states) == ["stowed"]
    assert list(load_arm(toml, srdf=urdf.parent / "arm.srdf").named_states) == ["home"]


def test_what_is_no_file_is_refused(urdf: Path) -> None:
    toml = write(urdf.parent, 'source = "arm.urdf"\nsrdf = "no.srdf"', "arm.toml")
    for source, given in ((urdf, {"srdf": "no.srdf"}), (toml, {})):
        with pytest.raises(DescriptionError, match=r"no\.srdf"):
            load_arm(source, **given)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="srdf must be .* got 3"):
        load_arm(urdf, srdf=3)  # type: ignore[arg-type]


def test_names_that_are_not_there_are_one_warning(urdf: Path) -> None:
    text = (
        '<robot name="tiny"><virtual_joint name="v" parent_frame="odom" child_link="root"/>'
        '<group name="g"><joint name="v"/><joint name="a"/><joint name="elbow"/></group>'
        '<disable_collisions link1="upper" link2="hand"/><disable_collisions link1="upper" link2="base_link"/></robot>'
    )
    arm = load_arm(urdf, srdf=write(urdf.parent, text, "arm.srdf"))
    assert arm.disabled_collisions == {("base_link", "upper")}
    (finding,) = [finding for finding in arm.findings if finding.code == "companion-doubtful"]
    assert "'elbow', 'root', 'hand'" in finding.what
