"""What is drawn: where everything stands, sticks for lost meshes, meshes as they were made, and a second arm."""

from __future__ import annotations

import base64
import gzip
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
import umsgpack
from numpy.testing import assert_allclose

from catalogue import load
from twistarm import Arm, InputError, Viewer, arm_from_screws, available_arms, joints, load_arm
from twistarm.description.meshes import Part, read_mesh
from twistarm.support.errors import DescriptionError
from twistarm.viewer.parts.theory import axes
from twistarm.viewer.scene import links
from twistarm.viewer.scene.arm_drawing import Drawing, anchors
from twistarm.viewer.stage import Stage
from urdf_text import joint, write
from viewer_page import ROUNDING, THETA, Page, matrix, stored, visit


def drawn_by(scene: Drawing) -> dict[str, Any]:
    """What is on show once every message has been followed: objects by their nodes."""
    shown: dict[str, Any] = {}
    for message in map(umsgpack.unpackb, filter(None, scene.objects)):
        if message["type"] == "delete":
            shown = {path: each for path, each in shown.items() if not path.startswith(f"{message['path']}/")}
        else:
            shown[message["path"]] = message["object"]
    return shown


def test_a_new_page_is_told_the_arm_the_scene_and_where_everything_stands(arm: Arm, viewer: Viewer) -> None:
    page = visit(viewer)
    hello, frame = page.latest["hello"], page.latest["frame"]
    assert [joint["name"] for joint in hello["arm"]["joints"]] == ["yaw", "pitch", "slide"]
    assert [joint["unit"] for joint in hello["arm"]["joints"]] == ["rad", "rad", "m"]
    assert hello["arm"]["joints"][0]["limits"] == [None, None]
    assert_allclose(hello["arm"]["joints"][0]["range"], [-np.pi, np.pi])
    assert hello["arm"]["joints"][2]["range"] == [0, 0.2]
    assert [joint["name"] for joint in hello["arm"]["others"]] == ["finger"]
    assert list(hello["arm"]["poses"].items()) == [("ready", arm.ready.tolist()), ("zero", [0.0] * 3)]
    notes = ["meshes not found, drawn as simple shapes: 'a/b <i>'"]
    drawn = {"objects": len(page.objects), "left": 0, "exact": False, "simplified": False, "notes": notes}
    assert page.latest["scene"] == {"type": "scene"} | drawn
    assert frame["theta"] == list(THETA)
    assert frame["others"] == {"finger": 0.01}
    assert set(hello["links"]) == set(arm.description.links if arm.description else ())
    assert {*hello["links"].values(), "/frames/tool"} <= set(hello["kinematics"]["nodes"])


def test_arms_without_a_description_are_drawn_from_points_of_axes_nearest_to_the_one_before() -> None:
    """By hand: z through (1, 0, 0); x through (0, 2, 3), whose point nearest to (1, 0, 0) is (1, 2, 3); a slide; and
    y through (−4, 9, 5), whose point nearest to the last is (−4, 2, 5)."""
    screws = np.column_stack(
        [
            joints.revolute([0, 0, 1], [1, 0, 0]),
            joints.revolute([-1, 0, 0], [0, 2, 3]),
            joints.prismatic([0, 0, 1]),
            3.0 * joints.helical([0, 1, 0], [-4, 9, 5], 0.05),
        ]
    )
    home = np.eye(4)
    home[:3, 3] = [1, 2, 4]
    arm = arm_from_screws(screws, home)
    points = [[1, 0, 0], [1, 2, 3], [1, 2, 3], [-4, 2, 5]]
    assert_allclose(anchors(arm), points, atol=ROUNDING)
    scene = Drawing(arm).whole()
    assert scene.notes == ()
    hello = Stage(arm).hello(scene.links)
    assert {"/arm/rod:0", "/arm/rod:1", "/arm/rod:2", "/frames/tool"} <= set(hello["kinematics"]["nodes"])
    assert hello["arm"]["screws"] == ["helical", "prismatic", "revolute"]
    drawn = drawn_by(scene)
    assert {"/arm/rod:0/rod", "/arm/rod:1/rail"} <= set(drawn)
    for i, point in enumerate(points):
        path = "/arm/rod:base" if i == 0 else f"/arm/rod:{i - 1}"
        origin = matrix(drawn[f"{path}/origin"]["object"]["matrix"])[:3, 3]
        assert_allclose(origin, [0, 0, 0] if i == 0 else points[i - 1], atol=ROUNDING)
        tip = np.array(axes(arm)["joints"][i]["tip"]) - point
        assert_allclose(np.abs(tip) / np.linalg.norm(tip), np.abs([[0, 0, 1], [1, 0, 0], [0, 0, 1], [0, 1, 0]][i]))


def test_a_cylinder_stands_along_z_and_shapes_stand_in_for_a_lost_mesh(arm: Arm) -> None:
    drawn = drawn_by(Drawing(arm).whole())
    upper = drawn["/arm/link:upper/visual0"]
    assert upper["geometries"][0]["type"] == "CylinderGeometry"
    placed = matrix(upper["object"]["matrix"])
    assert_allclose(placed @ [0, 0.2, 0, 1], [0, 0, 0.4, 1], atol=ROUNDING)  # three.js's top end, at URDF's
    red = drawn["/arm/link:base_link/visual0"]["materials"][0]
    assert (red["color"], red["opacity"], red["transparent"]) == (0xFF0000, 0.5, True)

    # A link without its mesh is a frame and a capsule.
    stick = drawn["/arm/link:a%2Fb%20%3Ci%3E/stand-in/stick0"]
    assert_allclose(stick["geometries"][0]["height"], 0.3)
    assert_allclose(matrix(stick["object"]["matrix"])[:3, 3], [0.15, 0, 0], atol=ROUNDING)
    end = drawn["/arm/link:a%2Fb%20%3Ci%3E/stand-in/end0"]
    assert_allclose(matrix(end["object"]["matrix"])[:3, 3], [0.3, 0, 0], atol=ROUNDING)
    assert "/arm/link:a%2Fb%20%3Ci%3E/frame/x/solid-shaft" in drawn
    assert not any(path.startswith("/arm/link:left/frame") for path in drawn)  # which never had a mesh


def arm_of(folder: Path, base: str, tip: str = "") -> Arm:
    """Two links and what is drawn of them."""
    links = f'<link name="base">{base}</link><link name="tip">{tip}</link>'
    return load_arm(write(folder, f'<robot name="r">{links}{joint("j", "base", "tip", "continuous")}</robot>'))


def load_parts(path: Path) -> list[Part]:
    return read_mesh(path).parts()


def test_every_material_of_a_collada_file_is_a_part_of_its_own_colour() -> None:
    if "ur5" not in available_arms():
        pytest.skip("example-robot-data is not installed")
    description = load_arm("ur5").description
    assert description is not None
    path = description.links["forearm_link"].visuals[0].mesh
    assert path is not None
    parts = load_parts(path)
    assert len(parts) == 4
    assert len({part.colour for part in parts}) == 3


GREEN = '<material name="m"><color rgba="0 1 0 1"/></material>'

FACES = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl red\nf 1 2 3\nusemtl blue\nf 1 2 4\n"


def test_a_mesh_is_scaled_mirrored_and_coloured_as_the_description_has_it(tmp_path: Path) -> None:
    (tmp_path / "part.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    turned = '<origin xyz="0 0 1" rpy="0 0 1.5707963267948966"/>'
    mesh = '<geometry><mesh filename="part.obj" scale="-0.5 2 1"/></geometry>'
    drawn = drawn_by(Drawing(arm_of(tmp_path, f"<visual>{turned}{mesh}{GREEN}</visual>")).whole())
    part = drawn["/arm/link:base/visual0/part0"]
    placed = matrix(part["object"]["matrix"])
    assert_allclose(placed @ [1, 0, 0, 1], [0, -0.5, 1, 1], atol=ROUNDING)
    assert_allclose(placed @ [0, 1, 0, 1], [-2, 0, 1, 1], atol=ROUNDING)
    assert part["materials"][0]["color"] == 0x00FF00


def test_a_file_s_own_colours_come_before_the_description_s_placeholder(tmp_path: Path) -> None:
    (tmp_path / "part.obj").write_text("mtllib two.mtl\n" + FACES)
    without = load_parts(tmp_path / "part.obj")  # its file of colours is not there yet
    assert (len(without), {part.colour for part in without}) == (2, {None})
    (tmp_path / "two.mtl").write_text("newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n")
    (tmp_path / "plain.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    visuals = [f'<visual><geometry><mesh filename="{name}.obj"/></geometry>{colour}</visual>' for name, colour in [
        ("part", GREEN), ("plain", GREEN), ("plain", "")]]  # fmt: skip
    objects = drawn_by(Drawing(arm_of(tmp_path, "".join(visuals))).whole())
    drawn = {path: each["materials"][0]["color"] for path, each in objects.items() if "materials" in each}
    colours = [{drawn[path] for path in drawn if path.startswith(f"/arm/link:base/visual{i}/")} for i in range(3)]
    assert colours == [{0xFF0000, 0x0000FF}, {0x00FF00}, {0x9EA8B8}]  # 158, 168, 184: a light grey


def test_whatever_ails_one_mesh_the_others_are_drawn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("good", "bad"):
        trimesh.creation.box((0.1, 0.1, 0.1)).export(tmp_path / f"{name}.stl")
    (tmp_path / "torn.stl").write_text("no mesh at all")
    with pytest.raises(DescriptionError, match="cannot read mesh"):
        load_parts(tmp_path / "torn.stl")
    mesh = '<visual><geometry><mesh filename="{}.stl"/></geometry></visual>'
    arm = arm_of(tmp_path, mesh.format("bad") + mesh.format("good"), mesh.format("bad") + mesh.format("torn"))
    monkeypatch.setattr(links, "read_mesh", lambda path: 1 / 0 if path.stem == "bad" else read_mesh(path))
    scene = Drawing(arm).whole()
    assert (scene.left, len(scene.notes)) == (0, 2)
    assert "bad.stl: division by zero" in scene.notes[0]
    assert re.search(r"cannot read mesh torn\.stl: .*; export it as STL, OBJ, DAE, PLY or GLB", scene.notes[1])
    drawn = drawn_by(scene)
    assert "/arm/link:base/visual1/part0" in drawn
    assert not any("visual0" in path for path in drawn)


MESH = """<robot name="two"><link name="base"/>
<link name="part"><visual><geometry><mesh filename="{}"/></geometry></visual></link>
<joint name="turn" type="revolute"><parent link="base"/><child link="part"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"""


def test_every_shape_of_the_second_arm_is_below_its_node(tmp_path: Path) -> None:
    trimesh.creation.box((0.1, 0.2, 0.3)).export(tmp_path / "part.stl")
    (tmp_path / "arm.urdf").write_text(MESH.format(tmp_path / "part.stl"))
    arm = load_arm(tmp_path / "arm.urdf", tip="part")
    alone = {path: each for path, each in drawn_by(Drawing(arm).whole()).items() if path.startswith("/arm/")}
    assert any("/part0" in path for path in alone), "the mesh was read"
    scene = Drawing(arm, beside=arm)
    assert scene.left == 2
    for exact in (False, True):
        both = drawn_by(scene.whole())
        assert {path for path in both if path.startswith("/beside/")} == {f"/beside{path}" for path in alone}
        assert {path for path in both if path.startswith("/arm/")} == set(alone)
        scene.draw_again(exact)
    assert all(b"/beside/" not in each for each in scene.whole().successor(arm).whole().objects)


@pytest.mark.parametrize("name", ["ur5", "rr_planar"])
def test_live_pages_alone_show_both(rover: Any, name: str, tmp_path: Path) -> None:
    other = load(name)
    with Viewer(rover, open_browser=False, beside=other) as viewer:
        with Page(viewer) as page:
            page.until(lambda: page.latest.get("scene", {}).get("left") == 0)
            page.until(lambda: len(page.objects) == page.latest["scene"]["objects"])
        hello = page.latest["hello"]["beside"]
        assert hello["arm"]["name"] == other.name
        assert hello["theta"] == other.ready.tolist()
        nodes = {f"/beside{path}/" for path in hello["kinematics"]["nodes"] if path.startswith("/arm/")}
        drawn = [each["path"] for each in page.objects if each["path"].startswith("/beside/")]
        assert len(drawn) > 2
        assert sum(path.startswith(tuple(nodes)) for path in drawn) > 1, "they stand in nodes that move"
        saved = stored(viewer.save_html(tmp_path / "page.html").read_text("utf-8"))
        assert saved["hello"]["beside"] == hello
        assert gzip.decompress(base64.b64decode(saved["objects"])).count(b"/beside/") == len(drawn)
        with pytest.raises(InputError):
            Viewer(rover, open_browser=False, beside="ur5")  # type: ignore[arg-type]
    with Viewer(rover, open_browser=False) as viewer:
        assert visit(viewer).latest["hello"]["beside"] is None
