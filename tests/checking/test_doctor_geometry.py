"""Units that are doubtful, poses, rounded angles and axes: what the doctor finds is found by other means too."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pinocchio
import pytest

from finding_cases import CASES, chain, triangle, with_body, with_mesh
from test_finding_codes import codes, found, only
from twistarm import Arm, diagnose, load_arm
from urdf_text import joint, robot, two_joints, write

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
    assert said.what.startswith("the zero configuration is singular: condition number ∞;")
    head, _, snippet = said.remedy.partition("\n")
    write(tmp_path, f'source = "arm.urdf"\n{snippet}\n', "arm.toml")
    arm = load_arm(tmp_path / "arm.toml")
    condition = numeric_condition(arm, arm.ready)
    assert f"condition number {condition:.1f};" in head
    assert condition < 1.2 * numeric_condition(arm, load_arm(path).ready)
    assert [one.remedy for one in diagnose(path) if one.code == "home-singular"] == [said.remedy]
    assert "ready-singular" not in codes(tmp_path / "arm.toml")
    assert (np.abs(arm.ready) <= 0.8 * 2.5).all()


def test_a_pose_named_home_is_looked_at(tmp_path: Path) -> None:
    """Three parallel hinges are singular stretched out, whatever the first one does; zero is outside the limits."""
    text = chain("0 1 0", "0 1 0", "0 1 0").replace('lower="-1"', 'lower="0.1"', 1)
    write(tmp_path, text)
    for bend, singular in ((0.0, True), (0.5, False)):
        pose = f"[poses.home]\nj0 = 0.5\nj1 = {bend}\nj2 = 0.0\n"
        write(tmp_path, f'source = "arm.urdf"\n{pose}', "arm.toml")
        said = [one.what for one in diagnose(tmp_path / "arm.toml") if one.code == "home-singular"]
        assert bool(said) == singular
        assert all(what.startswith("the home configuration is singular") for what in said)


# -- axes ----------------------------------------------------------------------------------------------------------


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
    assert "1.5708, 1.57079, 1.44901112074e-7, 3.2047474e-07" in said.remedy
    assert repr(math.pi / 2) in said.remedy
    assert "axes-almost-exact" not in codes(write(tmp_path, mended))


@pytest.mark.parametrize(("miss", "told"), [("0.0005", True), ("0.003", False), ("0", False)])
def test_axes_that_almost_meet(miss: str, told: bool, tmp_path: Path) -> None:
    text = chain("0 0 1", "0 1 0").replace('xyz="0 0 0.5"', f'xyz="{miss} 0 0.5"', 2)
    said = [one for one in diagnose(write(tmp_path, text)) if one.code == "axes-almost-exact"]
    assert bool(said) == told
    assert not told or "j0–j1 meet to within 0.5 mm" in said[0].what


def wrist(offset: float) -> str:
    """Six joints; the last three axes meet but for an offset [m]."""
    axes = ["0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "1 0 0"]
    xyz = ["0 0 0.3", "0 0.1 0.2", "0 0.1 0.5", "0.05 0 0.4", "0 0 0", f"0 {offset} 0"]
    links = [f"l{i}" for i in range(6)]
    parts = [
        joint(f"j{i}", one, other, inside=f'<axis xyz="{axis}"/>', xyz=place)
        for i, (one, other, axis, place) in enumerate(zip(["base_link", *links[:-1]], links, axes, xyz, strict=True))
    ]
    return robot(*parts, joint("mount", "l5", "tool0", kind="fixed"), links=("base_link", *links, "tool0"))


@pytest.mark.parametrize(("offset", "told"), [(4e-4, True), (0.0, False), (0.05, False)])
def test_axes_that_just_miss_a_closed_form(offset: float, told: bool, tmp_path: Path) -> None:
    """Exact ones miss nothing, and an offset of 5 cm is how the arm is built."""
    said = [one.what for one in diagnose(write(tmp_path, wrist(offset))) if one.code == "axes-almost-exact"]
    missed = [what for what in said if "closed form" in what]
    assert [("j3 and j5" in what, "0.4 mm" in what) for what in missed] == [(True, True)] * told


def doubted(path: Path) -> dict[str, str]:
    """The remedies of the findings about units, by the joint or else the file; each place has one."""
    return {one.place.name or one.place.file: one.remedy for one in diagnose(path) if one.code == "unit-doubtful"}


# -- limits --------------------------------------------------------------------------------------------------------


def test_limits_in_degrees_come_with_their_radians(tmp_path: Path) -> None:
    said = only(CASES["unit-doubtful: degrees"], tmp_path, "unit-doubtful")
    assert (said.place.file, said.place.line, said.place.name) == ("arm.urdf", 2, "a")
    assert f"{-math.radians(170):.6g}" in said.remedy
    assert f"{math.radians(170):.6g}" in said.remedy


@pytest.mark.parametrize("bound", ["12.566", "1e5"])
def test_turns_and_no_limit_are_no_degrees(bound: str, tmp_path: Path) -> None:
    limit = f'<limit lower="-{bound}" upper="{bound}" velocity="10" effort="1"/>'
    assert doubted(write(tmp_path, two_joints(inside=limit))) == {}


def test_limits_of_the_arm_toml_are_reported_there(tmp_path: Path) -> None:
    write(tmp_path, two_joints())
    path = write(tmp_path, 'source = "arm.urdf"\n[limits]\nb = {lower = -90, upper = 90, velocity = 180}\n', "arm.toml")
    bounds, velocity = (one for one in diagnose(path) if one.severity == "warning")
    assert str(bounds.place) == str(velocity.place) == "arm.toml: joint 'b'"
    assert f"{-math.pi / 2:.6g}" in bounds.remedy
    assert f"{math.pi:.4g}" in velocity.remedy


def test_a_finger_beyond_its_limits_is_found_off_the_chain(tmp_path: Path) -> None:
    parts = (
        joint("a", "base_link", "tool0"),
        joint("left", "tool0", "l", kind="prismatic", inside='<limit lower="0" upper="0.04" velocity="1" effort="1"/>'),
        joint("right", "tool0", "r", kind="prismatic",
              inside='<mimic joint="left" multiplier="-1"/><limit lower="0" upper="0.04" velocity="1" effort="1"/>'),
    )  # fmt: skip
    path = write(tmp_path, robot(*parts, links=("base_link", "tool0", "l", "r")))
    (said,) = [one for one in diagnose(path) if one.code == "outside-limits"]
    assert said.place.name == "right"


# -- bodies --------------------------------------------------------------------------------------------------------


def test_a_body_is_judged_by_its_moments(tmp_path: Path) -> None:
    """A thin rod has I_xx = I_yy, I_zz = 0 and is possible; more than the sum of the two others is not."""
    assert "inertia-implausible" not in [one.code for one in found(with_body(ixx="0.02"), tmp_path)]
    for moment in ("0.0212", "-0.01"):
        said = only(with_body(ixx=moment), tmp_path, "inertia-implausible")
        assert said.place.name == "upper"
        assert moment in said.what


# -- meshes --------------------------------------------------------------------------------------------------------


def test_a_mesh_in_millimetres_comes_with_its_scale(tmp_path: Path) -> None:
    said = only(with_mesh(triangle(300.0), scale="1 1 2"), tmp_path, "unit-doubtful")
    assert 'scale="0.001 0.001 0.002"' in said.remedy
    mended = with_mesh(triangle(300.0), scale="0.001 0.001 0.002")
    assert "unit-doubtful" not in [one.code for one in found(mended, tmp_path)]


# -- a whole description in another unit --------------------------------------------------------------------------


def of_lengths(lengths: tuple[float, ...], slide: float, velocity: float) -> str:
    """A rail and an arm."""
    limit = f'<limit lower="0" upper="{slide}" velocity="{velocity}" effort="1"/>'
    links = ("base_link", "rail", *(f"l{i}" for i in range(len(lengths))))
    parts = [joint("slide", "base_link", "rail", kind="prismatic", inside=limit, xyz="0 0 0")]
    for i, length in enumerate(lengths):
        axis = f'<axis xyz="0 {i % 2} {(i + 1) % 2}"/>'
        parts.append(joint(f"j{i}", links[i + 1], links[i + 2], inside=axis, xyz=f"0 0 {length}"))
    return robot(*parts, links=links)


def test_a_description_in_millimetres(tmp_path: Path) -> None:
    path = write(tmp_path, of_lengths((162.5, 425.0, 392.0), slide=609.6, velocity=500.0))
    remedies = [one.remedy for one in diagnose(path) if one.code == "unit-doubtful"]
    for number, remedy in zip(("0.001", "0.6096", "0.5"), remedies, strict=True):
        assert number in remedy


def test_a_long_arm_in_metres_is_in_metres(tmp_path: Path) -> None:
    assert doubted(write(tmp_path, of_lengths((7.11, 6.9, 1.5), slide=3.0, velocity=0.5))) == {}
