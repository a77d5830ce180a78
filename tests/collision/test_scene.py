"""Scenes: shapes of links and obstacles, distances by hand, Pinocchio as judge, allowed pairs, bad input."""

from __future__ import annotations

import pickle
from copy import copy
from pathlib import Path

import numpy as np
import pytest
import trimesh

from twistarm import Arm, InputError, Pose, TwistarmError, UnknownNameError, arm_from_screws, load_arm
from twistarm.arm.solid import Solid
from twistarm.collision import Scene
from twistarm.collision.survey import srdf_text, survey
from twistarm.description.companions.srdf import read_srdf

SHAPES = {
    "sphere": '<sphere radius="0.1"/>',
    "box": '<box size="0.2 0.2 0.2"/>',
    "capsule": '<capsule radius="0.1" length="0.4"/>',
    "cylinder": '<cylinder radius="0.1" length="0.4"/>',
}


def link(name: str, shape: str = "", xyz: str = "0 0 0") -> str:
    body = f'<collision><origin xyz="{xyz}"/><geometry>{shape}</geometry></collision>' if shape else ""
    return f'<link name="{name}">{body}</link>'


def joint(name: str, kind: str, parent: str, child: str, axis: str, xyz: str = "0 0 0", limit: float = 2.0) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}"/>'
        f'<axis xyz="{axis}"/><limit lower="{-limit}" upper="{limit}" velocity="1" effort="1"/></joint>'
    )


def robot(file: Path, tip: str, *parts: str) -> Arm:
    """The arm of a URDF with these links and joints, named after its file."""
    file.write_text(f'<robot name="{file.stem}">{"".join(parts)}</robot>')
    return load_arm(file, tip=tip)


def slider(tmp_path: Path, shape: str, *more: str) -> Arm:
    """A base, and a `hand` with a shape that slides along x and z; between them only a link without shapes."""
    joints = joint("x", "prismatic", "base", "carriage", "1 0 0"), joint("z", "prismatic", "carriage", "hand", "0 0 1")
    links = link("base", SHAPES["box"], "0 0 -3"), link("carriage"), link("hand", shape)
    return robot(tmp_path / "slider.urdf", "hand", *links, *joints, *more)


@pytest.mark.parametrize(("shape", "gap"), [("sphere", 0.4), ("box", 0.4), ("capsule", 0.4), ("cylinder", 0.4)])
def test_the_distance_to_a_box_is_that_of_a_calculation_by_hand(tmp_path: Path, shape: str, gap: float) -> None:
    """From a shape of half-width 0.1 at x = 0.5 to the face x = 1 of a box."""
    scene = Scene(slider(tmp_path, SHAPES[shape]))
    scene.add_box("wall", (1.0, 2.0, 2.0), (1.5, 0.0, 0.0))
    found = scene.distance([0.5, 0.0])
    assert found.metres == pytest.approx(gap, abs=1e-6)
    assert set(found.links) == {"hand", "wall"}
    assert sorted(found.points[:, 0]) == pytest.approx([0.6, 1.0], abs=1e-4)
    assert str(found) == "hand and wall, 400 mm apart"
    assert not scene.collides([0.5, 0.0])
    assert scene.collides([0.95, 0.0])
    (contact,) = scene.contacts([0.95, 0.0])
    assert contact.distance == pytest.approx(-0.05, abs=1e-5)
    assert str(contact) == "hand and wall overlap by 50 mm"


@pytest.mark.parametrize("kind", ["sphere", "cylinder", "capsule", "plane", "turned box"])
def test_obstacles_stand_where_they_are_put(tmp_path: Path, kind: str) -> None:
    """A sphere of radius 0.1 comes down along z from 1 m; the top of each obstacle is at z = 0.5."""
    scene, at, c = Scene(slider(tmp_path, SHAPES["sphere"])), np.eye(4), np.sqrt(0.5)
    add, size, at[2, 3] = {
        "sphere": (scene.add_sphere, (0.2,), 0.3),
        "cylinder": (scene.add_cylinder, (0.3, 0.6), 0.2),
        "capsule": (scene.add_capsule, (0.2, 0.4), 0.1),
        "plane": (scene.add_plane, (), 0.5),
        "turned box": (scene.add_box, ((1.0, 1.0, 1.0),), 0.5 - c),
    }[kind]
    if kind == "turned box":
        at[:3, :3] = [[c, 0, c], [0, 1, 0], [-c, 0, c]]
    add("it", *size, at)
    assert scene.distance([0.0, 1.0]).metres == pytest.approx(0.4, abs=1e-6)
    assert not scene.collides([0.0, 0.61])
    assert scene.collides([0.0, 0.59])


def test_margins_are_kept_alone_in_batches_and_on_threads(tmp_path: Path) -> None:
    arm = slider(tmp_path, SHAPES["sphere"])
    x = np.column_stack([np.linspace(-0.503, 1.9, 97), np.zeros(97)])
    for margin in (0.0, 0.05, {"hand": 0.2}, {"wall": 0.03, "hand": 0.01}):
        scene = Scene(arm, margin=margin)
        scene.add_box("wall", (1.0, 2.0, 2.0), (1.5, 0.0, 0.0))
        asked = max(margin.values()) if isinstance(margin, dict) else margin
        expected = x[:, 0] + 0.1 > 1.0 - asked
        assert [scene.collides(row) for row in x] == expected.tolist()
        assert (scene.collides(x) == expected).all()
        assert (scene.collides(x.reshape(1, 97, 2), threads=2) == expected).all()
    contact = scene.contacts([0.88, 0.0])[0]
    assert str(contact) == "hand and wall: 20 mm apart, 30 mm asked"
    scene = Scene(arm, margin=0.1)
    scene.add_plane()
    x = np.column_stack([np.zeros(41), np.linspace(0.102, 0.302, 41)])
    assert scene.collides(x).tolist() == (x[:, 1] < 0.2).tolist()
    with pytest.raises(InputError, match="plane"):
        scene.attach("ground", theta=[0.0, 1.0])


@pytest.mark.parametrize("name", ["rover_arm", "rover_arm_6dof", "so101"])
def test_pinocchio_alone_says_the_same_of_the_same_shapes(name: str) -> None:
    """Pinocchio's own reading of the URDF, its own pairs, distances without a broadphase."""
    pin = pytest.importorskip("pinocchio")
    arm = load_arm(name)
    assert arm.description is not None
    scene = Scene(arm)
    if {body.kind for body in scene._links} - {"collision shape"}:
        pytest.skip(f"{name} has meshes, which Pinocchio reads itself")
    model = pin.buildModelFromXML(arm.description.repaired)
    geometry = pin.buildGeomFromUrdfString(model, arm.description.text, pin.GeometryType.COLLISION)
    geometry.addAllCollisionPairs()
    links = [model.frames[body.parentFrame].name for body in geometry.geometryObjects]
    every = [(pair.first, pair.second) for pair in geometry.collisionPairs]
    geometry.removeAllCollisionPairs()
    for first, second in every:
        if tuple(sorted((links[first], links[second]))) not in scene.allowed:
            geometry.addCollisionPair(pin.CollisionPair(first, second))
    data, shapes = model.createData(), geometry.createData()
    expected = []
    thetas = arm.random_theta(54, 400)  # GJK that starts from the previous answer misses one of rover_arm_6dof
    for theta in thetas:
        pin.computeDistances(model, data, geometry, shapes, arm.pinocchio.q(theta))
        expected.append(min(result.min_distance for result in shapes.distanceResults) <= 0.0)
    assert [scene.collides(theta) for theta in thetas] == expected
    assert scene.collides(thetas).tolist() == expected


def test_allowed_pairs_and_their_reasons_are_those_of_the_setup_assistant(tmp_path: Path) -> None:
    """Four links: neighbours, one that overlaps at zero, one that always does, one that never can."""
    small = '<sphere radius="0.05"/>'
    arm = slider(
        tmp_path,
        SHAPES["sphere"],
        link("inside", small, "0 0 -2.95"),
        joint("spin", "continuous", "base", "inside", "0 0 1"),
        link("far", small, "9 0 0"),
        joint("f", "fixed", "base", "far", "0 0 1"),
        link("near", small, "0.1 0 0"),
        joint("n", "fixed", "far", "near", "0 0 1", "0 0 0"),
    )
    scene = Scene(arm)
    assert scene.allowed == {
        ("base", "hand"): "Adjacent",  # only `carriage`, which has no shape, is between them
        ("base", "inside"): "Adjacent",
        ("base", "far"): "Adjacent",
        ("far", "near"): "Adjacent",
        ("hand", "near"): "Default",
        ("base", "near"): "Never",
        ("far", "hand"): "Never",
        ("far", "inside"): "Never",
        ("hand", "inside"): "Never",
        ("inside", "near"): "Never",
    }
    file = tmp_path / "written.srdf"
    known = dict(scene.allowed)
    scene.add_sphere("stone", 0.1)
    scene.allow("stone", "base", "File")  # no link of the robot
    file.write_text(srdf_text(scene))
    assert read_srdf(file).disabled == known


def test_an_srdf_beside_the_description_is_taken_and_written_as_it_is(tmp_path: Path) -> None:
    pair = '<disable_collisions link1="{}" link2="{}" reason="{}"/>'
    rows = pair.format("base", "hand", "Never"), pair.format("base", "carriage", "Adjacent")
    (tmp_path / "slider.srdf").write_text(f'<robot name="slider">{"".join(rows)}</robot>')
    scene = Scene(slider(tmp_path, SHAPES["sphere"]))
    assert scene.allowed == {("base", "carriage"): "SRDF", ("base", "hand"): "SRDF"}
    assert all(row in srdf_text(scene) for row in rows)


def test_what_the_hand_holds_moves_with_it_until_it_is_put_down(tmp_path: Path) -> None:
    scene = Scene(slider(tmp_path, SHAPES["sphere"]))
    scene.add_box("wall", (1.0, 2.0, 2.0), (1.5, 0.0, 0.0))
    scene.add_box("stick", (0.4, 0.02, 0.02), (0.25, 0.0, 0.0))
    assert [contact.links for contact in scene.contacts([0.0, 0.0])] == [("hand", "stick")]
    scene.attach("stick", theta=[0.0, 0.0])
    assert not scene.collides([0.0, 0.0])
    assert scene.distance([0.5, 0.0]).metres == pytest.approx(1.0 - 0.95, abs=1e-6)
    assert scene.collides([0.6, 0.0])
    scene.detach("stick", theta=[0.3, 0.0])
    assert scene.distance([-1.0, 0.0]).metres == pytest.approx(0.35 + 1.0 - 0.1, abs=1e-6)
    scene.remove("stick")
    assert set(scene.obstacles) == {"wall"}


def test_links_without_shapes_get_capsules_and_meshes_their_hulls(tmp_path: Path) -> None:
    trimesh.creation.annulus(0.05, 0.1, 0.2).export(tmp_path / "ring.stl")
    bare, turn = tmp_path / "bare.urdf", joint("a", "revolute", "base", "arm", "0 0 1", "0 0 0.5")
    bend = joint("b", "revolute", "arm", "tip", "0 1 0", "0.6 0 0")
    arm = robot(bare, "tip", link("base"), link("arm"), link("tip", '<mesh filename="ring.stl"/>'), turn, bend)
    shapes = {finding.what for finding in Scene(arm).findings}
    replaced = "links without collision shapes are checked by other shapes: capsule: 'base', 'arm'"
    assert shapes == {replaced, "hull of a collision shape's mesh: 'tip'"}
    inside = arm.fk([0.0, 0.0])  # the middle of the ring: in its hull, not in its triangles
    for exact in (False, True):
        scene = Scene(arm, exact=exact)
        scene.add_sphere("pin", 0.01, inside)
        hit = [contact.links for contact in scene.contacts([0.0, 0.0])]
        assert (("tip", "pin") in hit) is not exact
    (tmp_path / "ring.stl").write_bytes(b"solid nothing")
    twice = bare.read_text().replace(link("arm"), link("arm", '<mesh filename="ring.stl"/>'))
    bare.write_text(twice.replace(link("base"), link("base", '<mesh filename="none.stl"/>')))
    scene = Scene(load_arm(bare, tip="tip"))
    warned = [finding.what for finding in scene.findings if finding.code == "mesh-unreadable"]
    assert [("'base'" in what, "'arm', 'tip'" in what) for what in warned] == [(True, False), (False, True)]
    assert {body.name: body.kind for body in scene.links} == {"base": "capsule", "arm": "capsule"}


@pytest.mark.parametrize("shape", [*SHAPES, "ball.stl"])
def test_a_closed_mesh_is_solid_and_an_open_one_is_told(tmp_path: Path, shape: str) -> None:
    """A body slides through a cube with sides of 1 m, by Coal's box as judge. Its half-width along x is 0.1 m."""
    trimesh.creation.icosphere(1, 0.1).export(tmp_path / "ball.stl")
    cube = trimesh.creation.box((1.0, 1.0, 1.0))
    cube.export(tmp_path / "cube.stl")
    arm = slider(tmp_path, SHAPES.get(shape, f'<mesh filename="{shape}"/>'))
    scenes = Scene(arm, exact=True), Scene(arm)
    for scene in scenes:
        scene.add_mesh("cube", tmp_path / "cube.stl")
    at = np.array([[x, 0.0] for x in (0.0, 0.2, 0.55, 0.61, 0.7)])
    assert scenes[0].collides(at).tolist() == scenes[1].collides(at).tolist() == [True, True, True, False, False]
    assert scenes[0].collides(at[1])
    depth = -0.2 if shape == "capsule" else -0.3  # it is 0.6 m long
    assert scenes[0].distance([0.1, 0.0]).metres == pytest.approx(depth, abs=1e-6)
    assert [contact.links for contact in scenes[0].contacts([0.1, 0.0])] == [("hand", "cube")]
    assert not scenes[0].is_free([0.1, 0.0], [0.12, 0.0])
    distances, _ = scenes[0].near_pairs.measured(np.array([0.1, 0.0]), np.array([0]))
    assert distances == pytest.approx([depth], abs=1e-6)
    assert scenes[0].leaving("zero").collides([0.0, 0.0])  # triangles have no depth to leave
    cube.update_faces(np.arange(len(cube.faces)) > 0)
    cube.export(tmp_path / "open.stl")
    scenes[0].add_mesh("open", tmp_path / "open.stl", [5.0, 0.0, 0.0])
    assert ["'open'" in finding.what for finding in scenes[0].findings if finding.code == "mesh-open"] == [True]


def test_points_are_inside_a_solid_as_trimesh_says(tmp_path: Path) -> None:
    """Faces turned inside out, in part, twice or with corners of their own; a cavity is outside."""
    outer, inner = trimesh.creation.icosphere(2, 0.1), trimesh.creation.icosphere(2, 0.05)
    inner.invert()
    hollow = trimesh.util.concatenate([outer, inner])
    points, faces = np.array(hollow.vertices), np.array(hollow.faces, dtype=np.int64)
    mixed = faces.copy()
    mixed[::3] = mixed[::3, ::-1]
    ways = [faces, faces[:, ::-1], mixed, np.concatenate([faces, faces[:, ::-1]])]
    solids = [Solid(points, way) for way in ways]
    solids.append(Solid(points[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)))
    asked = np.random.default_rng(0).uniform(-0.12, 0.12, (100, 3))
    expected = hollow.contains(asked)
    for solid in solids:
        assert solid.closed
        assert len(solid.samples) == 2
        assert [solid.contains(point[None]) for point in asked] == expected.tolist()
    assert not Solid(points, faces[1:]).closed


def test_meshes_whose_hull_is_hard_to_compute(tmp_path: Path) -> None:
    """Triangles on a line along x, and a cone of radius 1 m with 400 edges at its tip, which is at z = 1 m."""
    scene = Scene(slider(tmp_path, SHAPES["sphere"]))
    trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], process=False).export(tmp_path / "line.stl")
    scene.add_mesh("line", tmp_path / "line.stl", (0.5, 0.0, 0.0))
    assert scene.distance([0.0, 0.0]).metres == pytest.approx(0.4, abs=1e-4)
    scene.remove("line")
    trimesh.creation.cone(1.0, 1.0, sections=400).export(tmp_path / "cone.stl")
    scene.add_mesh("cone", tmp_path / "cone.stl", (0.0, 0.0, 0.5))
    assert scene.distance([0.0, 1.8]).metres == pytest.approx(0.2, abs=1e-6)


def test_a_pickled_or_copied_scene_answers_as_before(tmp_path: Path) -> None:
    arm = load_arm("rover_arm")
    scene = Scene(arm, margin={"table": 0.03})
    scene.add_box("table", (0.4, 1.0, 0.04), (0.6, 0.0, 0.3))
    scene.add_sphere("ball", 0.05)
    scene.attach("ball", theta=arm.ready)
    scene.allow("ball", "table")
    again = pickle.loads(pickle.dumps(scene))
    assert again.allowed.keys() == scene.allowed.keys()
    theta = arm.random_theta(0, 200)
    assert np.array_equal(again.collides(theta), scene.collides(theta))
    assert 0 < scene.collides(theta).sum() < len(theta)
    scene.save(tmp_path / "scene.toml")
    assert pickle.loads(pickle.dumps(scene)).file == scene.file is not None
    before, other = scene.collides(theta), copy(scene)
    other.remove("table")
    other.add_box("everywhere", (9.0, 9.0, 9.0))
    assert list(scene.obstacles) == ["table", "ball"]
    assert np.array_equal(scene.collides(theta), before)
    assert other.collides(theta).all()


def test_an_obstacle_is_moved_and_sized_until_a_link_holds_it(tmp_path: Path) -> None:
    scene = Scene(slider(tmp_path, SHAPES["sphere"]))
    scene.add_box("wall", (1.0, 2.0, 2.0), (9.0, 0.0, 0.0))
    assert scene.distance([0.5, 0.0]).metres == pytest.approx(7.9, abs=1e-6)
    scene.move("wall", Pose.from_rpy([1.5, 0.0, 0.0], [0.0, 0.0, 0.0]))
    assert scene.distance([0.5, 0.0]).metres == pytest.approx(0.4, abs=1e-6)
    scene.resize("wall", (0.4, 2.0, 2.0))
    assert scene.distance([0.5, 0.0]).metres == pytest.approx(0.7, abs=1e-6)
    with pytest.raises(InputError, match="size"):
        scene.resize("wall", (0.4, 2.0, 0.0))
    scene.attach("wall", "hand", theta=[0.0, 0.0])
    with pytest.raises(InputError, match="detach it"):
        scene.move("wall", (0.0, 0.0, 0.0))


def test_a_pair_that_theta_cannot_move_is_not_checked(tmp_path: Path) -> None:
    """A passive wheel beside the base, in the ground."""
    more = link("wheel", SHAPES["sphere"]), joint("w", "continuous", "base", "wheel", "0 1 0", "3 0 0")
    scene = Scene(slider(tmp_path, SHAPES["sphere"], *more))
    scene.add_plane()
    assert not scene.collides([0.0, 1.0])
    assert scene.is_free([0.0, 1.0], [1.0, 0.2])
    assert not scene.is_free([0.0, 1.0], [1.0, 0.05])


def test_what_is_allowed_goes_with_its_obstacle(tmp_path: Path) -> None:
    scene = Scene(slider(tmp_path, SHAPES["sphere"]), margin={"ball": 0.01})
    for allowed in (True, False):
        scene.add_sphere("ball", 0.1)
        if allowed:
            scene.allow("ball", "hand", "it rolls")
            assert scene.allowed["ball", "hand"] == "it rolls"
        assert scene.collides([0.0, 0.0]) is not allowed
        scene.remove("ball")
        assert not scene.collides([0.0, 0.0])


def test_the_fingers_may_touch_what_the_hand_holds() -> None:
    arm = load_arm("rover_arm")
    scene = Scene(arm)
    scene.add_sphere("stone", 0.03, arm.fk(arm.ready)[:3, 3])
    scene.attach("stone", theta=arm.ready)
    assert not scene.collides(arm.ready)


def test_a_motion_that_is_none_is_refused(tmp_path: Path) -> None:
    scene = Scene(slider(tmp_path, SHAPES["sphere"]))
    scene.add_sphere("ball", 0.1, (5.0, 0.0, 0.0))
    once, back = [0.0, 1.0], [1.0, 0.0]
    for breakpoints, shape, value in (
        (once, (2, 1, 2), np.nan), (once, (2, 3, 2), 0.0), (back, (2, 1, 2), 0.0), (once, (2, 1, 2), 1e9),
    ):  # fmt: skip
        with pytest.raises(InputError):
            scene.first_collision(breakpoints, np.full(shape, value))


def test_the_clearance_of_a_motion_is_that_of_a_calculation_by_hand(tmp_path: Path) -> None:
    """A hand of radius 0.1 rests far away, passes a ball in x, and turns back."""
    scene = Scene(slider(tmp_path, SHAPES["sphere"]))
    scene.add_sphere("ball", 0.1, (0.2, 0.0, 0.25))
    pieces = np.zeros((2, 3, 2))
    pieces[0, :, 0], pieces[1, :, 0] = [0.0, 20.0, -0.5], [-1.0, -1.0, 1.0]  # past the ball within 2 ms
    found = scene.clearance([0.0, 3.0, 3.1, 4.0], pieces)
    assert (found.links, found.time) == (("hand", "ball"), pytest.approx(3.06, abs=2e-3))
    assert 0.05 - 1e-6 <= found.metres <= 0.05 + 0.05 * 0.05
    pieces[1, :, 1] = 1.8
    assert scene.clearance([0.0, 3.0, 3.1, 4.0], pieces).metres == pytest.approx(np.hypot(0, 1.55) - 0.2, rel=0.05)


def test_bad_obstacles_and_arms_are_refused(tmp_path: Path) -> None:
    scene = Scene(slider(tmp_path, SHAPES["sphere"]))
    scene.add_sphere("ball", 0.1, (5.0, 0.0, 0.0))
    for add in (
        lambda: scene.add_sphere("ball", 0.1),
        lambda: scene.add_sphere("a\nb", 0.1),
        lambda: scene.add_sphere("a", -0.1),
        lambda: scene.allow(["hand"], "ball"),  # type: ignore[arg-type]
        lambda: scene.add_box("a", (1.0, np.nan, 1.0)),
        lambda: scene.add_box("a", (1.0, 1.0, 1.0), np.zeros((4, 4))),
        lambda: scene.add_mesh("a", tmp_path / "none.stl"),
        lambda: Scene(scene.arm, margin=-1.0),
        lambda: scene.collides([0.0]),
        lambda: scene.clearance([0.0]),
        lambda: Scene(arm_from_screws(scene.arm.screws, scene.arm.home)),
    ):
        with pytest.raises(TwistarmError):
            add()
    misspelt = Scene(scene.arm, margin={"hnd": 0.1})
    for name in (
        lambda: scene.remove("bll"),
        lambda: scene.attach("ball", "hnd", theta=[0.0, 0.0]),
        lambda: misspelt.collides([0.0, 0.0]),
    ):
        with pytest.raises(UnknownNameError):
            name()
    assert set(scene.obstacles) == {"ball"}


def test_a_survey_says_how_often_each_pair_collides(tmp_path: Path) -> None:
    """A sphere of radius 0.1 on ±2 m beside a wall from 1 m on: 1.1 of 4 m."""
    scene = Scene(slider(tmp_path, SHAPES["sphere"]))
    scene.add_box("wall", (2.0, 2.0, 9.0), (2.0, 0.0, 0.0))
    found = survey(scene, 4000)
    assert found.share == pytest.approx(1.1 / 4.0, abs=0.03)
    (pair,) = found.pairs
    assert pair.links == ("hand", "wall")
    assert pair.share == found.share
    assert scene.collides(pair.theta)


def test_a_slide_beyond_the_limits_of_the_file_has_its_whole_radius(tmp_path: Path) -> None:
    """A turn of 2 rad with the hand 30 m out, where the description ends at 2 m. A stone is on the circle."""
    links = link("base"), link("turret"), link("hand", '<sphere radius="0.05"/>')
    joints = joint("turn", "revolute", "base", "turret", "0 0 1"), joint("out", "prismatic", "turret", "hand", "1 0 0")
    scene = Scene(robot(tmp_path / "crane.urdf", "hand", *links, *joints))
    scene.add_sphere("stone", 0.05)
    for angle in (0.4, 1.0, 1.7):
        scene.move("stone", (30.0 * np.cos(angle), 30.0 * np.sin(angle), 0.0))
        found = scene.first_collision([0.0, 2.0], [[[1.0, 0.0]], [[0.0, 30.0]]])
        assert found is not None
        assert found.time == pytest.approx(angle - 2.0 * np.arcsin(0.05 / 30.0), abs=1e-4)
        assert not scene.is_free([0.0, 30.0], [2.0, 30.0])


def test_many_obstacles_are_checked_as_few_are(tmp_path: Path) -> None:
    """A sphere of radius 0.1 among 400 small ones; by hand: nearer than 0.1 to the nearest centre, but 1 mm."""
    scene = Scene(slider(tmp_path, SHAPES["sphere"]), margin=0.01)
    centres = np.random.default_rng(0).uniform([-2, -0.3, -2], [2, 0.3, 2], (400, 3))
    for i, centre in enumerate(centres):
        scene.add_sphere(f"{i}", 0.001, centre)
    thetas = scene.arm.random_theta(1, 80)
    at = np.column_stack([thetas[:, 0], np.zeros(80), thetas[:, 1]])
    nearest = np.linalg.norm(at[:, None] - centres, axis=2).min(axis=1)
    assert [scene.collides(theta) for theta in thetas] == (nearest < 0.111).tolist()


def test_obstacles_are_limited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("twistarm.collision.obstacles.MOST_OBSTACLES", 2)
    scene = Scene(slider(tmp_path, SHAPES["sphere"]))
    scene.add_sphere("a", 0.1)
    scene.add_sphere("b", 0.1)
    with pytest.raises(InputError, match="add_mesh"):
        scene.add_sphere("c", 0.1)
