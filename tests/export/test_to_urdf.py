"""Arms of every origin as a URDF: it loads back as the same arm, by Pinocchio's own reading too."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pinocchio
import pytest

from twistarm import Arm, ArmBuilder, InputError, arm_from_dh, arm_from_screws, bake, joints, load_arm, screws, to_urdf
from twistarm.cli.application import run
from twistarm.description.tree import Geometry
from twistarm.support.files import WRITTEN_XML, write_whole
from urdf_text import two_joints, write
from xacro_text import MANIFEST, lay

TOL = 1e-12
MJCF = Path(__file__).parents[1] / "data" / "mjcf"


def came_back(arm: Arm, folder: Path, name: str = "copy.urdf") -> Arm:
    (folder / name).write_text(to_urdf(arm, folder), encoding="utf-8")
    meshes = [] if arm.description is None or arm.description.path is None else [arm.description.path.parent]
    return load_arm(folder / name, base=arm.base, tip=arm.tip, package_dirs=meshes)


def test_a_urdf_of_ours_is_replaced_by_the_next(tmp_path: Path) -> None:
    arm = load_arm(MJCF / "ball.xml")
    came_back(arm, tmp_path)
    again = to_urdf(came_back(arm, tmp_path), tmp_path)
    assert write_whole(tmp_path / "copy.urdf", again).read_text() == again
    assert again.count(WRITTEN_XML) == 1


def test_bake_tells_which_meshes_the_copy_does_not_find(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = '<link name="upper"><visual><geometry><mesh filename="package://arm/a.stl"/></geometry></visual></link>'
    lay(tmp_path / "ws/arm", {"package.xml": MANIFEST("arm"), "a.stl": "solid"})
    path = str(write(tmp_path / "ws/arm", two_joints().replace('<link name="upper"/>', mesh)))
    (tmp_path / "far").mkdir()
    for folder, lost in (("ws/arm", []), ("far", ["package://arm/a.stl"])):
        assert run(["bake", path, "-o", str(tmp_path / folder / "copy.urdf"), "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["meshes_not_found"] == lost


def require_same(arm: Arm, other: Arm) -> None:
    assert other.joint_names == arm.joint_names
    for field in ("lower", "upper", "velocity", "effort"):
        np.testing.assert_allclose(getattr(other.limits, field), getattr(arm.limits, field), rtol=TOL, err_msg=field)
    theta = arm.random_theta(0, 30)
    np.testing.assert_allclose(other.fk(theta), arm.fk(theta), atol=TOL)
    np.testing.assert_allclose(other.spatial_jacobian(theta), arm.spatial_jacobian(theta), atol=TOL)


@pytest.mark.parametrize("path", sorted(MJCF.glob("*.xml")), ids=lambda path: path.stem)
def test_an_mjcf_comes_back(path: Path, tmp_path: Path) -> None:
    arm = load_arm(path)
    again = came_back(arm, tmp_path)
    require_same(arm, again)
    ours, theirs = (one.description.links for one in (arm, again))
    shapes = ("shape", "size", "mesh", "colour")
    for link in ours:
        if any(shape.shape == "capsule" for shape in (*ours[link].visuals, *ours[link].collisions)):
            continue
        for one, other in zip(ours[link].visuals, theirs[link].visuals, strict=True):
            assert [getattr(one, word) for word in shapes] == [getattr(other, word) for word in shapes]
    if not arm.couplings.keys() - set(arm.joint_names):  # Pinocchio reads mimics only if asked
        model = pinocchio.buildModelFromXML((tmp_path / "copy.urdf").read_text())
        assert [str(name) for name in model.names][1:] == list(arm.joint_names)


def test_other_readers_get_all_shapes_and_no_standstill(tmp_path: Path) -> None:
    """urdfdom drops all shapes of a file for one material without a name, and takes a velocity of 0 at its word."""
    arms = (
        load_arm(MJCF / "masses.xml"),
        arm_from_dh([[0.3, 1.2, 0.1, 0.4]], "modified", limits={"upper": {"joint1": 1}}),
    )
    for arm in arms:
        (tmp_path / "copy.urdf").write_text(text := to_urdf(arm, tmp_path))
        model, shapes, _ = pinocchio.buildModelsFromUrdf(str(tmp_path / "copy.urdf"), str(tmp_path))
        assert len(shapes.geometryObjects) == text.count("<collision")
        assert (model.velocityLimit > 0).all()
        for limit in re.findall(r"<limit[^>]*>", text):
            assert 'velocity="0' not in limit
            assert "1e+300" not in limit
    assert text.count("<limit") == 1
    assert to_urdf(arms[0]).count("<collision") > 3


def holds(body: Geometry, points: np.ndarray) -> np.ndarray:
    """Whether each point (n, 3) in the link frame is inside a capsule, cylinder or sphere."""
    x, y, z = ((points - body.origin[:3, 3]) @ body.origin[:3, :3]).T
    radius, half = body.size[0], body.size[-1] / 2 if len(body.size) > 1 else 0.0
    beyond = np.maximum(np.abs(z) - half, 0.0)
    return (
        (x**2 + y**2 <= radius**2) & (beyond == 0) if body.shape == "cylinder" else x**2 + y**2 + beyond**2 <= radius**2
    )


def test_a_capsule_is_written_for_readers_that_have_none(tmp_path: Path) -> None:
    place, size = '<origin xyz="0.1 0 0.2" rpy="0 1.2 0.3"/>', '<capsule radius="0.1" length="0.3"/>'
    shape = f'<link name="tool0"><collision name="finger">{place}<geometry>{size}</geometry></collision></link>'
    arm = load_arm(write(tmp_path, two_joints().replace('<link name="tool0"/>', shape)))
    again = came_back(arm, tmp_path)
    require_same(arm, again)
    (capsule,), parts = (one.description.links["tool0"].collisions for one in (arm, again))
    assert {shape.shape for shape in parts} == {"cylinder", "sphere"}
    points = np.random.default_rng(0).uniform(-0.2, 0.5, (20_000, 3))
    inside = holds(capsule, points)
    assert 500 < inside.sum() < 5_000
    np.testing.assert_array_equal(np.any([holds(shape, points) for shape in parts], axis=0), inside)


def test_screws_come_back(tmp_path: Path) -> None:
    columns = [
        joints.revolute([0, 1, 1], [0.1, 0, 0.3]),
        joints.helical([0, 0, 1], [0.2, 0, 0], 0.02),
        joints.prismatic([1, 0, 1]),
        joints.revolute([1, 0, 0], [0, 0.4, 0.5]),
    ]
    home = np.eye(4)
    home[:3, 3] = 0.3, 0.2, 0.9
    limits = {"lower": [-1, -20, 0, -2], "upper": [2, 20, 0.4, 2], "velocity": [1, 2, 0.1, 3]}
    arm = arm_from_screws(np.hstack(columns), home, joints=["a", "b", "c", "d"], limits=limits)
    require_same(arm, came_back(arm, tmp_path))


@pytest.mark.parametrize("name", ["rover_arm", "rover_arm_6dof", "panda"])
def test_a_baked_arm_comes_back(name: str, tmp_path: Path) -> None:
    arm = load_arm(name)
    bake(arm, tmp_path / "arm.json")
    baked = load_arm(tmp_path / "arm.json")
    require_same(arm, came_back(baked, tmp_path))


def test_dh_and_builder_come_back(tmp_path: Path) -> None:
    for arm in (
        arm_from_dh([[0.3, 1.2, 0.1, 0.4], [0.2, -0.5, 0.3, 0.0]], "modified", limits={"upper": {"joint1": 1.0}}),
        ArmBuilder("thread").helical("a", [0, 0, 1], [0, 0, 0], 0.1).planar("p", [0, 1, 1]).tool(np.eye(4)).build(),
    ):
        require_same(arm, came_back(arm, tmp_path))


def test_locks_limits_and_tools_are_kept(tmp_path: Path) -> None:
    """Of xacro with a locked slide, an arm.toml's limits, and a tool of the caller's."""
    arm = load_arm("rover_arm", locked_joints={"slide": 0.1}, limits={"upper": {"elbow": 1.25}, "velocity": 0.5})
    arm = arm.with_tool(screws.exp([0.1, -0.2, 0.3, 0.4, 0.5, -0.6]), "pen")
    require_same(arm, came_back(arm, tmp_path))


def test_limits_of_a_continuous_joint_are_kept(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(two_joints(inside="", kind="continuous"))
    arm = load_arm(tmp_path / "arm.urdf", limits={"lower": -1.0, "upper": 1.5})
    require_same(arm, came_back(arm, tmp_path))


def test_twists_that_urdf_lacks_are_refused() -> None:
    with pytest.raises(InputError, match="no unit twist"):
        to_urdf(arm_from_screws(3.0 * joints.revolute([0, 0, 1], [1, 0, 0]), np.eye(4)))
