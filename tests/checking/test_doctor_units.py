"""Findings about limits, bodies and meshes in the wrong unit: their numbers, places, and remedies that work."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from diagnosing import codes, only
from finding_cases import CASES, chain, triangle, with_body, with_mesh
from test_finding_codes import found, lay
from twistarm import diagnose
from urdf_text import joint, robot, two_joints, write

# -- limits --------------------------------------------------------------------------------------------------------


def test_limits_in_degrees_come_with_their_radians(tmp_path: Path) -> None:
    said = only(CASES["limits-look-like-degrees"], tmp_path, "limits-look-like-degrees")
    assert str(said.place) == "arm.urdf:2: joint 'a'"
    assert said.what == f"its limits [-170, 170] rad allow {340 / (2 * math.pi):.1f} turns; they look like degrees"
    assert said.remedy == f'write lower="{-math.radians(170):.6g}" upper="{math.radians(170):.6g}"'


@pytest.mark.parametrize("bound", ["12.566", "1e5"])
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


# -- bodies --------------------------------------------------------------------------------------------------------


def test_a_body_is_judged_by_its_moments(tmp_path: Path) -> None:
    """A thin rod has I_xx = I_yy, I_zz = 0 and is possible; more than the sum of the two others is not."""
    assert "inertia-impossible" not in [one.code for one in found(with_body(ixx="0.02"), tmp_path)]
    said = only(with_body(ixx="0.0212"), tmp_path, "inertia-impossible")
    assert "no body has the principal moments (0.01, 0.01, 0.0212) kg m²" in said.what
    assert said.place.name == "upper"
    negative = only(with_body(ixx="-0.01"), tmp_path, "inertia-impossible")
    assert "(-0.01, 0.01, 0.01)" in negative.what


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


# -- a whole description in another unit --------------------------------------------------------------------------

IN_METRES = (0.4064, 0.4191, 0.3048)
"""16, 16.5 and 12 inches."""


def of_lengths(metres: float, lengths: tuple[float, ...] = IN_METRES, slide: float = 0.6096) -> str:
    """A rail and an arm, each length written in a unit of so many metres."""
    limit = f'<limit lower="0" upper="{slide / metres:.6g}" velocity="{0.5 / metres:.6g}" effort="1"/>'
    links = ("base_link", "rail", *(f"l{i}" for i in range(len(lengths))))
    parts = [joint("slide", "base_link", "rail", kind="prismatic", inside=limit, xyz="0 0 0")]
    for i, length in enumerate(lengths):
        axis = f'<axis xyz="0 {i % 2} {(i + 1) % 2}"/>'
        parts.append(joint(f"j{i}", links[i + 1], links[i + 2], inside=axis, xyz=f"0 0 {length / metres:.8g}"))
    return robot(*parts, links=links)


@pytest.mark.parametrize(
    ("unit", "metres", "lengths"),
    [
        ("inches", 0.0254, IN_METRES),
        ("inches", 0.0254, (0.12, 0.43, 0.35, 0.26)),  # a metric arm, exported in inches
        ("millimetres", 0.001, (0.1625, 0.425, 0.392)),
        ("centimetres", 0.01, (0.123, 0.242, 0.357)),
    ],
)
def test_a_description_in_another_unit_is_recognised(
    unit: str, metres: float, lengths: tuple[float, ...], tmp_path: Path
) -> None:
    said = {one.code: one for one in diagnose(write(tmp_path, of_lengths(metres, lengths)))}
    reach = said["reach-implausible"]
    assert f"lengths in {unit} look like that" in reach.what
    assert reach.remedy.startswith(f"write every <origin xyz> in metres: multiply by {metres:g}")
    slide = said["limits-look-like-millimetres"]
    assert slide.what.endswith(f"look like {unit}")
    assert slide.remedy == 'write lower="0" upper="0.6096"'
    assert said["velocity-implausible"].remedy.startswith('write velocity="0.5" if it is in')


def test_a_long_arm_in_metres_is_in_metres(tmp_path: Path) -> None:
    text = of_lengths(1.0, (7.11, 6.9, 1.5), slide=3.0)
    assert not {one.code for one in diagnose(write(tmp_path, text))} & {
        "reach-implausible",
        "limits-look-like-millimetres",
        "velocity-implausible",
    }
