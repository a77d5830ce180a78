"""Paths of meshes: those that other readers find are found, and what is told of the others mends them."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from twistarm import load_arm
from twistarm.description.findings import Finding
from twistarm.description.urdf import read_description
from urdf_text import two_joints
from xacro_text import MANIFEST, lay

STL = "meshes/Part.stl"


def drawing(root: Path, uri: str, arm: str, mesh: str, manifest: str = "") -> Path:
    """A description that draws `uri`, a mesh, and beside `manifest`'s folder a package.xml."""
    shape = f'<visual><geometry><mesh filename="{uri}"/></geometry></visual>'
    text = two_joints().replace('<link name="upper"/>', f'<link name="upper">{shape}</link>')
    contents = {arm: text, mesh: "solid\nendsolid\n"}
    if manifest:
        contents[f"{manifest}/package.xml"] = MANIFEST("my_arm")
    return lay(root, contents) / arm


def drawn(path: Path, **load: object) -> Path | None:
    return read_description(path, **load).links["upper"].visuals[0].mesh  # type: ignore[arg-type]


OWN = ("pkg/urdf/arm.urdf", f"pkg/{STL}", "pkg")
BARE = ("pkg/urdf/arm.urdf", f"pkg/{STL}", "")
FOUND = {
    "a backslash": (r"package://my_arm\meshes\Part.stl", *OWN),
    "an escaped letter": ("package://my_arm/meshes%2FPart.stl", *OWN),
    "an escaped space": ("package://my_arm/meshes/Part%20a.stl", OWN[0], "pkg/meshes/Part a.stl", "pkg"),
    "a path beside the file": (f"../{STL}", *BARE),
    "a file's URI": (f"file://@/pkg/{STL}", *BARE),
    "no package's name": (f"package:///{STL}", *OWN),
    "a dot for it": (f"package://./{STL}", *OWN),
    "find with two slashes": (f"$(find my_arm)//{STL}", *OWN),
    "a ZIP's folder": (f"package://my_arm/{STL}", "my_arm-main/urdf/arm.urdf", f"my_arm-main/{STL}", ""),
    "a commit's ZIP": (f"package://my_arm/{STL}", "arm/arm.urdf", f"my_arm-0a1b2c3d4e5f/{STL}", ""),
    "installed beside": (
        f"package://my_arm/{STL}",
        "ws/install/x/share/x/urdf/arm.urdf",
        f"ws/install/my_arm/share/my_arm/{STL}",
        "ws/install/my_arm/share/my_arm",
    ),
    "installed without a manifest": (
        f"package://my_arm/{STL}",
        "ws/install/x/share/x/urdf/arm.urdf",
        f"ws/install/my_arm/share/my_arm/{STL}",
        "",
    ),
}


@pytest.mark.parametrize("case", FOUND)
def test_a_path_as_others_write_it_is_found(case: str, tmp_path: Path) -> None:
    uri, arm, mesh, manifest = FOUND[case]
    path = drawing(tmp_path, uri.replace("@", str(tmp_path)), arm, mesh, manifest)
    assert drawn(path) == tmp_path / mesh
    assert [one for one in load_arm(path).findings if one.code == "mesh-missing"] == []


@pytest.mark.parametrize("uri", [f"package://my/{STL}", f"package://my_ar/{STL}", f"package://other//{STL}"])
def test_another_package_s_folder_is_none(uri: str, tmp_path: Path) -> None:
    """A name that begins as the package's, and no way out of a package by a second slash."""
    path = drawing(tmp_path, uri, "ws/arm/arm.urdf", f"my_arm/{STL}")
    assert drawn(path) is None
    absolute = drawing(tmp_path, f"package://my_arm/{tmp_path}/my_arm/{STL}", "ws/arm/arm.urdf", f"my_arm/{STL}")
    assert drawn(absolute) is None


def written(path: Path, remedy: str) -> Path | None:
    """The mesh when the description says what the remedy names."""
    (uri,) = re.findall(r"^write '([^']+)';", remedy)
    path.write_text(re.sub('filename="[^"]*"', f'filename="{uri}"', path.read_text()))
    return drawn(path)


def renamed(path: Path, remedy: str) -> Path | None:
    """The mesh when the folder that is named has the package's name."""
    (name,) = re.findall(r"^give the folder 'pkg' the name (\w+);", remedy)
    (path.parents[1]).rename(path.parents[2] / name)
    return drawn(path.parents[2] / name / path.relative_to(path.parents[1]))


def corrected(path: Path, remedy: str) -> Path | None:
    """The mesh when the package has the nearest name."""
    (name,) = re.findall(r"closest: '(\w+)'", remedy)
    path.write_text(re.sub("//[^/]+/", f"//{name}/", path.read_text(), count=1))
    return drawn(path)


def passed(path: Path, remedy: str) -> Path | None:
    """The mesh when the folder that holds the package is given."""
    assert "pass package_dirs=[...] (the folder that holds gone)" in remedy
    return drawn(path, package_dirs=[path.parents[2] / "far"])


Mend = Callable[[Path, str], Path | None]
REMEDIES: dict[str, tuple[str, str, str, str, Mend]] = {
    "the case of a file": ("package://my_arm/meshes/part.STL", *OWN, written),
    "the case of the package": (f"package://My_Arm/{STL}", *OWN, corrected),
    "a slip in the package": (f"package://my_amr/{STL}", "arm/urdf/arm.urdf", f"my_arm/{STL}", "my_arm", corrected),
    "a folder of another name": (f"package://gone/{STL}", *BARE, renamed),
    "a package far away": (f"package://gone/{STL}", "pkg/urdf/arm.urdf", f"far/a/gone/{STL}", "", passed),
}


@pytest.mark.parametrize("case", REMEDIES)
def test_the_remedy_that_is_named_works(case: str, tmp_path: Path) -> None:
    uri, arm, mesh, manifest, mend = REMEDIES[case]
    path = drawing(tmp_path, uri, arm, mesh, manifest)
    findings: list[Finding] = [one for one in load_arm(path).findings if one.code == "mesh-missing"]
    (remedy,) = (one.remedy for one in findings)
    mended = mend(path, remedy)
    assert mended is not None
    assert mended.name == "Part.stl"


def test_a_file_that_is_nowhere_is_said_to_be_that(tmp_path: Path) -> None:
    path = drawing(tmp_path, "package://my_arm/meshes/other.dae", *OWN)
    (finding,) = (one for one in load_arm(path).findings if one.code == "mesh-missing")
    assert "no such file stands in package 'my_arm'" in finding.what
    assert "package_dirs" not in finding.remedy


def test_a_repaired_copy_has_plain_slashes(tmp_path: Path) -> None:
    from twistarm.checking.doctor.repair import repair

    path = drawing(tmp_path, r"..\meshes\\Part.stl", *BARE)
    made = repair(read_description(path), tmp_path / "copy.urdf")
    assert 'filename="pkg/meshes/Part.stl"' in made.text
