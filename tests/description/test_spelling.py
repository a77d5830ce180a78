"""Words in a joint that no reader takes up: each is said, and nothing is said of other tools' words."""

from __future__ import annotations

from pathlib import Path

import pytest

from twistarm.description.urdf import read_description
from urdf_text import joint, robot, write

UNREAD = {
    '<origin xzy="0 0 1"/>': "xzy= in its <origin> means nothing and is not read (its attributes are 'xyz', 'rpy'",
    '<origin quat_xyzw="0 0 0 1"/>': "quat_xyzw= in 1 <origin> is not read: URDF 1.0 does not have it",
    '<orgin xyz="0 0 1"/>': "its <orgin> means nothing and is not read (correct the name; closest: 'origin')",
    "<axis/>": "its <axis> has no xyz=; taken as 1 0 0",
    '<Axis xyz="0 1 0"/>': "its <Axis> means nothing and is not read",
    '<limit lower="0" upper="1" velocity="1" efort="1"/>': "closest: 'effort'",
    '<child link="upper"/>': "it has 2 <child> elements; only the first is read",
}


@pytest.mark.parametrize("inside", UNREAD)
def test_what_nobody_reads_is_said(inside: str, tmp_path: Path) -> None:
    text = robot(joint("a", "base_link", "upper", inside=inside), joint("b", "upper", "tool0"))
    said = [str(finding) for finding in read_description(write(tmp_path, text)).findings]
    assert any(UNREAD[inside] in line for line in said), said
    assert "arm.urdf:2: joint 'a'" in " ".join(said)


@pytest.mark.parametrize("inside", ['<dynamics damping="1"/>', "<physics/>", '<safety_controller k_velocity="1"/>'])
def test_other_tools_words_are_left_alone(inside: str, tmp_path: Path) -> None:
    text = robot(joint("a", "base_link", "upper", inside=inside), joint("b", "upper", "tool0"))
    assert read_description(write(tmp_path, text)).findings == ()
