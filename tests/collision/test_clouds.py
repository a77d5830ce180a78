"""Point clouds as obstacles: boxes in place of their voxels as judge, files, octomaps, bad input."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from test_scene import SHAPES, slider
from twistarm import InputError, Scene, ServoState, TwistCommand, load_arm, servo_step
from twistarm.collision.cloud_files import read_points

VOXEL = 0.04
TETRAHEDRON = [[0.01, 0.02, 0.03], [0.5, -0.25, 1.0], [-0.125, 0.75, 0.0], [1.5, 0.0, -0.5]]


def shelf(seed: int) -> np.ndarray:
    """Points of a board and of a heap beside an arm."""
    rng = np.random.default_rng(seed)
    board = rng.uniform([-0.4, 0.35, 0.3], [0.4, 0.6, 0.3], (150, 3))
    return np.vstack([board, rng.normal([0.5, 0.0, 0.25], 0.06, (60, 3))])


@pytest.mark.parametrize(("name", "margin"), [("ur5", 0.0), ("rover_arm_6dof", 0.02)])
def test_a_cloud_answers_as_boxes_in_place_of_its_voxels(name: str, margin: float) -> None:
    arm, points = load_arm(name), shelf(1)
    cloud, boxes = Scene(arm, margin=margin), Scene(arm, margin=margin)
    at = np.eye(4)
    at[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    cloud.add_points("cloud", points, VOXEL, at)
    for i, cell in enumerate(np.unique(np.floor(points / VOXEL), axis=0)):
        boxes.add_box(f"box {i}", (VOXEL,) * 3, at[:3, :3] @ ((cell + 0.5) * VOXEL))
    theta = arm.random_theta(2, 100)
    hit = boxes.collides(theta)
    assert 10 < hit.sum() < 90
    assert cloud.collides(theta).tolist() == hit.tolist()
    separate = [x for x in theta[~hit] if boxes.distance(x).metres > 1e-6][:15]
    assert [cloud.distance(x).metres for x in separate] == pytest.approx(
        [boxes.distance(x).metres for x in separate], abs=1e-9
    )
    ways = [(x, y) for x, y in zip(theta[~hit][:-1], theta[~hit][1:], strict=True)][:15]
    free = [boxes.is_free(*way) for way in ways]
    assert {*free} == {True, False}
    assert [cloud.is_free(*way) for way in ways] == free
    state = ServoState.at(arm, separate[0])
    for _ in range(30):
        state, _ = servo_step(arm, state, TwistCommand([0.2, 0.2, -0.2, 0.0, 0.0, 0.0]), 0.02, scene=cloud)
        assert not boxes.collides(state.theta)


def test_points_of_the_arm_itself_are_left_out_and_a_cloud_is_replaced(tmp_path: Path) -> None:
    """A ball of radius 0.1 at the origin, and points on it and 0.3 m above it."""
    scene = Scene(slider(tmp_path, SHAPES["sphere"]))
    seen = [[0.1, 0.0, 0.0], [0.0, 0.06, 0.08], [0.0, 0.0, 0.3]]
    scene.add_points("camera", seen, without_arm=True, theta=[0.0, 0.0])
    assert scene.distance([0.0, 0.0]).metres == pytest.approx(0.2, abs=0.021)
    assert scene.distance([0.0, 0.0]).links == ("hand", "camera")
    scene.replace_points("camera", [[0.0, 0.0, 0.5]])
    assert scene.distance([0.0, 0.0]).metres == pytest.approx(0.4, abs=0.021)
    scene.replace_points("camera", seen[:2], without_arm=True, theta=[0.0, 0.0])  # nothing is left
    assert not scene.collides([0.0, 0.1])


def swapped(rows: np.ndarray) -> np.ndarray:
    """The rows with their numbers in the other order of bytes."""
    return rows.astype(rows.dtype.newbyteorder(">"))


def test_every_format_gives_the_same_points(tmp_path: Path) -> None:
    points = np.array(TETRAHEDRON)
    rows = "\n".join(" ".join(map(str, row)) for row in TETRAHEDRON)
    vertex = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nend_header\n"
    colours = np.zeros(4, [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("c", "u1")])
    for axis, column in zip("xyz", points.T, strict=True):
        colours[axis] = column
    head = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 5\nHEIGHT 1\nPOINTS 5\nDATA "
    lost = np.vstack([points, np.full((1, 3), np.nan)]).astype("<f4")
    files = {
        "a.xyz": rows,
        "b.csv": "x,y,z\n" + rows.replace(" ", ","),
        "k.csv": "X [mm],y_cm,z (m)\n" + "".join(f"{1e3 * x},{1e2 * y},{z}\n" for x, y, z in TETRAHEDRON),
        "c.ply": f"ply\nformat ascii 1.0\n{vertex}" + rows.replace("\n", " 9\n") + " 9\n",
        "d.ply": f"ply\nformat binary_little_endian 1.0\n{vertex}".encode() + colours.tobytes(),
        "e.pcd": f"# .PCD\n{head}ascii\n{rows}\nnan nan nan\n",
        "f.pcd": f"{head}binary\n".encode() + lost.tobytes(),
    }
    files["h.csv"] = "id;Z;Y;X\n" + "".join(f"7;{z};{y};{x}\n" for x, y, z in TETRAHEDRON).replace(".", ",")
    files["i.ply"] = f"ply\nformat binary_big_endian 1.0\n{vertex}".encode() + swapped(colours).tobytes()
    files["j.pcd"] = f"{head}ascii\n".replace("x y z", "z y x") + "".join(
        f"{z} {y} {x}\n" for x, y, z in [*TETRAHEDRON, [np.nan] * 3]
    )
    for name, content in files.items():
        (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    np.save(tmp_path / "g.npy", points)
    for file in sorted(tmp_path.iterdir()):
        assert read_points(file) == pytest.approx(points, abs=1e-7), file.name


def test_a_scene_file_holds_clouds(tmp_path: Path) -> None:
    arm = slider(tmp_path, SHAPES["sphere"])
    (tmp_path / "shelf.xyz").write_text("1.01 0.01 0.01\n")
    (tmp_path / "scene.toml").write_text('[[points]]\nname = "s"\nfile = "shelf.xyz"\nvoxel = 0.02\nxyz = [0, 0, 1]\n')
    scene = Scene.load(arm, tmp_path / "scene.toml")
    assert scene.distance([0.5, 1.0]).metres == pytest.approx(0.4, abs=1e-6)
    assert "points-far" not in {finding.code for finding in scene.findings}
    scene.add_points("heap 1", [[0.0, 0.0, -1.0]], 0.1)
    scene.add_points("heap_1", [[9.0, 9.0, 9.0]], 0.1)  # its file must have another name
    assert [finding.what[:8] for finding in scene.findings if finding.code == "points-far"] == ["'heap_1'"]
    scene.add_points("own", [[0.1, 0.0, 0.0]], without_arm=True, theta=[0.0, 0.0])  # nothing is left, so no file
    scene.save(tmp_path / "other.toml")
    again = Scene.load(arm, tmp_path / "other.toml")
    assert {*again.obstacles} == {"s", "heap 1", "heap_1"}
    for theta in ([0.5, 1.0], [0.0, -0.5]):
        assert again.distance(theta).metres == pytest.approx(scene.distance(theta).metres, abs=1e-12)


def octomap(keys: Iterable[tuple[int, int, int]], binary: bool) -> list[int]:
    """Occupied voxels as OctoMap writes them: keys from 0 to 65535, depth first."""

    def node(cells: set[tuple[int, int, int]], depth: int) -> bytes:
        kinds, below = 0, b""
        for i in range(8):
            inside = {
                key for key in cells if [key[a] >> (15 - depth) & 1 for a in range(3)] == [i & 1, i >> 1 & 1, i >> 2]
            }
            if inside and binary:
                kinds |= (2 if depth == 15 else 3) << 2 * i
                below += node(inside, depth + 1) if depth < 15 else b""
            elif inside:
                kinds |= 1 << i
                below += node(inside, depth + 1) if depth < 15 else struct.pack("<fB", 0.8, 0)
        return (struct.pack("<H", kinds) if binary else struct.pack("<fB", 0.8, kinds)) + below

    return [byte - 256 * (byte > 127) for byte in node({*keys}, 0)]


@pytest.mark.parametrize("binary", [True, False])
def test_an_octomap_of_a_planning_scene_is_read(tmp_path: Path, binary: bool) -> None:
    keys = [(32768 + 10, 32768, 32768), (32768 - 20, 32770, 32767), (32768, 32768, 32768 + 10)]
    tree = {"binary": binary, "id": "OcTree", "resolution": 0.1, "data": octomap(keys, binary)}
    world: dict[str, Any] = {"octomap": {"header": {"frame_id": "base"}, "octomap": tree}}
    world["octomap"]["origin"] = {"position": {"x": 1.0, "y": 0.0, "z": 0.0}}
    file = tmp_path / "scene.yaml"
    file.write_text(yaml.safe_dump({"world": world}))
    scene = Scene.load(slider(tmp_path, SHAPES["sphere"]), file)
    voxels = scene.obstacles["<octomap>"].shape.centres
    assert sorted(voxels.tolist()) == pytest.approx(
        np.array([[-1.95, 0.25, -0.05], [0.05, 0.05, 1.05], [1.05, 0.05, 0.05]])
    )
    assert scene.collides([2.05, 0.05])  # at x = 1 + 1.05
    assert not scene.collides([1.7, 0.05])
    matrix = {"entry_names": ["hand", "<octomap>"], "entry_values": [[False, True], [True, False]]}
    file.write_text(yaml.safe_dump({"world": world, "allowed_collision_matrix": matrix}))
    assert not Scene.load(scene.arm, file).collides([2.05, 0.05])


@pytest.mark.parametrize(
    ("points", "options", "culprit"),
    [
        (np.empty((0, 3)), {}, "no points"),
        ([[0.0, np.nan, 0.0]], {}, "not finite"),
        ([[1.0, 2.0]], {}, "(N, 3)"),
        ([[1200.0, 0.0, 300.0]], {}, "millimetres"),
        ([[0.0, 0.0, 0.0]], {"voxel": 0.0}, "voxel"),
        ([[0.0, 0.0, 0.0]], {"theta": [0.0, 0.0]}, "without_arm"),
        ("cloud.las", {}, "cloud.las"),
        ("cut.pcd", {}, "cut short"),
        ("packed.pcd", {}, "binary_compressed"),
        ("web.ply", {}, "web page"),
        ("empty.xyz", {}, "no points"),
        ("columns.csv", {}, "no x, y and z"),
        ("unit.csv", {}, "parsec"),
    ],
)
def test_what_is_no_cloud_is_refused(here: Path, points: Any, options: dict[str, Any], culprit: str) -> None:
    head = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 9\nDATA "
    Path("cut.pcd").write_text(f"{head}binary\nabc")
    Path("packed.pcd").write_text(f"{head}binary_compressed\nabc")
    Path("empty.xyz").write_text("# nothing\n")
    Path("columns.csv").write_text("a,b,c\n1,2,3\n")
    Path("unit.csv").write_text("x [parsec],y,z\n1,2,3\n")
    Path("web.ply").write_text("<!DOCTYPE html><html></html>")
    scene = Scene(slider(here, SHAPES["sphere"]))
    with pytest.raises(InputError) as error:
        scene.add_points("cloud", points, **options)
    assert culprit in str(error.value)
    assert not scene.obstacles
