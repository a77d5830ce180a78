"""Collisions on show: what the pages are told, and the obstacles that they change and save."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from recorded_poses import ask, done, said
from test_viewer_server import get
from twistarm import Arm, InputError, Scene, UnknownNameError, arm_from_screws, load_arm, plan_joint
from twistarm.viewer import Viewer
from twistarm.viewer.parts import collisions
from twistarm.viewer.stage import Stage

ARM = load_arm("rover_arm", limits={"acceleration": 3.0})
TABLE = [0.8, 0.0, 0.3]


def scene_of(arm: Arm = ARM) -> Scene:
    scene = Scene(arm)
    scene.add_box("table", (0.4, 1.0, 0.04), TABLE)
    return scene


def ready(scene: Scene | None = None, arm: Arm = ARM) -> Stage:
    """A stage whose layer is on and whose checks are prepared."""
    stage = Stage(arm, None, scene)
    stage.needed = frozenset({"collision"})
    done(stage.collisions.due(stage))
    return stage


def hitting(scene: Scene) -> np.ndarray[Any, Any]:
    """A configuration in collision with an obstacle."""
    thetas = scene.arm.random_theta(0, 500)
    return next(x for x in thetas if any("table" in contact.links for contact in scene.contacts(x)))


def put(stage: Stage, name: str, kind: str, size: list[float], position: Any = (2.0, 0.0, 0.0), **more: Any) -> None:
    ask(stage, "obstacle", name=name, kind=kind, size=size, position=list(position), xyzw=[0, 0, 0, 1], **more)


def test_without_a_scene_nothing_is_made_until_the_layer_is_switched_on() -> None:
    stage = Stage(ARM)
    assert stage.collisions.due(stage) is None
    assert said(stage, "collision") == {
        "type": "collision", "ready": False, "links": [], "words": [], "nearest": None,
    }  # fmt: skip
    with pytest.raises(InputError, match="turn on the layer Collision"):
        put(stage, "a", "sphere", [0.1])
    stage.needed = frozenset({"collision"})
    job = stage.collisions.due(stage)
    assert stage.collisions.due(stage) is None, "it is under way"
    done(job)
    assert said(stage, "collision")["ready"]
    bare = Stage(arm_from_screws(np.eye(6)[:, 5:], home=np.eye(4)))
    bare.needed = frozenset({"collision"})
    assert bare.collisions.due(bare) is None


def test_links_in_collision_and_the_nearest_pair_are_told() -> None:
    scene = scene_of()
    stage = ready(scene)
    free = said(stage, "collision")
    assert (free["links"], free["words"]) == ([], [])
    (a, b), metres = np.array(free["nearest"]["points"]), free["nearest"]["metres"]
    assert np.linalg.norm(a - b) == pytest.approx(metres, abs=1e-6)
    assert said(stage, "collision") is free, "the arm has not moved"
    theta = hitting(scene)
    stage.show(theta)
    hit = said(stage, "collision")
    assert set(hit["links"]) == {name for contact in scene.contacts(theta) for name in contact.links}
    assert hit["nearest"]["metres"] < 0.0
    stage.needed = frozenset()
    off = said(stage, "collision")
    assert off["links"] == hit["links"], "a link in collision is red without the layer, too"
    assert off["nearest"] is None


def test_shapes_are_drawn_where_pinocchio_has_them() -> None:
    stage = ready(arm=load_arm("elbow"))
    bodies = said(stage, "shapes")["bodies"]
    scene = stage.collisions.scene
    assert scene is not None
    assert [body["name"] for body in bodies] == [body.name for body in scene.links]
    for body, made in zip(bodies, scene.links, strict=True):
        assert_allclose(np.reshape(body["matrix"], (4, 4)).T, made.pose)
        made.shape.computeLocalAABB()
        if body["kind"] == "mesh":
            points = np.frombuffer(base64.b64decode(body["points"]), "<f4").reshape(-1, 3)
            faces = np.frombuffer(base64.b64decode(body["faces"]), "<u4").reshape(-1, 3)
            assert faces.max() < len(points)
            radius = np.linalg.norm(points - made.shape.aabb_center, axis=1).max()
            assert radius <= made.shape.aabb_radius + 1e-6
        else:
            assert len(body["size"]) == {"box": 3, "sphere": 1, "cylinder": 2, "capsule": 2}[body["kind"]]


def test_a_cloud_is_drawn_at_its_voxels_with_six_bytes_each() -> None:
    scene, points = Scene(ARM), np.random.default_rng(3).uniform(-1.0, 1.0, (500, 3)) + [0.0, 0.0, 3.0]
    scene.add_points("cloud", points, 0.1)
    (drawn,) = said(ready(scene), "obstacles")["obstacles"]
    cells = np.frombuffer(base64.b64decode(drawn["points"]), "<u2").reshape(-1, 3)
    expected = 0.1 * (np.unique(np.floor(points / 0.1), axis=0) + 0.5)
    assert_allclose(np.unique(drawn["low"] + drawn["step"] * cells, axis=0), expected, atol=1e-9)


def test_the_band_of_a_motion_holds_its_samples_that_collide() -> None:
    scene = scene_of()
    stage = ready(scene)
    motion = plan_joint(ARM, [ARM.ready, hitting(scene), ARM.ready])
    stage.load(motion).play(0.0)
    done(stage.collisions.due(stage))
    band = said(stage, "colliding")["band"]
    assert band
    shares = np.random.default_rng(0).uniform(0.0, 1.0, 300)
    inside = np.any([(start <= shares) & (shares <= end) for start, end in band], axis=0)
    edge = np.any([np.abs(shares - at) < 0.003 for part in band for at in part], axis=0)
    expected = [scene.collides(motion(share * motion.duration)) for share in shares]
    assert np.array_equal(inside[~edge], np.array(expected)[~edge])
    assert stage.collisions.due(stage) is None
    ask(stage, "remove_obstacle", name="table")
    done(stage.collisions.due(stage))
    assert said(stage, "colliding")["band"] != band


def test_a_collision_between_two_samples_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(collisions, "SAMPLES", 2)
    scene = Scene(ARM)
    stage = ready(scene)
    motion = plan_joint(ARM, [ARM.ready, ARM.ready + [0.4, 0.0, 0.0, 0.0, 0.0]])
    scene.add_sphere("stone", 0.01, ARM.fk(motion(0.5 * motion.duration))[:3, 3])
    stage.load(motion).play(0.0)
    done(stage.collisions.due(stage))
    ((start, end),) = said(stage, "colliding")["band"]
    assert 0.1 < start == end <= 0.5
    stage.load(plan_joint(ARM, [ARM.ready, ARM.ready + 0.01])).play(0.0)
    assert stage.collisions.due(stage) is not None
    assert said(stage, "colliding")["band"] == [], "what is not known of the new motion is not told"


def test_recorded_poses_and_other_configurations_in_collision_are_told() -> None:
    scene = scene_of()
    stage = ready(scene)
    ask(stage, "record", name="free")
    stage.show(np.clip(hitting(scene), ARM.limits.lower, ARM.limits.upper))
    ask(stage, "record", name="hit")
    _, hit = stage.poses.poses
    assert said(stage, "colliding")["poses"] == [hit.id]
    g = ARM.fk(stage.theta)
    done(ask(stage, "solutions", kind="position", position=g[:3, 3].tolist(), xyzw=[0, 0, 0, 1]))
    theta = stage.solutions.theta
    assert theta is not None
    places = [i for i, x in enumerate(theta) if scene.collides(x)]
    assert said(stage, "colliding")["solutions"] == places


def test_obstacles_are_added_moved_sized_removed_and_saved(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    scene_of().save(file)
    scene = Scene.load(ARM, file)
    stage = ready(scene)
    assert said(stage, "obstacles")["saved"]
    put(stage, "ball", "sphere", [0.1])
    put(stage, "table", "box", [0.5, 1.0, 0.04], [0.9, 0.0, 0.3])
    told = said(stage, "obstacles")
    assert not told["saved"]
    assert [obstacle["name"] for obstacle in told["obstacles"]] == ["table", "ball"]
    assert told["obstacles"][0]["size"] == [0.5, 1.0, 0.04]
    scene.add_capsule("pill", 0.1, 0.4)
    assert said(stage, "obstacles")["obstacles"][2]["size"] == [0.1, 0.4]
    scene.remove("pill")
    assert told["obstacles"][0]["matrix"][12:15] == [0.9, 0.0, 0.3]
    for name, kind, size in (("ball", "box", [1.0] * 3), ("wall", "mesh", [1.0] * 3), ("upper_arm", "sphere", [0.1])):
        with pytest.raises(InputError, match=f"{name}|file"):
            put(stage, name, kind, size)
    ask(stage, "save_scene")
    assert said(stage, "obstacles")["saved"]
    assert set(Scene.load(ARM, file).obstacles) == {"table", "ball"}
    ask(stage, "remove_obstacle", name="ball")
    assert set(scene.obstacles) == {"table"}
    with pytest.raises(UnknownNameError, match="no obstacle 'ball'"):
        ask(stage, "remove_obstacle", name="ball")


def test_a_motion_of_the_page_is_refused_or_goes_round() -> None:
    """A post stands between two recorded poses."""
    pytest.importorskip("ompl")
    scene = Scene(ARM)
    stage = ready(scene)
    poses = np.array([ARM.ready, ARM.ready])
    poses[:, 0] += [-0.5, 0.5]
    for theta in np.clip(poses, ARM.limits.lower, ARM.limits.upper):
        stage.show(theta)
        ask(stage, "record", name="")
    between = ARM.fk(0.5 * (stage.poses.poses[0].theta + stage.poses.poses[1].theta))[:3, 3]
    put(stage, "post", "cylinder", [0.02, 0.2], between)
    beside = stage.path
    for kind, stop in (("time_optimal", True), ("s_curve", False)):  # a spline, and segments
        with pytest.raises(InputError, match="on the way to 'pose 2' it collides .* post"):
            done(ask(stage, "plan", kind=kind, stop=stop, corner=0.02))
        assert stage.path["stopped"]["words"] == "collides"
    scene.move("post", scene.obstacles["post"].pose)  # what was refused may be free now
    assert stage.path is beside
    ask(stage, "move", id=stage.poses.poses[1].id, by="free")
    done(ask(stage, "plan", kind="s_curve", stop=False, corner=0.02))
    assert stage.playback is not None
    motion = stage.playback.trajectory
    assert not scene.collides(motion(np.linspace(0.0, motion.duration, 500))).any()
    ask(stage, "move", id=stage.poses.poses[1].id, by="level")
    done(ask(stage, "plan", kind="s_curve", stop=False, corner=0.02))
    motion = stage.playback.trajectory
    g = ARM.fk(motion(np.linspace(0.0, motion.duration, 500)))
    assert (g[:, 2, :3] @ g[0, 2, :3]).min() > np.cos(np.radians(3.01))  # what was upright at the start
    assert not scene.collides(motion(np.linspace(0.0, motion.duration, 500))).any()
    planned = stage.path
    end = stage.poses.poses[1]
    put(stage, "goal", "sphere", [0.05], ARM.fk(end.theta)[:3, 3])
    with pytest.raises(InputError, match="on the way to 'pose 2' the goal collides"):
        done(ask(stage, "plan", kind="s_curve", stop=False, corner=0.02))
    assert stage.path["stopped"]["words"] == "collides"
    assert_allclose(stage.path["stopped"]["position"], ARM.fk(end.theta)[:3, 3], atol=1e-6)
    ask(stage, "remove_obstacle", name="goal")
    assert stage.path is planned
    bare = Stage(ARM)
    ask(bare, "poses", joints=list(ARM.joint_names), poses=[pose.entry() for pose in stage.poses.poses])
    with pytest.raises(InputError, match="turn on the layer Collision"):
        ask(bare, "plan", kind="s_curve", stop=True)


def test_another_arm_keeps_the_obstacles() -> None:
    old = ready(scene_of())
    again = load_arm("rover_arm")
    new = Stage(again)
    new.take_over(old)
    done(new.collisions.due(new))
    assert [obstacle["name"] for obstacle in said(new, "obstacles")["obstacles"]] == ["table"]
    assert new.collisions.scene is not None
    assert new.collisions.scene.arm is again


def test_a_view_shows_a_scene_of_its_arm_alone_and_offers_its_file() -> None:
    scene = scene_of()
    with pytest.raises(InputError, match="make it with Scene"):
        Viewer(load_arm("elbow"), open_browser=False, scene=scene)
    with pytest.raises(InputError, match="scene must be"):
        Viewer(ARM, open_browser=False, scene="scene.toml")  # type: ignore[arg-type]
    with Viewer(ARM, open_browser=False, scene=scene) as viewer:
        assert viewer.scene is scene
        status, text, _ = get(viewer.url + "scene.toml")
        assert status == 200
        assert 'name = "table"' in text
    with Viewer(ARM, open_browser=False) as viewer:
        assert get(viewer.url + "scene.toml")[0] == 404
