"""Paths of meshes: those that other readers find are found, inside packages."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from twistarm import load_arm
from twistarm.description.urdf import read_description
from urdf_text import two_joints
from xacro_text import MANIFEST, lay

STL = "meshes/Part.stl"


def drawing(root: Path, uri: str, arm: str, mesh: str, manifest: str = "") -> Path:
    """A description that draws `uri`, a mesh, and in `manifest`'s folder a package.xml."""
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
INSTALLED = ("ws/install/x/share/x/urdf/arm.urdf", f"ws/install/my_arm/share/my_arm/{STL}")
FOUND = {
    "a backslash": (r"package://my_arm\meshes\Part.stl", *OWN),
    "an escaped letter": ("package://my_arm/meshes%2FPart.stl", *OWN),
    "an escaped space": ("package://my_arm/meshes/Part%20a.stl", OWN[0], "pkg/meshes/Part a.stl", "pkg"),
    "a path beside the file": (f"../{STL}", *BARE),
    "a file's URI": (f"file://@/pkg/{STL}", *BARE),
    "no package's name": (f"package:///{STL}", *OWN),
    "a dot for it": (f"package://./{STL}", *OWN),
    "find with two slashes": (f"$(find my_arm)//{STL}", *OWN),
    "installed beside": (f"package://my_arm/{STL}", *INSTALLED, "ws/install/my_arm/share/my_arm"),
    "installed without a manifest": (f"package://my_arm/{STL}", *INSTALLED, ""),
}


@pytest.mark.parametrize("case", FOUND)
def test_a_path_as_others_write_it_is_found(case: str, tmp_path: Path) -> None:
    uri, arm, mesh, manifest = FOUND[case]
    path = drawing(tmp_path, uri.replace("@", str(tmp_path)), arm, mesh, manifest)
    assert drawn(path) == tmp_path / mesh
    codes = [one.code for one in load_arm(path).findings]
    assert "mesh-missing" not in codes
    assert ("package-without-manifest" in codes) == (case == "installed without a manifest")


LOST = {
    "the name of another package": f"package://my/{STL}",
    "a way out of a package": f"package://my_arm/@/outside/{STL}",
    "a path outside": f"file://@/outside/{STL}",
    "a way up": f"../../outside/{STL}",
    "a link": "package://my_arm/link.stl",
    "no file": "package://my_arm/meshes/other.dae",
}


@pytest.mark.parametrize("case", LOST)
def test_a_mesh_that_is_not_in_a_package_is_missing(case: str, tmp_path: Path) -> None:
    path = drawing(tmp_path, LOST[case].replace("@", str(tmp_path)), *OWN)
    lay(tmp_path, {f"outside/{STL}": "solid"})
    (tmp_path / "pkg/link.stl").symlink_to(tmp_path / "outside" / STL)
    assert drawn(path) is None
    (one,) = [one for one in load_arm(path).findings if one.code == "mesh-missing"]
    if case in ("a path outside", "a way up"):
        assert "package_dirs" in one.remedy
        assert drawn(path, package_dirs=[tmp_path / "outside"]) == tmp_path / "outside" / STL


@pytest.mark.parametrize("near", [f"package://My_Arm/{STL}", f"package://my_amr/{STL}"])
def test_a_package_of_a_near_name_is_offered(near: str, tmp_path: Path) -> None:
    path = drawing(tmp_path, near, *OWN)
    (one,) = [one for one in load_arm(path).findings if one.code == "mesh-missing"]
    assert re.findall(r"closest: '(\w+)'", one.remedy) == ["my_arm"]


def test_a_repaired_copy_has_plain_slashes(tmp_path: Path) -> None:
    from twistarm.checking.doctor.repair import repair

    path = drawing(tmp_path, r"..\meshes\\Part.stl", *BARE)
    made = repair(read_description(path), tmp_path / "copy.urdf")
    assert 'filename="pkg/meshes/Part.stl"' in made.text
