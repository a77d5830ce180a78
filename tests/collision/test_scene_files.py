"""Files of scenes: scene.toml and MoveIt's, read, saved, and refused by the entry that is wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from test_scene import SHAPES, joint, link, slider
from twistarm import DescriptionError, InputError, load_arm
from twistarm.collision import Scene
from twistarm.theory.rotations import from_rpy

TOML = """
degrees = true
ground = true
margin = 0.01
allow = [["hand", "table"]]

[[box]]
name = "table"
size = [1.0, 2.0, 0.05]
xyz = [0.6, 0.0, 0.4]
rpy = [0.0, 0.0, 90.0]

[[sphere]]
name = "ball"
radius = 0.1
xyz = [0.5, 0.0, 0.0]
on = "hand"
"""

YAML = """
world:
  collision_objects:
    - id: Can
      primitives: [{type: cylinder, dimensions: [0.4, 0.1]}]
      primitive_poses: [{position: [1.0, 0, 0], orientation: [0, 0, 0, 1]}]
    - id: Shelf
      primitives: [{type: box, dimensions: [0.2, 2, 2]}, {type: sphere, dimensions: [0.1]}]
      primitive_poses: [{position: [1.5, 0, 0]}, {position: {x: 0.0, y: 5.0, z: 0.0}}]
allowed_collision_matrix:
  entry_names: [base, hand]
  entry_values: [[false, true], [true, false]]
"""

# A tetrahedron (shape_msgs/Mesh), a plane and an attached object; a quaternion that is not set has zeros.
MESHES_YAML = """
world:
  collision_objects:
    - id: stone
      header: {frame_id: world}
      pose: {position: {x: 1, y: 0, z: 0}, orientation: {x: 0, y: 0, z: 0.7071067811865476, w: 0.7071067811865476}}
      meshes:
        - vertices: [{x: 0, y: 0, z: 0}, {x: 0.4, y: 0, z: 0}, {x: 0, y: -0.4, z: 0}, {x: 0, y: 0, z: 0.4}]
          triangles: [{vertex_indices: [0, 1, 2]}, {vertex_indices: [0, 3, 1]}, {vertex_indices: [0, 2, 3]}, [1, 3, 2]]
      mesh_poses: [{position: {x: 0, y: -0.5, z: 0}, orientation: {x: 0, y: 0, z: 0, w: 0}}]
      planes: [{coef: [0.0, 2.0, 0.0, 1.0]}]
      plane_poses: [{position: {x: 0, y: -0.5, z: 0}}]
    - {id: dust, primitives: [{type: 2, dimensions: [0.1]}], operation: 0}
robot_state:
  attached_collision_objects:
    - link_name: hand
      touch_links: [base]
      object: {id: tool, header: {frame_id: hand}, primitives: [{type: 1, dimensions: [0.02, 0.02, 0.02]}]}
allowed_collision_matrix:
  entry_names: [hand, dust, tool, stone]
  entry_values: [{enabled: [0, 1, 0, 0]}, {enabled: [1, 0, 1, 0]}, {enabled: [0, 1, 0, 1]}, {enabled: [0, 0, 1, 0]}]
"""

MESHES_TEXT = """(noname)+
* stone
1 0 0
0 0 0.7071067811865476 0.7071067811865476
2
mesh
4 4
0 0 0
0.4 0 0
0 -0.4 0
0 0 0.4
0 1 2
0 3 1
0 2 3
1 3 2
0 -0.5 0
0 0 0 1
0 0 0 0
plane
0 2 0 1
0 -0.5 0
0 0 0 1
0 0 0 0
0
.
"""

TEXT = """(noname)+
* Can
1 0 0
0 0 0 1
1
cylinder
0.1 0.4
0 0 0
0 0 0 1
0 0 0 0
0
* Shelf
1
box
0.2 2 2
1.5 0 0
0 0 0 1
0 0 0 0
.
"""


def test_a_scene_toml_is_read(tmp_path: Path) -> None:
    arm = slider(tmp_path, SHAPES["sphere"])
    (tmp_path / "scene.toml").write_text(TOML)
    scene = Scene.load(arm, tmp_path / "scene.toml")
    assert set(scene.obstacles) == {"ground", "table", "ball"}
    assert not scene.collides([0.0, 1.0])
    assert not scene.collides([-1.5, 0.45])  # hand and table may touch, and the ball is beside the table
    assert scene.collides([1.05, 0.42])  # the ball is in the table, which is 2 m long along x after its turn
    assert scene.collides([-1.9, 0.105])  # nearer than the margin to the ground


@pytest.mark.parametrize(("name", "text"), [("scene.yaml", YAML + "---\n"), ("a.scene", TEXT)])
def test_moveit_scenes_are_read(tmp_path: Path, name: str, text: str) -> None:
    arm = slider(tmp_path, SHAPES["sphere"])
    (tmp_path / name).write_text(text)
    scene = Scene.load(arm, tmp_path / name)
    assert scene.distance([0.0, 0.0]).metres == pytest.approx(0.8, abs=1e-6)  # to a can of radius 0.1
    assert scene.distance([1.9, 0.0]).metres == pytest.approx(0.2, abs=1e-6)  # from behind to the shelf


@pytest.mark.parametrize(("name", "text"), [("scene.yaml", MESHES_YAML), ("a.scene", MESHES_TEXT)])
@pytest.mark.parametrize("exact", [False, True])
def test_meshes_and_planes_of_moveit_scenes_are_read_and_saved(
    tmp_path: Path, name: str, text: str, exact: bool
) -> None:
    arm = slider(tmp_path, SHAPES["sphere"])
    (tmp_path / name).write_text(text)
    scene = Scene.load(arm, tmp_path / name, exact=exact)
    again = Scene.load(arm, scene.save(tmp_path / "again.toml"), exact=exact)
    for loaded in (scene, again):  # the tetrahedron's corner is at x = 1.5, and x ≥ 2 is solid
        near, above = loaded.distance([1.0, 0.0]), loaded.distance([1.0, 1.5])
        assert (near.links, above.links) == (("hand", "stone 1"), ("hand", "stone 2"))
        assert (near.metres, above.metres) == (pytest.approx(0.4, abs=1e-6), pytest.approx(0.9, abs=1e-6))


def test_the_frame_of_the_virtual_joint_is_that_of_the_root(tmp_path: Path) -> None:
    """MoveIt's planning frame is the parent_frame of the virtual joint that carries the root."""
    joints = '<virtual_joint name="v" type="fixed" parent_frame="odom" child_link="{}"/>'
    (tmp_path / "slider.srdf").write_text(f'<robot name="slider">{joints.format("base")}</robot>')
    arm = slider(tmp_path, SHAPES["sphere"])
    (tmp_path / "scene.yaml").write_text(YAML.replace("id: Can", "id: Can\n      header: {frame_id: odom}"))
    assert Scene.load(arm, tmp_path / "scene.yaml").distance([0.0, 0.0]).metres == pytest.approx(0.8, abs=1e-6)
    (tmp_path / "slider.srdf").write_text(f'<robot name="slider">{joints.format("hand")}</robot>')
    with pytest.raises(InputError, match="frame_id='odom'"):
        Scene.load(load_arm(tmp_path / "slider.urdf"), tmp_path / "scene.yaml")


@pytest.mark.parametrize(
    ("name", "text", "culprit"),
    [
        ("scene.toml", '[[box]]\nname = "t"\n', "box 1: it needs 'size'"),
        ("scene.toml", '[[sphere]]\nname = "hand"\nradius = 1\n', "'hand'"),
        ("scene.toml", '[[mesh]]\nname = "t"\nfile = "none.stl"\n', "none.stl"),
        ("scene.toml", '[[sphere]]\nname = "t"\nradius = 1\nrpy = [0, 0, 90]\n', "degrees = true"),
        ("scene.toml", '[[sphere]]\nname = "t"\nradius = 101\n', "100 m"),
        ("scene.toml", 'arm = "another"\n', "'another'"),
        ("scene.yaml", "world: {collision_objects: [{id: a, meshes: [1]}]}", "collision object 1"),
        ("scene.yaml", "world: {collision_objects: [{id: a, planes: [{coef: [0, 0, 0, 1]}]}]}", "coef"),
        ("scene.yaml", MESHES_YAML.replace("frame_id: hand", "frame_id: base"), "its link 'hand'"),
        ("scene.yaml", "world: {octomap: {octomap: {binary: true, resolution: 0.1, data: [3]}}}", "octomap"),
        ("scene.yaml", "world: {collision_objects: [{id: a, primitives: [{type: cone, dimensions: [1]}]}]}", "cone"),
        ("a.scene", MESHES_TEXT.replace("4 4", "4 7"), ".scene"),
        ("a.scene", TEXT[:-2], "'.'"),
    ],
)
def test_a_scene_file_that_cannot_be_used_is_named_with_the_entry(
    tmp_path: Path, name: str, text: str, culprit: str
) -> None:
    arm = slider(tmp_path, SHAPES["sphere"])
    (tmp_path / name).write_text(text)
    with pytest.raises((InputError, DescriptionError)) as refused:
        Scene.load(arm, tmp_path / name)
    assert name in str(refused.value)
    assert culprit in str(refused.value)


def test_a_scene_that_is_saved_is_read_again_as_it_was(tmp_path: Path) -> None:
    arm = load_arm("rover_arm")
    trimesh.creation.box((0.1, 0.2, 0.3)).export(tmp_path / "stone.stl")
    scene = Scene(arm, margin={"upper_arm": 0.01, "box": 0.02})
    g = np.eye(4)
    g[:3, :3], g[:3, 3] = from_rpy([0.3, -0.8, 2.0]), [1.0, 0.2, 0.1]
    scene.add_box("box", (0.1, 0.2, 0.3), g)
    scene.add_sphere('a "ball"', 0.1, arm.fk(arm.ready)[:3, 3])
    scene.add_cylinder("post", 0.05, 0.4, (2.0, 0.0, 0.0))
    scene.add_capsule("pill", 0.05, 0.4, (0.0, 2.0, 0.0))
    scene.add_plane(pose=(0.0, 0.0, -1.0))
    scene.add_mesh("stone", tmp_path / "stone.stl", g, scale=2.0)
    scene.attach('a "ball"', theta=arm.ready, touching=["upper_arm"])
    scene.allow("upper_arm", "post")
    scene.add_sphere("gone", 0.1)
    scene.remove("gone")
    (tmp_path / "below").mkdir()
    again = Scene.load(arm, scene.save(tmp_path / "below" / "scene.toml"))
    assert again.file == scene.file
    assert set(again.obstacles) == set(scene.obstacles)
    for name, body in scene.obstacles.items():
        other = again.obstacles[name]
        assert (other.kind, other.carrier, other.size) == (body.kind, body.carrier, pytest.approx(body.size))
        assert np.abs(other.pose - body.pose).max() < 1e-8
    assert {entry.touching for entry in again.content().entries} == {
        entry.touching for entry in scene.content().entries
    }
    assert again.allowed.keys() == scene.allowed.keys()
    thetas = arm.random_theta(0, 60)
    assert np.array_equal(again.collides(thetas), scene.collides(thetas))
    assert again.for_arm(load_arm("rover_arm")).obstacles.keys() == scene.obstacles.keys()


def test_a_saved_matrix_of_a_planning_scene_stays_whole(tmp_path: Path) -> None:
    arm = slider(tmp_path, SHAPES["sphere"])
    (tmp_path / "scene.yaml").write_text(YAML.replace("true", "false"))
    scene = Scene.load(arm, tmp_path / "scene.yaml")
    again = Scene.load(arm, scene.save(tmp_path / "scene.toml"))
    assert again.allowed == scene.allowed == {}


def test_no_other_file_is_lost_to_a_scene(tmp_path: Path) -> None:
    scene = Scene(slider(tmp_path, SHAPES["sphere"]))
    (tmp_path / "arm.toml").write_text('[arm]\nbase = "base"\n')
    for name, words in (("arm.toml", "no scene.toml is there"), ("a.yaml", "end with .toml"), ("no/a.toml", "folder")):
        with pytest.raises(InputError, match=words):
            scene.save(tmp_path / name)
    assert (tmp_path / "arm.toml").read_text().startswith("[arm]")


ABSENT = """
world:
  collision_objects:
    - {id: box, primitives: [{type: 1, dimensions: [0.1, 0.1, 0.1]}]}
    - {id: gone, primitives: [{type: 1, dimensions: [0.1, 0.1, 0.1]}], operation: 0}
    - {id: gone, operation: REMOVE}
    - {id: box, operation: 1}
    - {id: stone, primitives: [{type: 2, dimensions: [0.1]}], operation: ADD}
allowed_collision_matrix:
  entry_names: [base, hand, box_link, stone]
  entry_values: [[1, 1, 1, 0], [1, 1, 1, 1], [1, 1, 1, 1], [0, 1, 1, 1]]
"""

# Pairs outside the matrix have the default of their name, both if both have one (moveit_msgs/AllowedCollisionMatrix).
DEFAULTS = """
link_padding: [{link_name: hand, padding: 0.01}, {link_name: base, padding: 0}]
link_scale: [{link_name: hand, scale: 1}]
world:
  colision_objects: []
  collision_objects:
    - {id: stone, primitives: [{type: 2, dimensions: [0.1]}]}
    - {id: ball, primitives: [{type: 2, dimensions: [0.1]}]}
robot_state:
  attached_collision_objects: [{link_name: hand, object: {id: cup}}]
  joint_state: {name: [x, left, right], position: [0.5, 0.3, 0.0]}
is_diff: true
allowed_collision_matrix:
  entry_names: [hand, stone]
  entry_values: [[0, 0], [0, 0]]
  default_entry_names: [stone, ball]
  default_entry_values: [true, false]
"""


def test_a_planning_scene_takes_its_defaults_and_tells_what_it_does_not_use(tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(DEFAULTS)
    turns = ((name, joint(name, "revolute", "hand", f"{name} finger", "0 0 1")) for name in ("left", "right"))
    parts = (part for name, turn in turns for part in (link(f"{name} finger"), turn))
    scene = Scene.load(slider(tmp_path, SHAPES["sphere"], *parts), tmp_path / "scene.yaml")
    assert set(scene.allowed) == {(name, "stone") for name in ("base", "carriage", "left finger", "right finger")}
    (found,) = (finding for finding in scene.findings if finding.code == "scene-names")
    for culprit in ("'link_padding of hand'", "'colision_objects of the world'", "'cup, ", "'joint_state of left'"):
        assert culprit in found.what
    assert "is_diff" in found.what
    for unsaid in ("base", "of x", "of right"):
        assert unsaid not in found.what
    assert "link_scale" not in found.what


def test_a_planning_scene_leaves_out_what_it_removes_and_names_what_is_absent(tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(ABSENT)
    scene = Scene.load(slider(tmp_path, SHAPES["sphere"]), tmp_path / "scene.yaml")
    assert set(scene.obstacles) == {"stone"}
    assert set(scene.allowed) == {("base", "hand"), ("hand", "stone")}
    (found,) = (finding for finding in scene.findings if finding.code == "scene-names")
    assert "'box_link'" in found.what
    for operation in ("MOVE", "weird"):
        (tmp_path / "scene.yaml").write_text(
            ABSENT.replace("id: box, operation: 1", f"id: box, operation: {operation}")
        )
        with pytest.raises(InputError, match="'box'"):
            Scene.load(scene.arm, tmp_path / "scene.yaml")
