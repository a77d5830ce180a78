"""Packages copied out of a workspace: folders of their name without a package.xml, found near the file alone."""

from __future__ import annotations

from pathlib import Path

import pytest

from hostile.sandbox import TOKEN, XMLNS
from twistarm import load_arm
from twistarm.arm.arm import Arm
from twistarm.support.errors import DescriptionError
from urdf_text import joint
from xacro_text import ARM, MANIFEST, as_xacro, lay

PART = f'<robot {XMLNS}><link name="extra"/>{joint("f", "upper", "extra", kind="fixed")}</robot>'
INCLUDE = as_xacro('<xacro:include filename="$(find parts)/urdf/part.xacro"/>')


def described(folder: Path, files: dict[str, str]) -> Path:
    """Files by their path; the first is the description."""
    return lay(folder, files) / next(iter(files))


def said(arm: Arm) -> str:
    """What was noticed about a folder taken by its name."""
    return "; ".join(one.what for one in arm.findings if one.code == "package-without-manifest")


@pytest.mark.parametrize(
    ("arm", "part"),
    [
        ("parts/urdf/arm.xacro", "parts"),
        ("arm/urdf/arm.xacro", "parts"),
        ("ws/arm/urdf/arm.xacro", "ws/src/parts"),
        ("arm-main/urdf/arm.xacro", "parts-main"),
        ("ws/install/arm/share/arm/urdf/arm.xacro", "ws/install/parts/share/parts"),
    ],
)
def test_a_folder_of_the_name_above_or_beside_the_file(arm: str, part: str, tmp_path: Path) -> None:
    path = described(tmp_path, {arm: INCLUDE, f"{part}/urdf/part.xacro": PART})
    loaded = load_arm(path, tip="tool0")
    assert "extra" in loaded.frame_names
    assert f"no package.xml names package 'parts': it is taken to be the folder {tmp_path / part}" in said(loaded)


def test_a_folder_of_the_name_among_those_that_are_given(tmp_path: Path) -> None:
    path = described(
        tmp_path, {"a/b/c/d/e/f/g/h/i/arm.xacro": INCLUDE, "elsewhere/repository/parts/urdf/part.xacro": PART}
    )
    with pytest.raises(DescriptionError, match="package 'parts' not found"):
        load_arm(path)
    for folder in ("elsewhere", "elsewhere/repository", "elsewhere/repository/parts"):
        assert "extra" in load_arm(path, tip="tool0", package_dirs=[tmp_path / folder]).frame_names


def test_a_package_xml_wins_wherever_it_is(tmp_path: Path) -> None:
    """Found last of all, and under a folder of another name."""
    files = {
        "parts/arm/urdf/arm.xacro": INCLUDE,
        "parts/urdf/part.xacro": "<robot/>",
        "parts/arm/parts/urdf/part.xacro": "<robot/>",
        "another_name/package.xml": MANIFEST("parts"),
        "another_name/urdf/part.xacro": PART,
    }
    arm = load_arm(described(tmp_path, files), tip="tool0")
    assert "extra" in arm.frame_names
    assert not said(arm)


def test_a_copy_that_looks_like_no_package_is_none(tmp_path: Path) -> None:
    """What it holds would be read, and a folder is no package for bearing a name."""
    text = as_xacro("<gazebo key=\"${xacro.load_yaml('$(find private)/key.yaml')}\"/>")
    path = described(tmp_path, {"arm/arm.xacro": text, "private/key.yaml": f"key: {TOKEN}"})
    with pytest.raises(DescriptionError, match="package 'private' not found") as caught:
        load_arm(path)
    assert TOKEN not in str(caught.value)
    (tmp_path / "private" / "urdf").mkdir()
    assert load_arm(path).n == 2


@pytest.mark.parametrize("name", ["link", ".hidden", ".."])
def test_no_other_folder_is_taken_for_a_package(name: str, tmp_path: Path) -> None:
    text = as_xacro(f'<xacro:include filename="$(find {name})/urdf/part.xacro"/>')
    lay(tmp_path, {"ws/arm/arm.xacro": text, "far/urdf/part.xacro": PART, "ws/arm/deeper/urdf/part.xacro": PART})
    lay(tmp_path, {"ws/.hidden/urdf/part.xacro": PART, "ws/urdf/part.xacro": PART})
    (tmp_path / "ws" / "link").symlink_to(tmp_path / "far")
    with pytest.raises(DescriptionError, match="package .* not found"):
        load_arm(tmp_path / "ws" / "arm" / "arm.xacro")


@pytest.mark.parametrize(
    "package_dirs", [(), (".",), ("..",), ("../..",), pytest.param(("/",), marks=pytest.mark.slow)]
)
def test_neither_the_home_folder_nor_what_stands_beside_it(
    package_dirs: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = tmp_path / "home" / "me"
    files = {"arm/arm.xacro": "", "urdf/part.xacro": PART, "../you/urdf/part.xacro": PART}
    path = described(home, files)
    monkeypatch.setenv("HOME", str(home))
    for name in ("me", "you", "home"):
        path.write_text(INCLUDE.replace("parts", name))
        with pytest.raises(DescriptionError, match=f"package '{name}' not found"):
            load_arm(path, package_dirs=[home / folder for folder in package_dirs])


def test_what_nobody_asked_for_by_its_name_stays_closed(tmp_path: Path) -> None:
    text = as_xacro('<xacro:include filename="../parts/urdf/part.xacro"/>')
    path = described(tmp_path, {"arm/arm.xacro": text, "parts/urdf/part.xacro": PART})
    with pytest.raises(DescriptionError, match="lies outside the folders that may be read"):
        load_arm(path)


def test_a_mesh_of_a_copy_is_found_and_told(tmp_path: Path) -> None:
    mesh = '<visual><geometry><mesh filename="package://parts/pictures/a.stl"/></geometry></visual>'
    text = ARM.replace('<link name="tool0"/>', f'<link name="tool0">{mesh}</link>')
    arm = load_arm(described(tmp_path, {"arm/arm.urdf": text, "parts/pictures/a.stl": "solid"}))
    assert arm.description is not None
    assert arm.description.links["tool0"].visuals[0].mesh == tmp_path / "parts" / "pictures" / "a.stl"
    assert str(tmp_path / "parts") in said(arm)


@pytest.mark.parametrize(
    ("arm", "part", "stands"),
    [
        ("mine/urdf/arm.xacro", "mine/urdf/part.xacro", "stands in {}/mine"),
        ("arm.xacro", "part.xacro", "at {}/part.xacro"),
    ],
)
def test_a_package_under_another_name_is_pointed_at(arm: str, part: str, stands: str, tmp_path: Path) -> None:
    path = described(tmp_path, {arm: INCLUDE, part: PART})
    with pytest.raises(DescriptionError, match="package 'parts' not found") as refused:
        load_arm(path, tip="tool0", package_dirs=[tmp_path / "mine"] if (tmp_path / "mine").is_dir() else [])
    assert stands.format(tmp_path) in str(refused.value)
