"""Design studies: measures of every combination of parameters, and the best compromises."""

from __future__ import annotations

import numpy as np
import pytest

from twistarm import InputError, arm_from_screws, joints, load_arm, sweep


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
