"""The doctor's findings: their numbers from elsewhere, their places, remedies that work, and no false alarms."""

from __future__ import annotations

import math
import re
import sys
from pathlib import Path

import numpy as np
import pinocchio
import pytest

import twistarm
import twistarm.doctor.meshes
from finding_cases import CASES, POINTER, Case, chain, triangle, with_body, with_mesh
from test_finding_codes import found, lay
from twistarm import Arm, InputError, UnknownNameError, arm_from_screws, diagnose, load_arm
from twistarm.description.findings import Finding
from twistarm.doctor import examine
from twistarm.doctor.postures import recommended
from twistarm.doctor.wording import toml_table
from urdf_text import joint, robot, two_joints, write

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

WARNED = {"kinova", "so100"}
"""Of one a state of its SRDF lies outside the limits; the other has no tool frame."""


def codes(source: object, **load: object) -> list[str]:
    return [one.code for one in diagnose(source, **load)]  # type: ignore[arg-type]


def only(case: Case, folder: Path, code: str) -> Finding:
    (one,) = [one for one in found(case, folder) if one.code == code]
    return one


# -- the whole -----------------------------------------------------------------------------------------------------


def test_the_gravest_come_first(tmp_path: Path) -> None:
    bad = '<limit lower="-170" upper="170" velocity="0" effort="0"/>'
    findings = diagnose(write(tmp_path, two_joints(inside=bad)))
    severities = [one.severity for one in findings]
    assert severities == sorted(severities, key=("error", "warning", "info").index)
    assert len(set(severities)) == 2


@pytest.mark.parametrize("name", twistarm.available_arms())
def test_no_false_alarm_about_the_catalogue(name: str) -> None:
    findings = diagnose(name)
    assert all(one.severity != "error" for one in findings)
    assert (name in WARNED) == any(one.severity == "warning" for one in findings)
    assert len(findings) <= 6


def test_a_refused_description_is_looked_at_all_the_same(tmp_path: Path) -> None:
    bad = '<limit lower="-170" upper="170" velocity="1" effort="1"/>'
    text = two_joints(inside=bad).replace("tool0", "gripper")
    findings = diagnose(write(tmp_path, text))
    assert [one.code for one in findings] == ["no-tip", "limits-look-like-degrees"]


def test_every_error_is_told_at_once(tmp_path: Path) -> None:
    text = two_joints(inside='<axis xyz="0 0 0"/>').replace('lower="-1"', 'lower="one"')
    findings = diagnose(write(tmp_path, text))
    assert [(one.code, one.place.name) for one in findings] == [("axis-zero", "a"), ("limit-malformed", "b")]


def test_an_arm_is_taken_too(rover: Arm, tmp_path: Path) -> None:
    assert codes(rover) == codes("rover_arm")
    with pytest.raises(InputError, match="an Arm is loaded already and takes no tip"):
        diagnose(rover, tip="tool0")


def test_an_arm_from_screws_has_no_file_to_look_at() -> None:
    screws = twistarm.joints.revolute([0, 0, 1], [0, 0, 0])
    arm = arm_from_screws(np.hstack([screws, screws]), np.eye(4), name="twice")
    findings = diagnose(arm)
    assert {"cannot-move", "cannot-turn"} <= {one.code for one in findings}
    assert {str(one.place) for one in findings} == {"twice"}


def test_what_the_caller_typed_wrong_is_raised_and_what_the_arm_toml_says_wrong_is_found(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="no arm 'rover_amr' in the catalogue"):
        diagnose("rover_amr")
    path = write(tmp_path, two_joints())
    with pytest.raises(UnknownNameError, match="no link for tip= 'tool'"):
        diagnose(path, tip="tool")
    write(tmp_path, 'source = "arm.urdf"\ntip = "tool"\n', "arm.toml")
    (said,) = [one for one in diagnose(tmp_path / "arm.toml") if one.severity == "error"]
    assert said.code == "arm-file-unusable"
    assert "closest: 'tool0'" in said.what


# -- limits --------------------------------------------------------------------------------------------------------


def test_limits_in_degrees_come_with_their_radians(tmp_path: Path) -> None:
    said = only(CASES["limits-look-like-degrees"], tmp_path, "limits-look-like-degrees")
    assert str(said.place) == "arm.urdf:2: joint 'a'"
    assert said.what == f"its limits [-170, 170] rad allow {340 / (2 * math.pi):.1f} turns; they look like degrees"
    assert said.remedy == f'write lower="{-math.radians(170):.6g}" upper="{math.radians(170):.6g}"'


def test_what_the_arm_toml_mends_is_not_told(tmp_path: Path) -> None:
    path = lay(CASES["limits-look-like-degrees"], tmp_path)
    assert "limits-look-like-degrees" not in codes(path, limits={"lower": {"a": -2.9}, "upper": {"a": 2.9}})


@pytest.mark.parametrize("bound", ["6.28319", "12.566", "1e5"])
def test_turns_and_no_limit_are_no_degrees(bound: str, tmp_path: Path) -> None:
    limit = f'<limit lower="-{bound}" upper="{bound}" velocity="10" effort="1"/>'
    assert "limits-look-like-degrees" not in codes(write(tmp_path, two_joints(inside=limit)))


def test_limits_of_the_arm_toml_are_told_and_mended_there(tmp_path: Path) -> None:
    write(tmp_path, two_joints())
    path = write(tmp_path, 'source = "arm.urdf"\n[limits]\nb = {lower = -90, upper = 90, velocity = 180}\n', "arm.toml")
    said = {one.code: one for one in diagnose(path) if one.severity == "warning"}
    bounds, velocity = said["limits-look-like-degrees"], said["velocity-implausible"]
    assert str(bounds.place) == str(velocity.place) == "arm.toml: joint 'b'"
    assert "allow 28.6 turns" in bounds.what
    assert bounds.remedy == f"write lower = {-math.pi / 2:.6g}, upper = {math.pi / 2:.6g} in limits.b of arm.toml"
    assert velocity.remedy.startswith(f"write velocity = {math.pi:.4g} in limits.b of arm.toml if it is in degrees")


def test_limits_that_the_caller_gave_are_no_fault_of_the_file(tmp_path: Path) -> None:
    limits = {"lower": {"b": -90.0}, "upper": {"b": 90.0}}
    (said,) = [one for one in diagnose(write(tmp_path, two_joints()), limits=limits) if one.severity == "warning"]
    assert (said.code, said.place.line) == ("limits-look-like-degrees", None)
    assert said.remedy == "give lower = -1.5708, upper = 1.5708 where the arm is loaded"


def test_limits_that_a_follower_narrows_stand_in_the_file(tmp_path: Path) -> None:
    wide = '<limit lower="-170" upper="170" velocity="1" effort="1"/>'
    parts = (
        joint("a", "base_link", "upper", inside=wide),
        joint("b", "upper", "tool0", inside=f'<mimic joint="a" multiplier="2"/>{wide}'),
    )
    said = [one for one in diagnose(write(tmp_path, robot(*parts))) if one.code == "limits-look-like-degrees"]
    assert {str(one.place) for one in said} == {"arm.urdf:2: joint 'a'", "arm.urdf:2: joint 'b'"}


def test_joints_with_one_impossible_velocity_are_one_finding(tmp_path: Path) -> None:
    text = chain("0 0 1", "0 1 0", "0 1 0").replace('velocity="2"', 'velocity="180"', 2)
    (said,) = [one for one in diagnose(write(tmp_path, text)) if one.code == "velocity-implausible"]
    assert said.what.startswith("'j0', 'j1': a velocity limit of 180 rad/s")
    assert said.remedy.startswith(f'write velocity="{math.pi:.4g}" if it is in degrees per second')


def test_a_finger_beyond_its_limits_is_found_off_the_chain(tmp_path: Path) -> None:
    parts = (
        joint("a", "base_link", "tool0"),
        joint("left", "tool0", "l", kind="prismatic", inside='<limit lower="0" upper="0.04" velocity="1" effort="1"/>'),
        joint("right", "tool0", "r", kind="prismatic",
              inside='<mimic joint="left" multiplier="-1"/><limit lower="0" upper="0.04" velocity="1" effort="1"/>'),
    )  # fmt: skip
    path = write(tmp_path, robot(*parts, links=("base_link", "tool0", "l", "r")))
    (said,) = [one for one in diagnose(path) if one.code == "mimic-outside-limits"]
    assert said.place.name == "right"
    assert said.what == "left drives it through [-0.04, 0], beyond its own limits [0, 0.04], which are not kept"


# -- postures ------------------------------------------------------------------------------------------------------


def numeric_condition(arm: Arm, theta: np.ndarray) -> float:
    """From Pinocchio's LOCAL Jacobian, linear rows in units of the reach, for an arm of turning joints."""
    model = pinocchio.buildModelFromXML(arm.description.text)  # type: ignore[union-attr]
    data = model.createData()
    frame = model.getFrameId(arm.tip, pinocchio.FrameType.BODY)
    J = pinocchio.computeFrameJacobian(model, data, theta, frame, pinocchio.LOCAL)
    return float(np.linalg.cond(np.vstack([J[:3] / arm.reach, J[3:]])))


def test_the_recommended_pose_can_be_pasted_and_is_as_good_as_said(tmp_path: Path) -> None:
    text = chain("0 0 1", "0 1 0", "0 1 0", "0 0 1", "0 1 0", "0 0 1", xyz="0 0 0.3")
    path = write(tmp_path, text.replace('lower="-1" upper="1"', 'lower="-2.5" upper="2.5"'))
    (said,) = [one for one in diagnose(path) if one.code == "home-singular"]
    assert said.what.startswith("the zero pose is singular: condition number ∞;")
    head, _, snippet = said.remedy.partition("\n")
    write(tmp_path, f'source = "arm.urdf"\n{snippet}\n', "arm.toml")
    arm = load_arm(tmp_path / "arm.toml")
    condition = numeric_condition(arm, arm.ready)
    assert f"condition number {condition:.1f};" in head
    assert condition < 1.2 * numeric_condition(arm, load_arm(path).ready)
    assert [one.remedy for one in diagnose(path) if one.code == "home-singular"] == [said.remedy]
    assert "ready-singular" not in codes(tmp_path / "arm.toml")
    assert (np.abs(arm.ready) <= 0.8 * 2.5).all()


def test_the_recommended_pose_has_few_digits(tmp_path: Path) -> None:
    text = chain("0 0 1", "0 1 0", "0 1 0", "0 0 1", "0 1 0", "0 0 1", xyz="0 0 0.3")
    arm = load_arm(write(tmp_path, text.replace('lower="-1" upper="1"', 'lower="-2.5" upper="2.5"')))
    pose = recommended(arm, 6)
    assert pose.any()
    assert np.array_equal(pose, np.round(pose, 1))


def test_names_in_a_snippet_are_quoted_as_toml_wants_it() -> None:
    values = {"a-b_1": 1.0, 'a "b"\\': 2.0, "": 3.0, "a.b": 4.0, "gelenk_ä": 5.0, "a\tb\x7f": 6.0}
    assert tomllib.loads(toml_table("poses.ready", values)) == {"poses": {"ready": values}}


def test_a_pose_named_home_is_looked_at(tmp_path: Path) -> None:
    """Three parallel hinges are singular stretched out, whatever the first one does; zero is outside the limits."""
    text = chain("0 1 0", "0 1 0", "0 1 0").replace('lower="-1"', 'lower="0.1"', 1)
    write(tmp_path, text)
    for bend, singular in ((0.0, True), (0.5, False)):
        pose = f"[poses.home]\nj0 = 0.5\nj1 = {bend}\nj2 = 0.0\n"
        write(tmp_path, f'source = "arm.urdf"\n{pose}', "arm.toml")
        said = [one.what for one in diagnose(tmp_path / "arm.toml") if one.code == "home-singular"]
        assert bool(said) == singular
        assert all(what.startswith("the home pose is singular") for what in said)


# -- bodies --------------------------------------------------------------------------------------------------------


def test_a_body_is_judged_by_its_moments(tmp_path: Path) -> None:
    """A thin rod has I_xx = I_yy, I_zz = 0 and is possible; more than the sum of the two others is not."""
    assert "inertia-impossible" not in [one.code for one in found(with_body(ixx="0.02"), tmp_path)]
    said = only(with_body(ixx="0.0212"), tmp_path, "inertia-impossible")
    assert "no body has the principal moments (0.01, 0.01, 0.0212) kg m²" in said.what
    assert said.place.name == "upper"
    negative = only(with_body(ixx="-0.01"), tmp_path, "inertia-impossible")
    assert "(-0.01, 0.01, 0.01)" in negative.what


def test_gyration_and_centre_come_in_metres(tmp_path: Path) -> None:
    assert "radius of gyration of 10 m" in only(with_body(mass="0.0001"), tmp_path, "inertia-implausible").what
    assert "250 m off" in only(with_body(com="0 0 250"), tmp_path, "centre-of-mass-far").what


# -- meshes --------------------------------------------------------------------------------------------------------


def test_a_mesh_in_millimetres_comes_with_its_scale(tmp_path: Path) -> None:
    said = only(with_mesh(triangle(300.0), scale="1 1 2"), tmp_path, "mesh-too-large")
    assert said.remedy == 'write scale="0.001 0.001 0.002" in <mesh>'
    mended = with_mesh(triangle(300.0), scale="0.001 0.001 0.002")
    assert not [one for one in found(mended, tmp_path) if one.code.startswith("mesh")]


@pytest.mark.parametrize(
    ("length", "unit", "metres", "others"),
    [
        (300.0, "millimetres", 0.001, ""),
        (40.0, "centimetres", 0.01, "millimetres"),
        (0.4 / 0.0254 * 2, "inches", 0.0254, "centimetres or millimetres"),
    ],
)
def test_the_unit_of_a_mesh_is_likely_and_not_a_fact(
    length: float, unit: str, metres: float, others: str, tmp_path: Path
) -> None:
    """On an arm of 1 m."""
    path = lay(with_mesh(triangle(length)), tmp_path)
    (said,) = [one for one in diagnose(path) if one.code == "mesh-too-large"]
    assert said.what.endswith(f"likely in {unit}")
    assert said.remedy.startswith(f'write scale="{metres} {metres} {metres}" in <mesh>')
    assert said.remedy.endswith(f"check the unit of the export: it may be {others} too") == bool(others)


def test_a_scale_of_zero_is_told_and_not_written_again(tmp_path: Path) -> None:
    said = only(with_mesh(triangle(0.3), scale="0 0 0"), tmp_path, "mesh-too-small")
    assert said.what == "'part.stl': a scale of 0 leaves nothing of it to see"
    assert said.remedy.startswith('write scale="1 1 1" in <mesh>')


@pytest.mark.parametrize("scales", [("1 1 1", "0.001 0.001 0.001"), ("0.001 0.001 0.001", "1 1 1")])
def test_a_mesh_is_judged_at_each_of_its_scales(scales: tuple[str, str], tmp_path: Path) -> None:
    path = lay(with_mesh(triangle(300.0), scale=scales[0]), tmp_path)
    shape = f'<visual><geometry><mesh filename="part.stl" scale="{scales[1]}"/></geometry></visual>'
    path.write_text(path.read_text().replace('<link name="tool0"/>', f'<link name="tool0">{shape}</link>'))
    (said,) = [one for one in diagnose(path) if one.code.startswith("mesh")]
    assert (said.code, said.remedy) == ("mesh-too-large", 'write scale="0.001 0.001 0.001" in <mesh>')


def test_a_pointer_is_no_unreadable_mesh(tmp_path: Path) -> None:
    assert [one.code for one in found(with_mesh(POINTER), tmp_path) if one.code.startswith("mesh")] == [
        "mesh-lfs-pointer"
    ]


def test_without_trimesh_it_is_said_what_was_not_looked_at(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "trimesh", None)
    said = only(with_mesh(triangle(300.0)), tmp_path, "mesh-not-looked-at")
    assert "1 mesh files, whose size was not looked at: that needs trimesh" in said.what
    assert said.remedy == "pip install 'twistarm[view]'"


# -- axes ----------------------------------------------------------------------------------------------------------


def test_rounded_axes_come_with_what_to_write(tmp_path: Path) -> None:
    parts = ["0 1 0", "0 1 0", "1 0 0"]
    text = chain(*parts).replace('rpy="0 0 0"', 'rpy="0 0 1.5708"', 1).replace('rpy="0 0 0"', 'rpy="1.5708 0 0"', 1)
    (said,) = [one for one in diagnose(write(tmp_path, text)) if one.code == "axes-almost-exact"]
    assert f"square but for {1.5708 - math.pi / 2:.1e} rad" in said.what
    assert said.remedy.startswith(f"write {math.pi / 2!r} for 1.5708 in <origin rpy>")
    exact = text.replace("1.5708", repr(math.pi / 2))
    assert "axes-almost-exact" not in codes(write(tmp_path, exact))


def test_every_rounded_angle_is_named_as_it_is_written(tmp_path: Path) -> None:
    """Several near zero, and both roundings of a quarter turn; with all of them exact nothing is left to tell."""
    words = ("1.5708", "-1.57079", "1.44901112074e-7", "-3.2047474e-07")
    exact = (repr(math.pi / 2), repr(-math.pi / 2), "0", "0")
    text = chain("0 1 0", "0 1 0", "1 0 0", "1 0 0")
    mended = text
    for word, instead in zip(words, exact, strict=True):
        text = text.replace('rpy="0 0 0"', f'rpy="{word} 0 {word}"', 1)
        mended = mended.replace('rpy="0 0 0"', f'rpy="{instead} 0 {instead}"', 1)
    (said,) = [one for one in diagnose(write(tmp_path, text)) if one.code == "axes-almost-exact"]
    assert said.remedy.startswith(
        f"write {math.pi / 2!r} for 1.5708, 1.57079; 0 for 1.44901112074e-7, 3.2047474e-07 in <origin rpy>"
    )
    assert "axes-almost-exact" not in codes(write(tmp_path, mended))


def test_of_many_rounded_angles_the_rest_is_counted(models: Path, tmp_path: Path) -> None:
    """Nine words are within 1e-6 of zero; with 0 in their place only the offsets are left."""
    text = (models / "robojackets_walli_v2_block/urdf/walli_arm_v2_block/robot.urdf").read_text()
    (said,) = [one for one in diagnose(write(tmp_path, text), tip="ee") if one.code == "axes-almost-exact"]
    angles = " ".join(re.findall(r'rpy="([^"]*)"', text))
    near_zero = re.findall(r"[\d.]+e-7", angles)
    assert len(near_zero) == 9
    assert said.remedy.startswith(f"write 0 for {', '.join(near_zero[:3])} and 6 more as near to it in <origin rpy>")
    for word in near_zero:
        text = text.replace(word, "0")
    (left,) = [one for one in diagnose(write(tmp_path, text), tip="ee") if one.code == "axes-almost-exact"]
    assert "parallel" in said.what
    assert "parallel" not in left.what
    assert "rpy" not in left.remedy


def test_a_distance_that_misses_has_its_remedy_too(tmp_path: Path) -> None:
    text = chain("0 0 1", "0 1 0").replace('xyz="0 0 0.5" rpy="0 0 0"', 'xyz="0.0005 0 0.5" rpy="0 0 1.5708"', 2)
    (said,) = [one for one in diagnose(write(tmp_path, text)) if one.code == "axes-almost-exact"]
    assert "a distance that is left then stands in <origin xyz>, or is meant" in said.remedy


@pytest.mark.parametrize(("miss", "told"), [("0.0005", True), ("0.003", False), ("0", False)])
def test_axes_that_almost_meet(miss: str, told: bool, tmp_path: Path) -> None:
    text = chain("0 0 1", "0 1 0").replace('xyz="0 0 0.5"', f'xyz="{miss} 0 0.5"', 2)
    said = [one for one in diagnose(write(tmp_path, text)) if one.code == "axes-almost-exact"]
    assert bool(said) == told
    assert not told or "j0–j1 meet but for 0.5 mm" in said[0].what


def test_a_wrist_that_is_almost_spherical(tmp_path: Path) -> None:
    """Neighbouring axes meet, but the second and the third 1 mm beside where the first and the second do."""
    text = robot(
        joint("roll", "base_link", "a", inside='<axis xyz="0 0 1"/>'),
        joint("pitch", "a", "b", inside='<axis xyz="0 1 0"/>'),
        joint("yaw", "b", "tool0", inside='<axis xyz="1 0 0"/>', xyz="0 0.001 0"),
        links=("base_link", "a", "b", "tool0"),
    )
    (said,) = [one for one in diagnose(write(tmp_path, text)) if one.code == "axes-almost-exact"]
    assert "roll–pitch–yaw are a spherical wrist but for 0.5 mm" in said.what


# -- the tool ------------------------------------------------------------------------------------------------------


def test_a_tool_given_in_the_arm_toml_is_a_tool(tmp_path: Path) -> None:
    assert "tool-frame-missing" not in codes(write(tmp_path, two_joints()))
    path = write(tmp_path, two_joints().replace("tool0", "flange"))
    (said,) = [one for one in diagnose(path) if one.code == "tool-frame-missing"]
    _, _, snippet = said.remedy.partition("\n")
    write(tmp_path, f'source = "arm.urdf"\n{snippet}\n', "arm.toml")
    assert "tool-frame-missing" not in codes(tmp_path / "arm.toml")


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
        {"tip": "claw"},
        {"mesh-missing", "velocity-not-given", "effort-not-given", "mimic-outside-limits", "tool-frame-missing"},
    ),
    "robojackets_walli_v2_block/urdf/walli_arm_v2_block/robot.urdf": (
        {"tip": "ee"}, {"limit-incomplete", "mass-tiny", "axes-almost-exact", "home-singular", "cannot-turn-in-place"}
    ),
    "ur_description/urdf/ur.urdf.xacro": (
        {"xacro_args": {"name": "ur", "ur_type": "ur5e"}}, {"mesh-missing", "home-singular", "several-tips"}
    ),
    "so101/so101_new_calib.urdf": ({}, {"mesh-missing", "cannot-turn-in-place", "joint-off-the-chain", "several-tips"}),
    "annin_ar4_description/urdf/ar.urdf.xacro": (
        {"xacro_args": {"ar_model": "mk3"}}, {"effort-not-given", "axes-almost-exact", "joint-off-the-chain"}
    ),
    "kortex_description/robots/gen3.xacro": ({"xacro_args": {"dof": 7}}, {"mesh-missing", "axes-almost-exact"}),
    "kortex_description/robots/gen3_lite.urdf": ({}, {"mesh-missing", "axes-almost-exact", "joint-off-the-chain"}),
}  # fmt: skip
REFUSED = {
    "kortex_description/robots/gen3_lite_gen3_lite_2f.xacro": ({}, "xacro-failed", 'Invalid parameter "gripper"'),
    "kortex_description/robots/gen3_robotiq_2f_85.xacro": ({}, "xacro-failed", 'Invalid parameter "sim"'),
    "kortex_description/robots/gen3_robotiq_2f_140.xacro": ({}, "xacro-failed", 'Invalid parameter "sim"'),
    "kortex_description/multiple_robots/kortex_dual_robots.xacro": ({}, "xacro-failed", "Invalid parameter"),
    "kortex_description/robots/gen3.xacro": ({}, "xacro-failed", "arms/gen3/dof/"),
    "annin_ar4_description/urdf/ar.urdf.xacro": ({}, "xacro-argument-missing", "ar_model (required)"),
    "annin_ar4_description/urdf/ar_gazebo.urdf.xacro": (
        {"xacro_args": {"ar_model": "mk3"}}, "package-needed-not-found", "annin_ar4_driver"
    ),
    "robojackets_walliiarmv3/urc_arm_moveit_config/config/WalliiArmV3.urdf.xacro": (
        {}, "package-needed-not-found", "package 'urc_gazebo' not found"
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
