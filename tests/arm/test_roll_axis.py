"""The axis about which an arm's last joint rolls its tool: found, turned outward, and what an Approach points."""

from __future__ import annotations

import numpy as np
import pytest

from catalogue import load
from twistarm import Approach, Arm, ArmBuilder, InputError, arm_from_screws, rotations, solve_ik, solve_ik_batch

# A tool frame that stands askew.
TOOL = np.block([[rotations.from_rpy([0.3, -0.8, 1.1]), np.zeros((3, 1))], [np.zeros(3), 1.0]])


def tool(x: float, y: float, z: float) -> np.ndarray:
    g = TOOL.copy()
    g[:3, 3] = x, y, z
    return g


def wrist(*joints: tuple[list[float], list[float]], at: np.ndarray) -> Arm:
    """An arm that turns and reaches, and then has these joints (axis, point)."""
    builder = ArmBuilder("made").revolute("turn", [0, 0, 1], [0, 0, 0]).revolute("shoulder", [0, 1, 0], [0, 0, 0.3])
    for k, (axis, point) in enumerate(joints):
        builder = builder.revolute(f"wrist_{k}", axis, point)
    return builder.tool(at).build()


PITCH, ROLL = ([0, 1, 0], [0.6, 0, 0.3]), ([1, 0, 0], [0, 0, 0.3])
BACK = ([-1, 0, 0], [0, 0, 0.3])


@pytest.mark.parametrize(
    ("joints", "at", "pointed"),
    [
        ((PITCH, ROLL), (0.8, 0, 0.3), [1, 0, 0]),  # outward, whichever way the joint turns
        ((PITCH, BACK), (0.8, 0, 0.3), [1, 0, 0]),
        ((PITCH, ROLL), (0.5, 0, 0.3), [-1, 0, 0]),  # the tool looks back
        ((PITCH, ROLL), (0.8, 0.05, 0.3), [1, 0, 0]),  # beside the axis, as a finger is
        ((PITCH, ROLL), (0.6, 0, 0.3), None),  # at the wrist: neither way is outward
        ((PITCH,), (0.8, 0, 0.3), "z"),  # a wrist that pitches rolls nothing
        ((ROLL, PITCH), (0.8, 0, 0.3), "z"),
        ((), (0.6, 0, 0.3), "z"),
    ],
)
def test_the_axis_is_the_roll_outward(joints, at, pointed):
    """Expected in base axes at rest, as the wrist was drawn."""
    axis = wrist(*joints, at=tool(*at)).tool_axis
    if pointed == "z":
        assert np.array_equal(axis, [0, 0, 1])
    elif pointed is None:
        in_tool = TOOL[:3, :3].T @ [1, 0, 0]
        decisive = next(value for value in in_tool[[2, 0, 1]] if abs(value) >= 0.5)
        np.testing.assert_allclose(axis, np.sign(decisive) * in_tool, atol=1e-9)
    else:
        np.testing.assert_allclose(TOOL[:3, :3] @ axis, pointed, atol=1e-9)


def test_the_roll_leaves_it_where_it_points(catalogue_arm: Arm) -> None:
    """By finite turns of the last coordinate that turns; arms whose last joint is no roll point z."""
    arm, axis = catalogue_arm, catalogue_arm.tool_axis
    assert np.linalg.norm(axis) == pytest.approx(1, abs=1e-11)
    last = max(i for i, unit in enumerate(arm.units) if unit == "rad")
    theta = arm.random_theta(3)
    turned = theta + 0.7 * np.eye(arm.n)[last]
    before, after = arm.fk(theta), arm.fk(turned)
    moved = (after @ np.linalg.inv(before))[:3, :3]
    about = rotations.log(moved)
    along = np.linalg.norm(np.cross(about / 0.7, before[:3, :3] @ axis))
    assert along < 1e-9 or np.array_equal(axis, [0, 0, 1])
    if arm.n >= 5:  # each of them ends in a roll
        assert along < 1e-9


@pytest.mark.parametrize(
    ("name", "axis"), [("panda", [0, 0, 1]), ("ur5", [0, 0, 1]), ("so100", [0, -1, 0]), ("z1", [1, 0, 0])]
)
def test_axes_of_known_tools(name, axis):
    """As their makers draw them: so100's jaws stand out along −y of its gripper, z1's along x."""
    np.testing.assert_allclose(load(name).tool_axis, axis, atol=1e-3)


def test_an_approach_points_the_arms_own_axis():
    arm = load("z1")
    g = arm.fk(arm.random_theta(5))
    asked = Approach(g[:3, 3].tolist(), g[:3, 0].tolist())
    for solution in (solve_ik(arm, asked), solve_ik_batch(arm, [asked])[0]):
        theta = solution.require()
        np.testing.assert_allclose(arm.fk(theta)[:3, 0], g[:3, 0], atol=2e-6)
        assert np.array_equal(solution.target.tool_axis, arm.tool_axis)
        assert "with the tool pointing its x axis along" in solution.explain()
    given = solve_ik(arm, Approach(g[:3, 3], g[:3, 2], [0, 0, 1]))
    np.testing.assert_allclose(arm.fk(given.require())[:3, 2], g[:3, 2], atol=2e-6)


def test_an_approach_without_an_arm_has_no_axis():
    with pytest.raises(InputError, match=r"its tool axis to the arm: ask approach.of\(arm\), or give tool_axis="):
        Approach([1, 0, 0], [0, 0, 1]).orientation_error(np.eye(4))


def test_an_arm_that_only_slides_points_z():
    slides = np.array([[1.0, 0, 0, 0, 0, 0], [0, 1.0, 0, 0, 0, 0]]).T
    assert np.array_equal(arm_from_screws(slides, np.eye(4)).tool_axis, [0, 0, 1])
