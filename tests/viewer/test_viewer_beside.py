"""A second arm in the scene: live pages get its shapes and its kinematics, saved pages neither."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

import pytest
import trimesh

from catalogue import load
from test_viewer_scene import drawn_by
from twistarm import InputError, Viewer, load_arm
from twistarm.viewer.scene.arm_drawing import Drawing
from viewer_page import Page, stored, visit

pytest.importorskip("meshcat")

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
        saved = stored(viewer.save_html(tmp_path / "page.html").read_text("utf-8"))["objects"]
        assert saved
        assert not any(b"/beside/" in base64.b64decode(each) for each in saved)
        with pytest.raises(InputError):
            Viewer(rover, open_browser=False, beside="ur5")  # type: ignore[arg-type]
    with Viewer(rover, open_browser=False) as viewer:
        assert visit(viewer).latest["hello"]["beside"] is None
