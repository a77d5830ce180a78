"""The repaired copy: every safe repair, nothing else touched, and the copy the same robot to Pinocchio too."""

from __future__ import annotations

from pathlib import Path

import pinocchio
import pytest

from twistarm import InputError
from twistarm.checking.doctor.repair import Repair, difference, repair
from twistarm.description.urdf import ReadOptions, read_description
from urdf_text import joint, robot, two_joints, write


def written(path: Path, copy: Path, options: ReadOptions = ReadOptions()) -> Repair:  # noqa: B008
    """What was done; its text is the file `copy` afterwards."""
    made = repair(read_description(path, options), copy)
    copy.write_text(made.text, "utf-8")
    return made


def repaired(folder: Path, text: str, name: str = "arm.urdf") -> tuple[str, Repair]:
    """The copy's text and what was done; the original is as it was."""
    path = write(folder, text, name)
    before = path.read_bytes()
    made = written(path, folder / "copy.urdf")
    assert path.read_bytes() == before
    return made.text, made


MESH = '<visual><geometry><mesh filename="$(find our_arm)/x.stl" scale="0.001"/></geometry></visual>'
BODY = '<inertial><mass value="1kg"/></inertial>'
STILL = joint("f", "tool0", "x", kind="fixed", inside='<axis xyz="0 0 0"/>')


def on_upper(inside: str) -> str:
    return two_joints().replace('<link name="upper"/>', f'<link name="upper">{inside}</link>')


REPAIRS = {
    "an axis is normalised": (two_joints(inside='<axis xyz="0 0 2"/>'), ['<axis xyz="0.0 0.0 1.0"/>'], 1),
    "a hinge without bounds is continuous": (
        two_joints(inside='<limit velocity="2" effort="3"/>'),
        ['<joint name="a" type="continuous">', '<limit velocity="2" effort="3"/>'],
        1,
    ),
    "rates that are missing or negative become 0": (
        two_joints(inside='<limit lower="-1" upper="1" effort="-1"/>'),
        ['<limit lower="-1" upper="1" effort="0" velocity="0"/>'],
        2,
    ),
    "a zero axis on a fixed joint goes": (
        robot(joint("a", "base_link", "tool0"), STILL, links=("base_link", "tool0", "x")),
        ['<origin xyz="0 0 0.5" rpy="0 0 0"/></joint></robot>'],
        1,
    ),
    "find becomes package": (
        on_upper(MESH), ['<mesh filename="package://our_arm/x.stl" scale="0.001 0.001 0.001"/>'], 2
    ),
    "an inertia that is none goes": (on_upper(BODY), ['<link name="upper"></link>'], 1),
}  # fmt: skip
"""A description, what its copy holds, and the number of changes."""


@pytest.mark.parametrize("case", REPAIRS)
def test_safe_repairs(case: str, tmp_path: Path) -> None:
    text, there, count = REPAIRS[case]
    copy, made = repaired(tmp_path, text)
    assert len(made.changes) == count
    assert all(part in copy for part in there)
    assert made.complaint == ""
    assert pinocchio.buildModelFromXML(copy).nq >= 1
    one, other = read_description(tmp_path / "arm.urdf"), read_description(tmp_path / "copy.urdf")
    assert difference(one, other) == ""
    assert "axis-not-unit" not in [noted.code for noted in other.findings]


UNTOUCHED = """<?xml version="1.0"?>
<!-- drawn by hand -->
<robot name="tiny" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <link name="base_link"/>   <!-- a > in a comment -->
  <joint name='a'  type = "revolute">
    <parent link="base_link"/> <child link="tool0"/>
    <axis  xyz='0 0  3'   />
    <limit lower="-170" upper="170" velocity="1" effort="1"/>
  </joint>
  <link name="tool0"><visual name="a &gt; b > c"><geometry><sphere radius="1"/></geometry></visual></link>
  <transmission name="t"><type>x</type></transmission>
</robot>
"""


def test_everything_else_stays_as_it_was_written(tmp_path: Path) -> None:
    copy, made = repaired(tmp_path, UNTOUCHED)
    assert copy == UNTOUCHED.replace("xyz='0 0  3'", 'xyz="0.0 0.0 1.0"')
    assert made.changes == ("joint 'a': axis 0 0  3 normalised",)


def test_another_encoding_becomes_utf_8(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_bytes(
        two_joints().replace('"1.0"', '"1.0" encoding="iso-8859-1"', 1).replace("tiny", "Kühn").encode("latin-1")
    )
    assert 'encoding="utf-8"?>' in written(path, tmp_path / "copy.urdf").text
    assert read_description(tmp_path / "copy.urdf").name == "Kühn"


def test_xacro_is_written_expanded(tmp_path: Path) -> None:
    text = two_joints(inside='<axis xyz="0 0 ${1 + 1}"/>').replace(
        "<robot ", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" '
    )
    copy, made = repaired(tmp_path, text, "arm.urdf.xacro")
    assert made.changes == ("joint 'a': axis 0 0 2 normalised",)
    assert "${" not in copy
    assert difference(read_description(tmp_path / "arm.urdf.xacro"), read_description(tmp_path / "copy.urdf")) == ""


def test_meshes_are_found_from_another_folder(tmp_path: Path) -> None:
    (tmp_path / "arm").mkdir()
    (tmp_path / "arm" / "part.stl").write_text("solid\nendsolid\n")
    shape = '<visual><geometry><mesh filename="part.stl"/></geometry></visual>'
    path = write(tmp_path / "arm", two_joints().replace('<link name="upper"/>', f'<link name="upper">{shape}</link>'))
    assert written(path, tmp_path / "copy.urdf").changes == ("mesh path 'part.stl' made 'arm/part.stl'",)
    assert read_description(tmp_path / "copy.urdf").links["upper"].visuals[0].mesh == tmp_path / "arm" / "part.stl"


def test_a_slide_without_bounds_is_left_to_its_owner(tmp_path: Path) -> None:
    limit = '<limit lower="0" upper="inf" velocity="1" effort="1"/>'
    rail = joint("a", "base_link", "tool0", kind="prismatic", inside=limit)
    text = robot(rail, links=("base_link", "tool0"))
    _, made = repaired(tmp_path, text)
    assert made.changes == ()
    assert "upper" in made.complaint


def test_the_original_is_never_touched(tmp_path: Path) -> None:
    text = two_joints(inside='<axis xyz="0 0 2"/>')
    path = write(tmp_path, text)
    (tmp_path / "link.urdf").symlink_to(path)
    for name in ("arm.urdf", "link.urdf", "copy.xacro", "copy.urdf.xacro", "arm.toml", "copy"):
        with pytest.raises(InputError, match=r"arm\.urdf|link\.urdf|\*\.urdf"):
            repair(read_description(path), tmp_path / name)
    assert path.read_text() == text
    assert sorted(file.name for file in tmp_path.iterdir()) == ["arm.urdf", "link.urdf"]


@pytest.mark.parametrize(
    ("old", "new", "culprit"),
    [
        ('xyz="0 0 0.5"', 'xyz="0 0 0.6"', "0.1"),
        ('lower="-1"', 'lower="-2"', "lower"),
        ('name="upper"', 'name="uper"', "links"),
        ('type="revolute"', 'type="prismatic"', "type"),
    ],
)
def test_a_copy_that_is_another_robot_would_be_seen(old: str, new: str, culprit: str, tmp_path: Path) -> None:
    one = read_description(write(tmp_path, two_joints()))
    text = two_joints().replace(old, new, 1).replace('link="upper"', 'link="uper"' if "uper" in new else 'link="upper"')
    assert culprit in difference(one, read_description(write(tmp_path, text, "other.urdf")))


REAL = (
    ("robojackets_walli_v2_block/urdf/walli_arm_v2_block/robot.urdf", {}),
    ("kortex_description/grippers/gen3_lite_2f/urdf/GEN3-LITE-GRIPPER_URDF_SIMPLIFIED_V2.urdf", {}),
    ("annin_ar4_description/urdf/ar.urdf.xacro", {"ar_model": "mk3"}),
    ("kortex_description/robots/gen3.xacro", {"dof": 7}),
)


@pytest.mark.parametrize(("file", "arguments"), REAL)
def test_real_descriptions_get_a_copy_that_pinocchio_reads(
    file: str, arguments: dict[str, object], models: Path, tmp_path: Path
) -> None:
    options = ReadOptions(xacro_args=arguments)
    description = read_description(models / file, options)
    assert written(models / file, tmp_path / "copy.urdf", options).complaint == ""
    copy = read_description(tmp_path / "copy.urdf", ReadOptions(package_dirs=[models]))
    worth = {"axis-not-unit", "inertial-unusable", "limit-incomplete"}
    assert not worth & {noted.code for noted in copy.findings}
    assert difference(description, copy) == ""
