"""The doctor's findings, gravest first, for real arms too, without false alarms; what it says that an arm can do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import twistarm
from finding_cases import CASES, chain
from test_finding_codes import codes, lay
from twistarm import Approach, Arm, ArmBuilder, InputError, UnknownNameError, diagnose, load_arm, solve_ik
from twistarm.arm.abilities import abilities_of
from twistarm.checking.doctor import examine
from urdf_text import joint, robot, two_joints, write

WARNED = {"kinova", "so100"}  # Of one a state of its SRDF lies outside the limits; the other has no tool frame.


@pytest.mark.parametrize("name", twistarm.available_arms())
def test_no_false_alarm_about_the_catalogue(name: str) -> None:
    findings = diagnose(name)
    assert all(one.severity != "error" for one in findings)
    assert (name in WARNED) == any(one.severity == "warning" for one in findings)
    assert len(findings) <= 6


def test_an_arm_is_taken_too(rover: Arm, tmp_path: Path) -> None:
    assert codes(rover) == codes("rover_arm")
    with pytest.raises(InputError, match="an Arm is loaded already and takes no tip"):
        diagnose(rover, tip="tool0")


def test_arguments_raise_where_arm_toml_is_diagnosed(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="no arm 'rover_amr' in the catalogue"):
        diagnose("rover_amr")
    path = write(tmp_path, two_joints())
    with pytest.raises(UnknownNameError, match="tip='tool' is no link of"):
        diagnose(path, tip="tool")
    write(tmp_path, 'source = "arm.urdf"\ntip = "tool"\n', "arm.toml")
    (said,) = [one for one in diagnose(tmp_path / "arm.toml") if one.severity == "error"]
    assert said.code == "companion-unusable"
    assert "closest: 'tool0'" in said.what


def test_a_tool_given_in_the_arm_toml_is_a_tool(tmp_path: Path) -> None:
    assert "tool-frame-missing" not in codes(write(tmp_path, two_joints()))
    path = write(tmp_path, two_joints().replace("tool0", "flange"))
    (said,) = [one for one in diagnose(path) if one.code == "tool-frame-missing"]
    _, _, snippet = said.remedy.partition("\n")
    write(tmp_path, f'source = "arm.urdf"\n{snippet}\n', "arm.toml")
    assert "tool-frame-missing" not in codes(tmp_path / "arm.toml")


@pytest.mark.parametrize(("z", "end"), [(-0.02, "-0.04"), (0.02, "0.04"), (0.001, "0.1")])
def test_the_tool_is_put_at_the_end_of_the_last_links_shapes(z: float, end: str, tmp_path: Path) -> None:
    body = f'<visual><origin xyz="0 0 {z}"/><geometry><cylinder radius="0.02" length="0.04"/></geometry></visual>'
    text = (
        two_joints().replace("tool0", "flange").replace('<link name="flange"/>', f'<link name="flange">{body}</link>')
    )
    (said,) = [one for one in diagnose(write(tmp_path, text)) if one.code == "tool-frame-missing"]
    assert f"{end}]" in said.remedy


def test_a_slide_at_the_end_has_its_tool(tmp_path: Path) -> None:
    """Its frame moves along the axis, not on it: where the arm grips is no less said than with a tool."""
    for kind, told in ("revolute", True), ("prismatic", False):
        parts = joint("a", "base_link", "upper"), joint("b", "upper", "flange", kind)
        path = write(tmp_path, robot(*parts, links=("base_link", "upper", "flange")))
        assert ("tool-frame-missing" in codes(path)) == told


def test_other_ends_are_told_only_where_nobody_said_which(tmp_path: Path) -> None:
    path = lay(CASES["several-tips"], tmp_path)
    assert "several-tips" in codes(path)
    assert "several-tips" not in codes(path, tip="tool0")
    assert examine(path, tip="tool0").arm is not None


# -- real arms -----------------------------------------------------------------------------------------------------

REAL = {
    "robojackets_slider_arm/cartesian_controller_simulation/urdf/arm_gazebo.urdf.xacro": (
        {}, {"home-singular", "cannot-turn-in-place", "several-tips"}
    ),
    "robojackets_walliiarmv3/urc_gazebo/urdf/WalliiArmV3.urdf": (
        {},
        {"mesh-missing", "rate-not-given", "outside-limits", "tool-frame-missing"},
    ),
    "robojackets_walli_v2_block/urdf/walli_arm_v2_block/robot.urdf": (
        {}, {"limit-incomplete", "mass-missing", "axes-almost-exact", "home-singular", "cannot-turn-in-place"}
    ),
    "so101/so101_new_calib.urdf": ({}, {"mesh-missing", "cannot-turn-in-place", "off-the-chain", "several-tips"}),
    "kortex_description/robots/gen3.xacro": ({"xacro_args": {"dof": 7}}, {"mesh-missing", "axes-almost-exact"}),
    "robojackets_walliiarmv3/urc_arm_moveit_config/config/WalliiArmV3.urdf.xacro": ({}, {"package-without-manifest"}),
    "kortex_description/robots/kinova.urdf.xacro": (
        {
            "xacro_args": {"name": "gen3", "arm": "gen3", "gripper": "robotiq_2f_85"},
            "ignore_packages": "robotiq_description",
        },
        {"package-left-out"},
    ),
}  # fmt: skip
REFUSED = {
    "kortex_description/robots/gen3_lite_gen3_lite_2f.xacro": ({}, "xacro-failed", 'Invalid parameter "gripper"'),
    "kortex_description/robots/gen3.xacro": ({}, "xacro-failed", "arms/gen3/dof/"),
    "annin_ar4_description/urdf/ar.urdf.xacro": ({}, "xacro-arguments", "ar_model"),
    "annin_ar4_description/urdf/ar_gazebo.urdf.xacro": (
        {"xacro_args": {"ar_model": "mk3"}}, "package-needed-not-found", "annin_ar4_driver"
    ),
}  # fmt: skip


@pytest.mark.parametrize("file", REAL)
def test_real_arms_get_a_page_without_errors(file: str, models: Path) -> None:
    load, expected = REAL[file]
    findings = diagnose(models / file, **load)  # type: ignore[arg-type]
    assert expected <= {one.code for one in findings}
    assert not [one for one in findings if one.severity == "error"]


@pytest.mark.parametrize("file", REFUSED)
def test_real_descriptions_that_fail_get_the_error_that_says_why(file: str, models: Path) -> None:
    load, code, words = REFUSED[file]
    first = diagnose(models / file, **load)[0]  # type: ignore[arg-type]
    assert (first.code, first.severity) == (code, "error")
    assert words in first.what


STEP = 1e-5
NONE = 2e-3  # Less than this [m/reach per rad, rad per rad] is no motion: the doctor looks at a thousandth.


def differences(arm: Arm, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Velocity of the tool's origin (in reaches) and angular velocity in base axes, (3, n) each, and R."""
    scale = np.where(np.array(arm.units) == "m", arm.reach, 1.0)
    linear, angular = np.empty((3, arm.n)), np.empty((3, arm.n))
    for i, step in enumerate(np.diag(STEP * scale)):
        plus, minus = arm.fk(theta + step), arm.fk(theta - step)
        linear[:, i] = (plus - minus)[:3, 3] / (2 * STEP * arm.reach)
        turn = (plus[:3, :3] @ minus[:3, :3].T) / (2 * STEP)
        angular[:, i] = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    return linear, angular, arm.fk(theta)[:3, :3]


def require_true(arm: Arm) -> None:
    """Ranks and directions hold at postures that the doctor has not looked at."""
    said = abilities_of(arm)
    postures = arm.random_theta(np.random.default_rng(99), 10)
    positions, turnings = [], []
    for theta in postures:
        linear, angular, R = differences(arm, theta)
        assert np.abs(said.immovable @ linear).max(initial=0.0) < NONE
        assert np.abs(said.unrotated @ angular).max(initial=0.0) < NONE
        _, sizes, Vt = np.linalg.svd(linear)
        positions.append(int((sizes > NONE).sum()))
        held = angular @ Vt[said.position :].T
        U, sizes, _ = np.linalg.svd(held)
        turnings.append(int((sizes > NONE).sum()))
        free = U[:, : said.turning]
        for axes in (said.rotated_base, said.rotated_tool @ R.T):
            assert np.abs(axes - axes @ free @ free.T).max(initial=0.0) < NONE
    assert max(positions) == said.position
    assert max(turnings) == said.turning


def test_statements_about_the_catalogue_are_true(catalogue_arm: Arm) -> None:
    require_true(catalogue_arm)


def test_no_more_directions_than_joints() -> None:
    """The tool is up to 4 cm beside the plane in which the elbow bends: its third direction is a weak one."""
    screws = np.array([[0, 0, 0, 0, 0, -1], [-0.3, 0, 0.4, 0, 1, 0], [0, 1, 0, 0, 0, 0]], dtype=float).T
    limits = {"lower": [-1.5, 0.1, 0.0], "upper": [1.5, 2.6, 0.04]}
    home = [[1, 0, 0, 0.7], [0, 1, 0, 0], [0, 0, 1, 0.3], [0, 0, 0, 1]]
    assert not {"error"} & {one.severity for one in diagnose(twistarm.arm_from_screws(screws, home, limits=limits))}


def back(master: str) -> str:
    return f'<axis xyz="0 1 0"/><mimic joint="{master}" multiplier="-1"/>'


PALLETISER = robot(
    joint("yaw", "base_link", "column", xyz="0 0 0.3"),
    joint("shoulder", "column", "upper", inside='<axis xyz="0 1 0"/>', xyz="0 0 0.1"),
    joint("elbow", "upper", "fore", inside='<axis xyz="0 1 0"/>', xyz="0.5 0 0"),
    joint("un_elbow", "fore", "half", inside=back("elbow"), xyz="0.5 0 0"),
    joint("un_shoulder", "half", "level", inside=back("shoulder"), xyz="0 0 0"),
    joint("roll", "level", "tool0", xyz="0.1 0 0"),
    links=("base_link", "column", "upper", "fore", "half", "level", "tool0"),
)  # fmt: skip

X, Y, Z = ("the base's x axis", "the base's y axis", "the base's z axis")

ARMS = {
    "gantry": (chain("1 0 0", "0 1 0", "0 0 1", kind="prismatic"), {"cannot-turn": (X, Y, Z)}),
    "roll on the spot": (chain("0 0 1"), {"cannot-move": (X, Y, Z), "cannot-turn": (X, Y)}),
    "lever": (chain("0 1 0"), {"cannot-move": (Y,), "cannot-turn": (X, Z), "cannot-turn-in-place": ()}),
    "pan and tilt": (chain("0 0 1", "0 1 0"), {"cannot-move": (), "cannot-turn-in-place": ()}),
    "yaw, pitches, roll": (
        chain("0 0 1", "0 1 0", "0 1 0", "0 1 0", "0 0 1"), {"cannot-turn-in-place": ("its z axis",)}
    ),
    "palletiser": (PALLETISER, {"cannot-turn": (X, Y)}),
    "six": (chain("0 0 1", "0 1 0", "0 1 0", "0 0 1", "0 1 0", "0 0 1"), {}),
}  # fmt: skip
"""What they cannot do, and the axes that the finding names."""


@pytest.mark.parametrize("name", ARMS)
def test_what_an_arm_cannot_do(name: str, tmp_path: Path) -> None:
    text, expected = ARMS[name]
    path = write(tmp_path, text)
    require_true(load_arm(path))
    said = {one.code: one.what for one in diagnose(path) if one.code.startswith("cannot-")}
    assert said.keys() == expected.keys()
    for code, axes in expected.items():
        assert [axis for axis in (X, Y, Z, "its z axis") if axis in said[code]] == list(axes)


def test_where_an_approach_can_be_asked_for_it_can_be_met() -> None:
    """A forearm that rolls and a wrist that pitches point the tool's z axis, drawn outward, any way near by."""
    home = np.array([[0, 0, 1.0, 0.8], [0, 1, 0, 0], [-1, 0, 0, 0.3], [0, 0, 0, 1]])
    builder = ArmBuilder("made").revolute("turn", [0, 0, 1], [0, 0, 0]).revolute("shoulder", [0, 1, 0], [0, 0, 0.3])
    builder = builder.revolute("elbow", [0, 1, 0], [0.3, 0, 0.3]).revolute("roll", [1, 0, 0], [0, 0, 0.3])
    arm = builder.revolute("pitch", [0, 1, 0], [0.6, 0, 0.3]).tool(home).build()
    (said,) = [one for one in diagnose(arm) if one.code == "cannot-turn-in-place"]
    assert "Approach" in said.remedy
    assert "its z axis" in said.remedy
    g = arm.fk([0.2, 0.3, 0.8, 0.5, 0.6])
    for turn in ((0.03, 0.0), (0.0, 0.03), (-0.03, 0.03)):
        direction = g[:3, 2] + turn[0] * g[:3, 0] + turn[1] * g[:3, 1]
        assert solve_ik(arm, Approach(g[:3, 3], direction), [0.2, 0.3, 0.8, 0.5, 0.6]).converged
