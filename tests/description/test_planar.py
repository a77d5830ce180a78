"""Planar joints of a URDF: their axis honoured, three coordinates each, and what is refused or said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from twistarm import Arm, crosscheck, load_arm, plan_joint
from twistarm.description.urdf import read_description
from twistarm.support.errors import DescriptionError, UnknownNameError
from urdf_text import joint, robot, write

LINKS = ("base_link", "upper", "tool0")


def chain(folder: Path, inside: str = '<axis xyz="0 0 1"/>', *more: str, links: tuple[str, ...] = LINKS) -> Arm:
    """base_link —p→ upper —b→ tool0 with the planar joint p 0.5 m above the base."""
    parts = joint("p", "base_link", "upper", "planar", inside), joint("b", "upper", "tool0"), *more
    return load_arm(write(folder, robot(*parts, links=links)), tip="tool0")


PLANES = {
    "0 0 1": ([1, 0, 0], [0, 1, 0]),
    "0 0 -1": ([1, 0, 0], [0, -1, 0]),
    "0 1 0": ([1, 0, 0], [0, 0, -1]),
    "1 0 0": ([0, 1, 0], [0, 0, 1]),
    "0 3 4": ([1, 0, 0], [0, 0.8, -0.6]),
}
"""In-plane axes by hand: x is (1, 0, 0) where it lies in the plane, y = normal × x."""


@pytest.mark.parametrize("axis", PLANES)
def test_the_axis_is_the_normal(axis: str, tmp_path: Path) -> None:
    arm = chain(tmp_path, f'<axis xyz="{axis}"/>')
    x, y = map(np.array, PLANES[axis])
    assert arm.joint_names == ("p_x", "p_y", "p_rz", "b")
    assert arm.joint_types == ("prismatic", "prismatic", "continuous", "revolute")
    np.testing.assert_allclose(arm.fk([0.3, 0.2, 0, 0])[:3, 3] - arm.home[:3, 3], 0.3 * x + 0.2 * y, atol=1e-15)
    turned = arm.fk([0, 0, 0.7, 0])[:3, :3]
    np.testing.assert_allclose(turned @ np.cross(x, y), np.cross(x, y), atol=1e-15)
    np.testing.assert_allclose(turned @ x, np.cos(0.7) * x + np.sin(0.7) * y, atol=1e-15)
    assert crosscheck(arm, 50).require().worst("pinocchio") <= 1e-12


def test_without_an_axis_the_normal_is_x(tmp_path: Path) -> None:
    """URDF's default axis is (1, 0, 0)."""
    text = robot(joint("p", "base_link", "upper", "planar"), joint("b", "upper", "tool0"), links=LINKS)
    arm = load_arm(write(tmp_path, text.replace('<axis xyz="0 0 1"/>', "", 1)))
    np.testing.assert_allclose(arm.screws[3:, 2], [1, 0, 0], atol=1e-15)


def test_it_is_unbounded_and_nothing_is_missing(tmp_path: Path) -> None:
    arm = chain(tmp_path)
    assert np.isneginf(arm.limits.lower[:3]).all()
    assert np.isposinf(arm.limits.upper[:3]).all()
    assert np.isposinf(arm.limits.velocity[:3]).all()
    assert arm.findings == ()
    motion = plan_joint(arm, [np.zeros(4), np.full(4, 0.1)])
    assert "velocity 0.25 m/s for p_x, p_y" in motion.notes[0]


def test_limits_of_a_planar_joint_are_ignored_and_said(tmp_path: Path) -> None:
    arm = chain(tmp_path, '<axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="2"/>')
    assert np.isinf(arm.limits.upper[:3]).all()
    assert [finding.code for finding in arm.findings] == ["limits-adjusted"]


def test_its_coordinates_take_limits_and_locks(tmp_path: Path) -> None:
    chain(tmp_path)
    arm = load_arm(
        tmp_path / "arm.urdf", limits={"lower": {"p_x": -0.2}, "upper": {"p_x": 0.2}}, locked_joints={"p_y": 0.1}
    )
    assert arm.joint_names == ("p_x", "p_rz", "b")
    assert arm.limits.upper[0] == 0.2
    np.testing.assert_allclose(arm.home[:3, 3], [0, 0.1, 1.0], atol=1e-15)
    with pytest.raises(UnknownNameError) as caught:
        load_arm(tmp_path / "arm.urdf", locked_joints={"p": 0.1})
    assert str(caught.value) == "joint 'p' of tiny is planar; lock its coordinates: 'p_x', 'p_y', 'p_rz'"


def test_the_text_for_other_readers_stays_as_it_was_written(tmp_path: Path) -> None:
    arm = chain(tmp_path)
    assert arm.description is not None
    assert arm.description.text == (tmp_path / "arm.urdf").read_text()
    assert {joint.part_of for joint in arm.description.joints.values()} == {"p", ""}
    left_out = crosscheck(arm, 5).left_out
    assert all("'p'" in left_out[reader] for reader in ("yourdfpy", "pinocchio as written"))


def test_a_coordinates_name_that_is_taken_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match="joint 'p': ") as caught:
        chain(tmp_path, '<axis xyz="0 0 1"/>', joint("p_rz", "upper", "pad"), links=(*LINKS, "pad"))
    assert [finding.code for finding in caught.value.findings] == ["name-unusable"]
    assert "'p_rz'" in str(caught.value)


def test_made_links_are_named_apart_from_those_that_are_there(tmp_path: Path) -> None:
    parts = joint("p", "base_link", "p_x_link", "planar"), joint("q", "p_x_link", "tool0", "planar")
    description = read_description(write(tmp_path, robot(*parts, links=("base_link", "p_x_link", "tool0"))))
    made = ["p_x_link_", "p_y_link", "q_x_link", "q_y_link"]
    assert list(description.links) == ["base_link", "p_x_link", "tool0", *made]
    assert [joint.child for joint in description.chain("base_link", "tool0")] == [
        "p_x_link_", "p_y_link", "p_x_link", "q_x_link", "q_y_link", "tool0",
    ]  # fmt: skip
