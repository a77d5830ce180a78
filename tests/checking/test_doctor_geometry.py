"""Findings about postures and axes: their numbers from elsewhere, and remedies that work."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pinocchio
import pytest

from diagnosing import codes
from finding_cases import chain
from twistarm import Arm, diagnose, load_arm
from twistarm.checking.doctor.motions import toml_table
from urdf_text import joint, robot, write

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

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


def test_a_wrist_that_is_almost_spherical(tmp_path: Path) -> None:
    """Neighbouring axes meet, but the second and the third 1 mm beside where the first and the second do."""
    text = robot(
        joint("roll", "base_link", "a", inside='<axis xyz="0 0 1"/>'),
        joint("pitch", "a", "b", inside='<axis xyz="0 1 0"/>'),
        joint("yaw", "b", "tool0", inside='<axis xyz="1 0 0"/>', xyz="0 0.001 0"),
        links=("base_link", "a", "b", "tool0"),
    )
    (said,) = [one for one in diagnose(write(tmp_path, text)) if one.code == "axes-almost-exact"]
    assert "roll–pitch–yaw are almost a spherical wrist, off by 0.5 mm" in said.what


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
