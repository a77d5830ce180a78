"""Meshes made lighter for the page: as near to the file's as trimesh measures, in the place that stood in for them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose

from test_viewer_scene import drawn_by
from twistarm import load_arm
from twistarm.description.meshes.mesh import shaded, simplified
from twistarm.viewer.scene import links
from twistarm.viewer.scene.arm_drawing import Drawing


def bracket() -> trimesh.Trimesh:
    """A plate of 20 mm, 1 m long, with a ring and a ball on it."""
    solids = [
        trimesh.creation.box((1.0, 0.3, 0.02)),
        trimesh.creation.annulus(0.1, 0.14, 0.2, sections=64),
        trimesh.creation.icosphere(3, 0.1).apply_translation([0.4, 0, 0.1]),
    ]
    joined = trimesh.util.concatenate(solids)
    while len(joined.faces) < 60_000:
        joined = joined.subdivide()
    return joined


@pytest.fixture(scope="module")
def fine() -> trimesh.Trimesh:
    return bracket()


def mesh_of(corners: Any) -> trimesh.Trimesh:
    return trimesh.Trimesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3), process=True)


@pytest.mark.parametrize("most", [20_000, 6_000])
def test_a_simplified_mesh_keeps_area_volume_and_place(fine: trimesh.Trimesh, most: int) -> None:
    coarse = mesh_of(simplified(fine.triangles, most))
    assert 0.6 * most < len(coarse.faces) < 1.25 * most
    assert coarse.area == pytest.approx(fine.area, rel=0.02)
    assert coarse.volume == pytest.approx(fine.volume, rel=0.02)
    assert_allclose(coarse.bounds, fine.bounds, atol=1e-3)
    cell = np.sqrt(4 * fine.area / most)  # two triangles for each cell of the surface, and room for those across edges
    for one, other in ((fine, coarse), (coarse, fine)):
        points, _ = trimesh.sample.sample_surface(one, 400, seed=0)
        assert trimesh.proximity.closest_point(other, points)[1].max() < 0.5 * cell


def test_normals_are_trimesh_s_where_smooth_and_the_faces_at_creases() -> None:
    ball = trimesh.creation.icosphere(3)
    vertices, normals, _ = shaded(ball.triangles)
    order, own = np.lexsort(vertices.T.round(9)), np.lexsort(ball.vertices.T.round(9))
    assert_allclose(vertices[order], ball.vertices[own], atol=1e-9)
    assert_allclose((normals[order] * ball.vertex_normals[own]).sum(axis=1), 1, atol=1e-4)
    can = trimesh.creation.cylinder(1.0, 2.0, sections=32)
    _, normals, faces = shaded(can.triangles)
    caps = np.abs(can.face_normals[:, 2]) > 0.5
    assert_allclose(normals[faces[caps]], np.repeat(can.face_normals[caps][:, None], 3, axis=1), atol=1e-6)
    assert_allclose(normals[faces[~caps]][..., 2], 0, atol=1e-6)
    assert len(np.unique(normals[faces[~caps]].reshape(-1, 3).round(6), axis=0)) == 32  # one for each line of the wall


@pytest.fixture
def heavy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two links of one mesh of 5,120 triangles each, where an arm may have 2,000."""
    monkeypatch.setattr(links, "TRIANGLES", 2_000)
    trimesh.creation.icosphere(4, 0.1).export(tmp_path / "ball.stl")
    visual = '<visual><geometry><mesh filename="ball.stl"/></geometry></visual>'
    box = '<collision><geometry><box size="0.1 0.1 0.3"/></geometry></collision>'
    joint = '<joint name="{0}" type="continuous"><parent link="{1}"/><child link="{2}"/><origin xyz="0 0 0.3"/></joint>'
    (tmp_path / "arm.urdf").write_text(
        f'<robot name="r"><link name="base">{visual}</link><link name="upper">{visual}{box}</link><link name="tip"/>'
        f"{joint.format('a', 'base', 'upper')}{joint.format('b', 'upper', 'tip')}</robot>"
    )
    return tmp_path / "arm.urdf"


def triangles(scene: Drawing) -> dict[str, int]:
    """How many there are of each mesh on show."""
    return {
        path: each["geometries"][0]["data"]["index"]["array"].data.__len__() // 12
        for path, each in drawn_by(scene).items()
        if "part" in path
    }


def test_an_arm_is_simple_shapes_until_its_meshes_are_there(heavy: Path) -> None:
    scene = Drawing(load_arm(heavy))
    before = {path for path in drawn_by(scene) if path.startswith("/arm")}
    assert before >= {"/arm/link:base/stand-in/stick0", "/arm/link:upper/stand-in/solid0"}  # what it collides with
    assert not any("frame" in path for path in before)  # nothing is missing
    scene.draw()
    after = {path for path in drawn_by(scene) if path.startswith("/arm")}
    assert after == {"/arm/link:base/visual0/part0", "/arm/link:upper/stand-in/solid0"}


def test_an_arm_of_too_many_triangles_is_simplified_and_exact_on_demand(heavy: Path) -> None:
    scene = Drawing(load_arm(heavy)).whole()
    few = triangles(scene)
    assert set(few) == {"/arm/link:base/visual0/part0", "/arm/link:upper/visual0/part0"}
    assert all(600 < count < 1300 for count in few.values())
    assert scene.message()["simplified"]
    kept = len(drawn_by(scene))
    scene.draw_again(exact=True)
    assert scene.left == 2
    scene.whole()
    assert set(triangles(scene).values()) == {5120}
    assert len(drawn_by(scene)) == kept
    told = scene.message()
    assert (told["exact"], told["objects"]) == (True, sum(map(bool, scene.objects)))
    scene.draw_again(exact=False)
    assert triangles(scene.whole()) == few
    assert set(triangles(Drawing(load_arm(heavy), exact=True).whole()).values()) == {5120}


def test_a_mesh_that_is_gone_when_it_is_read_again_stays_as_it_was(heavy: Path) -> None:
    scene = Drawing(load_arm(heavy)).whole()
    few = triangles(scene)
    heavy.with_name("ball.stl").unlink()
    scene.draw_again(exact=True)
    assert triangles(scene.whole()) == few
    assert "cannot read mesh" in scene.notes[0]
