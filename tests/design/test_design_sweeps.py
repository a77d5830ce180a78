"""Design studies: measures of every combination of parameters, and designs side by side."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import twistarm
from catalogue import load
from twistarm import Position, arm_from_screws, compare_designs, joints, load_arm, sweep
from twistarm.arm.engine import MOST_JOINTS
from twistarm.support.errors import InputError


def two_links(upper, fore):
    """In a plane, tool at (upper + fore, 0, 0)."""
    home = np.eye(4)
    home[0, 3] = upper + fore
    return arm_from_screws(np.hstack([joints.revolute([0, 0, 1], point) for point in ([0, 0, 0], [upper, 0, 0])]), home)


def ring(arm):
    """Area between the circles that the tool can reach, and the length of the links."""
    inner = np.linalg.norm(arm.fk([0.0, np.pi])[:2, 3])
    outer = np.linalg.norm(arm.fk([0.0, 0.0])[:2, 3])
    return {"area": np.pi * (outer**2 - inner**2), "length": arm.reach}


PARAMETERS = {"upper": np.linspace(0.2, 0.4, 3), "fore": [0.1, 0.3]}


def test_each_combination_in_order():
    table = sweep(two_links, PARAMETERS, ring)
    upper, fore = table.column("upper"), table.column("fore")
    assert np.allclose(np.column_stack([upper, fore]), [(u, f) for u in (0.2, 0.3, 0.4) for f in (0.1, 0.3)])
    assert table.column("area") == pytest.approx(4 * np.pi * upper * fore)
    assert table.column("length") == pytest.approx(upper + fore)


def test_the_front_of_pareto():
    front = sweep(two_links, PARAMETERS, ring).pareto(most=["area"], least=["length"])
    found = {(round(row["upper"], 1), row["fore"]) for row in front.rows}
    # By length 0.3, 0.4, 0.5 (twice), 0.6, 0.7 and upper · fore 0.02, 0.03, 0.04 or 0.06, 0.09, 0.12.
    assert found == {(0.2, 0.1), (0.3, 0.1), (0.2, 0.3), (0.3, 0.3), (0.4, 0.3)}
    with pytest.raises(InputError):
        front.pareto()
    with pytest.raises(InputError, match="area"):
        front.pareto(most=["aera"])


def test_named_arms_and_those_of_a_xacro_file(rover, tmp_path):
    text = (
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="l" default="1"/>'
        '<link name="base"/><link name="tool"/><joint name="a" type="revolute"><parent link="base"/>'
        '<child link="tool"/><origin xyz="$(arg l) 0 0"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>'
    )
    (tmp_path / "arm.xacro").write_text(text)

    def height(arm):
        return {"x": arm.home[0, 3]}

    assert sweep(tmp_path / "arm.xacro", {"l": [0.5, 2]}, height).column("x") == pytest.approx([0.5, 2.0])
    named = sweep({"five": rover, "six": load_arm("rover_arm_6dof")}, None, lambda arm: {"n": arm.n})
    assert [(row["arm"], row["n"]) for row in named.rows] == [("five", 5), ("six", 6)]


def test_a_design_without_an_arm_says_why_and_the_others_go_on(tmp_path):
    def make(upper):
        return two_links(upper, 0.3 if upper < 0.3 else np.nan)

    table = sweep(make, {"upper": [0.2, 0.3]}, ring, folder=tmp_path)
    assert np.isnan(table.column("area")).tolist() == [False, True]
    assert [bool(row.get("error")) for row in table.rows] == [False, True]
    again = sweep(make, {"upper": [0.2, 0.3]}, ring, folder=tmp_path)
    assert repr(again.rows) == repr(table.rows)
    assert len(table.pareto(most=["area"]).rows) == 1


def test_a_function_that_fails_is_told_with_its_design():
    with pytest.raises(InputError, match=r"upper.*0.2.*ZeroDivisionError"):
        sweep(two_links, PARAMETERS, lambda arm: {"ratio": 1 / 0}, workers=1)


@pytest.mark.parametrize(
    "arguments",
    [(two_links, None, ring), (two_links, {"upper": 3}, ring), (two_links, {"upper": []}, ring), (3, {}, ring),
     (two_links, PARAMETERS, 7), ({"a": 1}, None, ring),
     (two_links, dict.fromkeys(("upper", "fore"), range(2000)), ring)],
)  # fmt: skip
def test_unusable_arguments(arguments):
    with pytest.raises(InputError) as said:
        sweep(*arguments)
    assert "\n" not in str(said.value)


def elbow(scale: float) -> twistarm.Arm:
    """A shoulder that turns about z and y, and an elbow: its tool fills a ball."""
    home = np.eye(4)
    home[0, 3] = scale
    axes = [([0, 0, 1], 0.0), ([0, 1, 0], 0.0), ([0, 1, 0], 0.5 * scale)]
    return arm_from_screws(np.hstack([joints.revolute(axis, [x, 0, 0]) for axis, x in axes]), home)


def test_a_larger_arm_reaches_farther_and_sweeps_the_cube_of_it() -> None:
    small, large = compare_designs([elbow(1.0), elbow(1.2)])
    assert np.isclose(small.farthest, 1.0, rtol=1e-5)
    assert np.isclose(large.farthest, 1.2, rtol=1e-5)
    assert np.isclose(large.volume, 4 / 3 * np.pi * 1.2**3, rtol=0.01)
    assert np.isclose(small.volume, 4 / 3 * np.pi, rtol=0.01)
    assert np.isclose(small.condition, large.condition)
    ours = elbow(1.0)
    measured = ours.manipulability(ours.random_theta(1, 4000))
    assert np.isclose(small.condition, np.median(measured.condition), rtol=0.05)
    assert small.singular == large.singular
    assert np.isnan(small.payload)
    assert any("no Pinocchio model" in note for note in small.notes)
    assert small.name != large.name


def test_weaker_and_slower_joints(rover: twistarm.Arm) -> None:
    limits = {"effort": 0.5 * rover.limits.effort, "velocity": 0.5 * rover.limits.velocity}
    weak = replace(rover, name="weak", limits=rover.limits.with_(limits, rover.joint_names))
    near, far = ([0.8, 0.1, 0.7], [0.8, -0.3, 0.5])
    strong, other = compare_designs([rover, weak], [Position(p) for p in (near, far, near)])
    assert strong.mass == other.mass
    assert strong.volume == other.volume
    # Half the torque holds less than half, because the arm carries itself too.
    assert other.payload < 0.5 * strong.payload
    assert other.median_payload < 0.5 * strong.median_payload
    assert other.duration > strong.duration
    beyond = compare_designs([rover, weak], [Position(near), Position([3.0, 0, 0])])
    assert np.isnan(beyond[0].duration)
    assert any("no motion: " in note for note in beyond[0].notes)


@pytest.mark.parametrize("sides", [(0.3, 1.7, 0.9), (1.0, 1.0, 0.2)])
def test_slides_sweep_their_box(sides) -> None:
    """Its faces lie between the centres of cubes."""
    names = ["a", "b", "c"]
    limits = {"lower": dict.fromkeys(names, 0.0), "upper": dict(zip(names, sides, strict=True))}
    screws = np.hstack([joints.prismatic(axis) for axis in np.eye(3)])
    box, flat = compare_designs([arm_from_screws(screws, np.eye(4), joints=names, limits=limits), load("rr_planar")])
    assert np.isclose(box.volume, np.prod(sides), rtol=0.03)
    assert np.isclose(box.farthest, np.linalg.norm(sides), rtol=1e-4)
    assert flat.volume == 0.0


def test_an_arm_beyond_the_core_has_no_volume() -> None:
    axes = [joints.revolute(np.eye(3)[i % 3], [0.02 * i, 0, 0]) for i in range(MOST_JOINTS + 1)]
    long, _ = compare_designs([arm_from_screws(np.hstack(axes), np.eye(4)), elbow(1.0)])
    assert np.isnan(long.volume)
    assert long.farthest > 0.0
    assert any("no volume: " in note for note in long.notes)


@pytest.mark.parametrize(
    ("arms", "poses"), [([], ()), (None, ()), (["rover_arm"] * 2, ()), ([elbow(1.0)] * 2, [np.eye(4)])]
)
def test_wrong_arguments(arms, poses) -> None:
    with pytest.raises(InputError):
        compare_designs(arms, poses)
