"""Packages without ROS, and the paths of meshes in them."""

from __future__ import annotations

import os
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from twistarm import diagnose, load_arm
from twistarm.arm.arm import Arm
from twistarm.cli.application import run
from twistarm.description.packages import package_index, package_name
from twistarm.description.urdf import ReadOptions, read_description
from twistarm.support.errors import DescriptionError, InputError
from urdf_text import joint, two_joints, write
from xacro_text import ARM, MANIFEST, XMLNS, as_xacro, lay

PART = f'<robot {XMLNS}><link name="extra"/>{joint("f", "upper", "extra", kind="fixed")}</robot>'
INCLUDE = as_xacro('<xacro:include filename="$(find parts)/urdf/part.xacro"/>')


def refused(path: Path, **load: object) -> list[str]:
    with pytest.raises(DescriptionError) as caught:
        load_arm(path, **load)  # type: ignore[arg-type]
    return [one.code for one in caught.value.findings]


def codes(arm: Arm) -> list[str]:
    return [one.code for one in arm.findings if one.code.startswith("package")]


@pytest.mark.parametrize(
    ("arm", "part"),
    [
        ("arm/urdf/arm.xacro", "folder_of_another_name"),
        ("ws/src/arm/urdf/arm.xacro", "ws/src/parts"),
        ("ws/install/arm/share/arm/urdf/arm.xacro", "ws/install/parts/share/parts"),
    ],
)
@pytest.mark.parametrize("manifest", [True, False])
def test_a_package_near_the_file(arm: str, part: str, manifest: bool, tmp_path: Path) -> None:
    """By its package.xml, else by the name of its folder, which is then a finding."""
    path = lay(tmp_path, {arm: INCLUDE, f"{part}/urdf/part.xacro": PART}) / arm
    if manifest:
        lay(tmp_path, {f"{part}/package.xml": MANIFEST("parts")})
    if not manifest and "another" in part:
        assert refused(path) == ["package-needed-not-found"]
        return
    loaded = load_arm(path, tip="tool0")
    assert "extra" in loaded.frame_names
    assert codes(loaded) == ([] if manifest else ["package-without-manifest"])


def test_a_package_far_from_the_file_is_given(tmp_path: Path) -> None:
    far = "elsewhere/repository/parts"
    path = lay(tmp_path, {"a/b/c/d/e/f/g/h/i/arm.xacro": INCLUDE, f"{far}/urdf/part.xacro": PART})
    path /= "a/b/c/d/e/f/g/h/i/arm.xacro"
    assert refused(path) == ["package-needed-not-found"]
    for folder in ("elsewhere", "elsewhere/repository", far):
        assert "extra" in load_arm(path, tip="tool0", package_dirs=[tmp_path / folder]).frame_names


@pytest.mark.parametrize("name", ["link", ".hidden", "..", "bare"])
def test_no_other_folder_is_taken_for_a_package(name: str, tmp_path: Path) -> None:
    """Not a link, nor a folder that does not look like a robot's package."""
    text = as_xacro(f'<xacro:include filename="$(find {name})/part.xacro"/>').replace("part.xacro", "x/part.xml")
    lay(tmp_path, {"ws/arm/arm.xacro": text, "far/x/part.xml": PART, "ws/bare/x/part.xml": PART})
    lay(tmp_path, {"ws/.hidden/x/part.xml": PART, "ws/x/part.xml": PART})
    (tmp_path / "ws" / "link").symlink_to(tmp_path / "far")
    assert refused(tmp_path / "ws" / "arm" / "arm.xacro") == ["package-needed-not-found"]


def test_neither_the_home_folder_nor_what_stands_beside_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    home = tmp_path / "home" / "me"
    path = lay(home, {"arm/arm.xacro": "", "urdf/part.xacro": PART, "../you/urdf/part.xacro": PART}) / "arm/arm.xacro"
    monkeypatch.setenv("HOME", str(home))
    for name in ("me", "you", "home"):
        path.write_text(INCLUDE.replace("parts", name))
        for folders in ((), (home,), (home.parent,)):
            assert refused(path, package_dirs=folders) == ["package-needed-not-found"]


@pytest.mark.parametrize("variable", ["ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"])
def test_packages_of_the_environment(variable: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "prefix" / ("share/x" if variable == "AMENT_PREFIX_PATH" else "x")
    lay(folder, {"package.xml": MANIFEST("named")})
    monkeypatch.setenv(variable, os.pathsep.join(["nowhere", str(tmp_path / "prefix")]))
    index = package_index(tmp_path / "file" / "deep" / "arm.urdf")
    assert index.find("named") == folder
    assert index.find("other") is None


@pytest.mark.parametrize("sourced", [True, False])
def test_a_workspace_of_links(sourced: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`colcon build --symlink-install`: share/NAME holds links into the sources, which may be links themselves."""
    sources, install = tmp_path / "ws/src", tmp_path / "ws/install"
    include = '<xacro:include filename="$(find parts)/urdf/part.xacro"/>'
    text = as_xacro(f'{include}<xacro:include filename="own.xacro"/>')
    lay(sources / "arm", {"package.xml": MANIFEST("arm"), "urdf/arm.xacro": text, "urdf/own.xacro": "<robot/>"})
    real = tmp_path / "repositories/parts" if sourced else sources / "parts"
    lay(real, {"package.xml": MANIFEST("parts"), "urdf/part.xacro": PART})
    if sourced:
        (sources / "parts").symlink_to(real)
    for name, files in {"arm": ("arm.xacro", "own.xacro"), "parts": ("part.xacro",)}.items():
        share = lay(install / name / "share" / name, {"urdf/x": ""})
        (share / "package.xml").symlink_to(sources / name / "package.xml")
        for file in files:
            (share / "urdf" / file).symlink_to(sources / name / "urdf" / file)
    path = install / "arm/share/arm/urdf/arm.xacro"
    if sourced:
        assert refused(path, package_dirs=[install]) == ["file-outside-packages"]
        monkeypatch.setenv("AMENT_PREFIX_PATH", str(install / "parts"))
    assert "extra" in load_arm(path, tip="tool0", package_dirs=[install]).frame_names


def test_the_name_in_a_package_xml(tmp_path: Path) -> None:
    for text, name in (
        ("<package><name> arm </name></package>", "arm"),
        ("<!DOCTYPE package><package><name>a</name></package>", None),
        (f"<package>{' ' * 2_000_000}<name>arm</name></package>", None),
        ("<package><export><name>arm</name></export></package>", None),
    ):
        (tmp_path / "package.xml").write_text(text)
        assert package_name(tmp_path) == name
    (tmp_path / "package.xml").unlink()
    os.mkfifo(tmp_path / "package.xml")
    assert package_name(tmp_path) is None


# -- packages to do without ----------------------------------------------------------------------------------------

CAMERA_FILE = '<xacro:include filename="$(find realsense2_description)/urdf/_d435.urdf.xacro"/>'
CAMERA = '<xacro:sensor_d435 parent="tool0"><origin xyz="0 0 0"/></xacro:sensor_d435>'
LEFT_OUT = {
    "a camera's macro with a block": (CAMERA_FILE + CAMERA, 2),
    "an include in an included file": ('<xacro:include filename="camera.xacro"/><xacro:camera/>', 2),
    "a macro called by its name": (CAMERA_FILE + '<xacro:call macro="sensor_${\'d435\'}" parent="tool0"/>', 2),
    "a call inside another": (CAMERA_FILE + "<xacro:mount><xacro:sensor_d435/></xacro:mount>", 2),
    "parameters in YAML": ("<a b=\"${xacro.load_yaml('$(find realsense2_description)/c.yaml')}\"/>", 1),
    "a path instead of $(find …)": ('<xacro:include filename="../../realsense2_description/urdf/d435.xacro"/>', 1),
    "several files by a wildcard": (CAMERA_FILE.replace("_d435", "*") + CAMERA, 2),
}
"""The contents of the arm's file, and how many parts are left out."""


@pytest.mark.parametrize("case", LEFT_OUT)
def test_what_an_ignored_package_would_have_brought_is_left_out(case: str, tmp_path: Path) -> None:
    inside, count = LEFT_OUT[case]
    write(
        tmp_path,
        f'<robot {XMLNS}>{CAMERA_FILE}<xacro:macro name="camera">{CAMERA}</xacro:macro></robot>',
        "camera.xacro",
    )
    path = write(tmp_path, as_xacro(inside), "arm.xacro")
    with pytest.raises(DescriptionError):
        load_arm(path, tip="tool0")
    arm = load_arm(path, tip="tool0", ignore_packages=["realsense2_description"])
    np.testing.assert_array_equal(arm.screws, load_arm(write(tmp_path, ARM)).screws)
    assert codes(arm) == ["package-left-out"] * count


def test_an_unknown_package_matters_only_where_a_file_of_it_is_opened(tmp_path: Path) -> None:
    path = write(tmp_path, as_xacro("<gazebo><a>$(find absent)/config.yaml</a></gazebo>"), "arm.xacro")
    (one,) = load_arm(path).findings
    assert one.code == "package-not-found"
    assert "absent" in one.what


def test_what_the_arm_itself_needs_is_refused_as_before(tmp_path: Path) -> None:
    for inside, code in (
        ('<xacro:if value="${d435_used}"><link name="a"/></xacro:if>', "xacro-failed"),
        (joint("lens", "camera_link", "lens", kind="fixed") + '<link name="lens"/>', "not-a-tree"),
        ("<gazebo a=\"${xacro.load_yaml('/etc/hostname')}\"/>", "file-outside-packages"),
        ("<gazebo a=\"${xacro.load_yaml('$(find other)/a.yaml')}\"/>", "package-needed-not-found"),
    ):
        path = write(tmp_path, as_xacro(CAMERA_FILE + CAMERA + inside), "arm.xacro")
        assert code in refused(path, tip="tool0", ignore_packages=["realsense2_description"])


@pytest.mark.parametrize("bad", [" ", "a/b", "..", 3, ["a", ""], [["a"]]])
def test_what_is_no_name_of_a_package_is_refused(bad: object, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="ignore_packages"):
        load_arm(write(tmp_path, ARM), ignore_packages=bad)  # type: ignore[arg-type]


def test_what_to_type_works_when_typed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each error ends in the options that answer it: followed one after the other, they load the arm."""
    arguments = '<gazebo reference="$(arg side)$(arg model)"/><xacro:arg name="side" default="left one"/>'
    path = write(tmp_path, as_xacro(arguments + CAMERA_FILE + CAMERA), "arm.xacro")
    typed: list[str] = []
    for _ in range(2):
        assert run(["info", str(path), *typed]) == 2
        options = re.search("--(xacro|ignore-package) .*", capsys.readouterr().err)
        assert options
        typed += shlex.split(options.group())
    assert typed == [
        *("--xacro", "side:=left one", "--xacro", "model:=VALUE"),
        *("--ignore-package", "realsense2_description"),
    ]
    assert run(["init", str(path), "-o", str(tmp_path / "arm.toml"), *typed]) == 0
    assert codes(load_arm(tmp_path / "arm.toml")) == ["package-left-out"] * 2
    assert "package-left-out" in [one.code for one in diagnose(tmp_path / "arm.toml")]


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
    return read_description(path, ReadOptions(**load)).links["upper"].visuals[0].mesh  # type: ignore[arg-type]


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
