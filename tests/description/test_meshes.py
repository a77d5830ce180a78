"""Meshes of every format come to the same triangles; colours and sizes of shapes are those of Pinocchio's parser."""

from __future__ import annotations

import json
import os
import re
import signal
from pathlib import Path

import numpy as np
import pinocchio
import pytest
import trimesh

from twistarm.description.meshes import Mesh, UnreadableMeshError, extreme_points, read_mesh, reading
from twistarm.description.urdf import read_description
from twistarm.support.interrupts import interruptible
from urdf_text import two_joints, write

BOX = trimesh.creation.box((0.1, 0.2, 0.3))
BINARY, TEXT = BOX.export(file_type="stl"), BOX.export(file_type="stl_ascii").encode()
COLLADA = BOX.export(file_type="dae").decode()


def read(folder: Path, name: str, data: bytes | str) -> Mesh:
    (folder / name).write_bytes(data.encode() if isinstance(data, str) else data)
    return read_mesh(folder / name)


def refused(folder: Path, name: str, data: bytes | str) -> str:
    with pytest.raises(UnreadableMeshError) as caught:
        read(folder, name, data)
    assert str(folder) not in str(caught.value)
    return caught.value.reason


@pytest.mark.parametrize("ending", ["STL", "obj", "dae", "ply", "glb", "gltf"])
def test_every_format_comes_to_the_same_box(tmp_path: Path, ending: str) -> None:
    made = BOX.export(file_type=ending.lower())
    for name, content in (made if ending == "gltf" else {f"model.{ending}": made}).items():
        (tmp_path / name).write_bytes(content.encode() if isinstance(content, str) else content)
    mesh = read_mesh(tmp_path / f"model.{ending}")
    (part,) = mesh.parts()
    assert part.faces.shape == (12, 3)
    np.testing.assert_allclose(np.ptp(part.vertices, axis=0), [0.1, 0.2, 0.3], rtol=1e-6)
    np.testing.assert_allclose(np.abs(part.normals).max(axis=1), 1.0, rtol=1e-6)
    assert mesh.length == pytest.approx(0.3)
    points, faces = mesh.solid()
    assert trimesh.Trimesh(points, faces).volume == pytest.approx(0.006)


HEADED = b"solid of an exporter".ljust(80, b"\0") + BINARY[80:]
AS_A_BOX = {
    "bytes behind the last facet": BINARY + b"\n\0trailing",
    "bytes behind it, and a head as of text": HEADED + b"\n",
    "a text": TEXT,
    "a text without its end": TEXT[: TEXT.rindex(b"endsolid")],
    "a text in capitals": TEXT.upper(),
    "a text with space before it": b"\n \n" + TEXT,
}


@pytest.mark.parametrize("case", AS_A_BOX)
def test_an_stl_that_others_read_is_read(case: str, tmp_path: Path) -> None:
    points, faces = read(tmp_path, "a.stl", AS_A_BOX[case]).solid()
    assert trimesh.Trimesh(points, faces).volume == pytest.approx(0.006)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"solid a\nendsolid a\n",
        BINARY[:60],
        BINARY[: 84 + 6 * 50 + 7],
        TEXT[: TEXT.rindex(b"vertex")],
        BINARY[:84] + b"\xff" * 600,
        BINARY[:84] + bytes(600),
    ],
    ids=["nothing", "no facet", "half a head", "half of the facets", "half of a text", "NaN", "one point"],
)
def test_an_stl_without_triangles_is_refused(data: bytes, tmp_path: Path) -> None:
    assert refused(tmp_path, "a.stl", data)


def test_a_unit_of_collada_makes_metres_and_a_mirror_keeps_the_outside_out(tmp_path: Path) -> None:
    text = re.sub(r"<unit[^>]*/>", "", COLLADA).replace("</asset>", '<unit name="mm" meter="0.001"/></asset>')
    text = re.sub(r'(<node [^>]*id="node0"[^>]*>)', r"\1<scale>-1 1 1</scale>", text)
    assert "<scale>" in text
    points, faces = read(tmp_path, "a.dae", text).solid()
    np.testing.assert_allclose(np.ptp(points, axis=0), [1e-4, 2e-4, 3e-4], rtol=1e-6)
    assert trimesh.Trimesh(1e3 * points, faces).volume == pytest.approx(0.006)


def test_a_collada_in_utf_16_is_read(tmp_path: Path) -> None:
    text = re.sub(r"<\?xml[^>]*\?>", '<?xml version="1.0" encoding="UTF-16"?>', COLLADA)
    assert read(tmp_path, "a.dae", text.encode("utf-16")).triangles == 12


GREY = 0.212671 * 0.2 + 0.715160 * 0.4 + 0.072169 * 0.8
TRANSPARENT = '<transparent opaque="{}"><color>0.2 0.4 0.8 0.3</color></transparent>'
OPACITY = {
    "": 1.0,
    "<transparency><float>0.4</float></transparency>": 0.4,
    TRANSPARENT.replace(' opaque="{}"', ""): 0.3,
    TRANSPARENT.format("A_ONE"): 0.3,
    TRANSPARENT.format("A_ZERO"): 0.7,
    TRANSPARENT.format("RGB_ONE"): GREY,
    TRANSPARENT.format("RGB_ZERO"): 1 - GREY,
    TRANSPARENT.format("A_ONE") + "<transparency><float>0.5</float></transparency>": 0.15,
    TRANSPARENT.format("RGB_ZERO") + "<transparency><float>0.5</float></transparency>": 1 - GREY / 2,
}


@pytest.mark.parametrize("transparent", OPACITY)
@pytest.mark.parametrize("alpha", ["1", "0.25"])
def test_the_opacity_of_collada_is_that_of_its_mode(transparent: str, alpha: str, tmp_path: Path) -> None:
    """COLLADA 1.5, transparent: opaque by alpha or luminance, of one or zero. The alpha of diffuse means nothing."""
    diffuse = f"<diffuse><color>0.8 0.4 0.2 {alpha}</color></diffuse>{transparent}"
    text, count = re.subn(r"<(phong|lambert|blinn)>.*?</\1>", rf"<\1>{diffuse}</\1>", COLLADA, flags=re.DOTALL)
    assert count == 1
    (part,) = read(tmp_path, "a.dae", text).parts()
    np.testing.assert_allclose(part.colour, [0.8, 0.4, 0.2, OPACITY[transparent]], atol=1e-6)


def test_a_texture_is_not_opened_and_the_shape_is_drawn(tmp_path: Path) -> None:
    made = BOX.export(file_type="gltf")
    tree = json.loads(made["model.gltf"])
    tree |= {
        "images": [{"uri": "missing.png"}],
        "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    }
    tree["meshes"][0]["primitives"][0]["material"] = 0
    for name, content in made.items():
        (tmp_path / name).write_bytes(content)
    assert read(tmp_path, "model.gltf", json.dumps(tree)).triangles == 12


def test_the_extreme_points_of_a_ball_span_its_hull(tmp_path: Path) -> None:
    trimesh.creation.icosphere(5).export(tmp_path / "ball.stl")
    points = extreme_points(tmp_path / "ball.stl")
    assert len(points) <= 98
    assert trimesh.convex.convex_hull(points).volume == pytest.approx(4 / 3 * np.pi, rel=0.1)
    (tmp_path / "a.dae").write_text(COLLADA)
    with pytest.raises(UnreadableMeshError):
        extreme_points(tmp_path / "a.dae")


def test_a_file_is_read_again_only_after_a_change(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = read(tmp_path, "a.stl", BINARY)
    assert read_mesh(tmp_path / "a.stl") is first
    assert read(tmp_path, "a.stl", BINARY + b"\n") is not first
    monkeypatch.setattr(reading, "MOST_KEPT", 20)
    read(tmp_path, "b.stl", BINARY)
    assert len(reading._kept) == 1


def test_a_ctrl_c_that_a_library_catches_comes_back() -> None:
    def stubborn() -> None:
        with interruptible():
            try:
                os.kill(os.getpid(), signal.SIGINT)
            except BaseException:
                caught.append(True)

    caught: list[bool] = []
    with pytest.raises(KeyboardInterrupt):
        stubborn()
    assert caught


RED, BLUE = "1 0 0 1", "0 0 1 0.5"


def material(name: str, rgba: str = "") -> str:
    colour = f'<color rgba="{rgba}"/>' if rgba else ""
    return f'<material name="{name}">{colour}</material>'


def drawing(*links: str, top: str = "", shape: str = '<box size="1 1 1"/>') -> str:
    """The two-joint arm with visuals of these materials on its first links."""
    text = two_joints().replace('<link name="base_link"/>', f'{top}<link name="base_link"/>')
    for name, materials in zip(("base_link", "upper"), links, strict=False):
        parts = "".join(f"<visual><geometry>{shape}</geometry>{one}</visual>" for one in materials.split("|"))
        text = text.replace(f'<link name="{name}"/>', f'<link name="{name}">{parts}</link>')
    return text


NAMED = {
    "the robot's own against a link's": drawing(material("m", BLUE), top=material("m", RED)),
    "a link's against another's": drawing(material("m", RED), material("m", BLUE)),
    "two of one link": drawing(material("m", RED) + "|" + material("m", BLUE), material("m")),
    "no name": drawing(material("", RED), material("", BLUE)),
}


@pytest.mark.parametrize("case", NAMED)
def test_a_name_means_its_first_colour(case: str, tmp_path: Path) -> None:
    path = write(tmp_path, NAMED[case])
    model = pinocchio.buildModelFromXML(path.read_text())
    drawn = pinocchio.buildGeomFromUrdf(model, str(path), pinocchio.GeometryType.VISUAL).geometryObjects
    description = read_description(path)
    ours = [shape.colour for link in description.links.values() for shape in link.visuals]
    np.testing.assert_allclose(ours, [one.meshColor for one in drawn])
    twice = len({RED, BLUE} & {rgba for rgba in (RED, BLUE) if rgba in NAMED[case]}) == 2 and case != "no name"
    assert [one.code for one in description.findings if one.code == "bad-geometry"] == ["bad-geometry"] * twice


def test_a_name_that_is_given_later_colours_nothing_before(tmp_path: Path) -> None:
    description = read_description(write(tmp_path, drawing(material("m"), material("m", RED))))
    assert [description.links[name].visuals[0].colour for name in ("base_link", "upper")] == [None, (1, 0, 0, 1)]
    assert ["'m'" in one.what for one in description.findings if one.code == "bad-geometry"] == [True]


COLOURS = {"0.1 0.2 0.3": (0.1, 0.2, 0.3, 1.0), "2 0.2 0 1": (1.0, 0.2, 0.0, 1.0), "red": None}


@pytest.mark.parametrize("rgba", COLOURS)
def test_a_colour_that_is_none_is_a_finding(rgba: str, tmp_path: Path) -> None:
    text = drawing("x").replace("x</visual>", f'<material name=""><color rgba="{rgba}"/></material></visual>')
    description = read_description(write(tmp_path, text))
    assert [one.code for one in description.findings].count("bad-geometry") == 1
    assert description.links["base_link"].visuals[0].colour == COLOURS[rgba]


SIZES = {
    '<box size="0 1 1"/>': ((0, 1, 1), 0),
    '<box size="-1 2 3"/>': ((1, 2, 3), 1),
    '<cylinder radius="1" length="-2"/>': ((1, 2), 1),
    '<box size="0 0 1"/>': (None, 1),
}


@pytest.mark.parametrize("shape", SIZES)
def test_a_size_that_is_none_is_told(shape: str, tmp_path: Path) -> None:
    description = read_description(write(tmp_path, drawing("", shape=shape)))
    size, count = SIZES[shape]
    assert [one.size for one in description.links["base_link"].visuals] == ([] if size is None else [size])
    assert [one.code for one in description.findings].count("bad-geometry") == count
