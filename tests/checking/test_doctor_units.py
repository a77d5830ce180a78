"""Findings about limits, bodies and meshes in the wrong unit: their numbers, places, and remedies that work."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from diagnosing import only
from finding_cases import CASES, triangle, with_body, with_mesh
from test_finding_codes import found, lay
from twistarm import diagnose
from urdf_text import joint, robot, two_joints, write


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


def test_limits_that_a_follower_narrows_stand_in_the_file(tmp_path: Path) -> None:
    wide = '<limit lower="-170" upper="170" velocity="1" effort="1"/>'
    parts = (
        joint("a", "base_link", "upper", inside=wide),
        joint("b", "upper", "tool0", inside=f'<mimic joint="a" multiplier="2"/>{wide}'),
    )
    places = [str(one.place) for one in diagnose(write(tmp_path, robot(*parts))) if one.code == "unit-doubtful"]
    assert sorted(places) == ["arm.urdf:2: joint 'a'", "arm.urdf:2: joint 'b'"]


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


def test_a_scale_of_zero_is_not_written_again(tmp_path: Path) -> None:
    assert 'scale="1 1 1"' in only(with_mesh(triangle(0.3), scale="0 0 0"), tmp_path, "unit-doubtful").remedy


@pytest.mark.parametrize("scales", [("1 1 1", "0.001 0.001 0.001"), ("0.001 0.001 0.001", "1 1 1")])
def test_a_mesh_is_judged_at_each_of_its_scales(scales: tuple[str, str], tmp_path: Path) -> None:
    path = lay(with_mesh(triangle(300.0), scale=scales[0]), tmp_path)
    shape = f'<visual><geometry><mesh filename="part.stl" scale="{scales[1]}"/></geometry></visual>'
    path.write_text(path.read_text().replace('<link name="tool0"/>', f'<link name="tool0">{shape}</link>'))
    (said,) = [one for one in diagnose(path) if one.code == "unit-doubtful"]
    assert 'scale="0.001 0.001 0.001"' in said.remedy


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
