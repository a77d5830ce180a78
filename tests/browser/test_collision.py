"""Collisions on the page: red links, the nearest pair, the band of a motion, obstacles changed and saved."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from twistarm import Scene, load_arm, plan_joint
from twistarm.viewer import Viewer
from twistarm.viewer.saved_page import on_show, stand_alone
from twistarm.viewer.scene.arm_drawing import Drawing
from twistarm.viewer.stage import Stage
from waiting import settled, until

pytestmark = [pytest.mark.browser, pytest.mark.smoke]

RED = """Object.entries(twistarm.parts.links.nodes).filter(([, path]) => {
  const colours = [];
  twistarm.view.node(path).traverse(({ material }) => {
    if (material?.isMeshLambertMaterial) colours.push(material.color.getHexString());
  });
  return colours.length > 0 && colours.every((colour) => colour === "d32f2f");
}).map(([name]) => name)"""


def test_collisions_are_shown_and_obstacles_changed_and_saved(page: Any, tmp_path: Path) -> None:
    arm = load_arm("rover_arm", limits={"acceleration": 3.0})
    file = Scene(arm).save(tmp_path / "scene.toml")
    with Viewer(arm, open_browser=False, scene=Scene.load(arm, file)) as viewer:
        settled(page, viewer.url)
        page.get_by_label("Collision", exact=True).check()
        until(page, "twistarm.parts.scene.ready && twistarm.collision.shapes.length > 0")
        assert page.locator("#distance span").inner_text().endswith(" mm")
        assert page.evaluate(RED) == []

        # An obstacle that is put onto the tool.
        page.get_by_role("tab", name="Scene").click()
        page.get_by_label("Name of the obstacle to add").fill("stone")
        page.get_by_role("button", name="Sphere", exact=True).click()
        until(page, "twistarm.collision.obstacles.length === 1 && twistarm.parts.scene.gizmo.group.visible")
        x, y, z = arm.fk(arm.ready)[:3, 3]
        for axis, value in zip("xyz", (x, y, z), strict=True):
            box = page.get_by_label(f"stone, {axis}, metres")
            box.fill(f"{value:.4f}")
            box.press("Enter")
        # The first number alone brings them together: the scene is asked once all three have been answered.
        until(page, "twistarm.link.underway === 0 && twistarm.link.pending.size === 0")
        assert page.locator("#collides").inner_text().startswith("Collision: ")
        scene = viewer.scene
        assert scene is not None
        hit = {name for contact in scene.contacts(arm.ready) for name in contact.links} - {"stone"}
        assert set(page.evaluate(RED)) == hit
        assert np.abs(scene.obstacles["stone"].pose[:3, 3] - [x, y, z]).max() < 1e-3

        # A motion away from it: red where it begins.
        viewer.play(plan_joint(arm, [arm.ready, arm.ready + [0.4, 0.0, 0.0, 0.0, 0.0]]))
        until(page, "document.getElementById('band').children.length === 1")
        assert page.evaluate("parseFloat(document.getElementById('band').firstChild.style.left)") == 0
        until(page, "!twistarm.state.frame.running && document.getElementById('collides').textContent === ''")
        assert page.evaluate(RED) == []

        page.get_by_role("button", name="Save", exact=True).click()
        until(page, "document.getElementById('save-scene').disabled")
        assert set(Scene.load(arm, file).obstacles) == {"stone"}
        page.get_by_role("button", name="Remove stone").click()
        until(page, "twistarm.collision.obstacles.length === 0")


def test_a_refusal_goes_with_its_cause(page: Any, other: Any) -> None:
    arm = load_arm("rover_arm", limits={"acceleration": 3.0})
    goal = arm.ready + np.eye(arm.n)[1]
    scene = Scene(arm)
    scene.add_box("crate", (0.15, 0.15, 0.15), arm.fk(goal)[:3, 3])
    with Viewer(arm, open_browser=False, scene=scene) as viewer:
        settled(page, viewer.url)
        page.get_by_role("tab", name="Poses").click()
        for number, theta in enumerate((arm.ready, goal), 1):
            viewer.show(theta)
            until(page, f"twistarm.state.frame.theta[1] === {theta[1]}")
            page.get_by_role("button", name="Record").click()
            page.get_by_role("button", name=f"Delete pose {number}").wait_for()
        page.get_by_role("button", name="Plan", exact=True).click()
        until(page, "twistarm.parts.path.data.stopped && !document.getElementById('error').hidden")
        settled(other, viewer.url)
        other.get_by_role("tab", name="Scene").click()
        other.get_by_role("button", name="Remove crate").click()
        until(page, "!twistarm.parts.path.data.stopped && document.getElementById('error').hidden")


def test_a_saved_page_shows_obstacles_and_what_the_arm_holds(page: Any, tmp_path: Path) -> None:
    arm = load_arm("rover_arm")
    scene = Scene(arm)
    scene.add_box("table", (0.4, 1.0, 0.04), [0.8, 0.0, 0.3])
    scene.add_sphere("stone", 0.03, arm.fk(arm.ready)[:3, 3])
    scene.attach("stone", theta=arm.ready, touching=["left_finger", "right_finger"])
    stage = Stage(arm, None, scene)
    job = stage.collisions.due(stage)
    assert job is not None
    job.finish(job.work(lambda share: None))
    (tmp_path / "page.html").write_text(stand_alone(on_show(stage, Drawing(arm).whole())), encoding="utf-8")
    page.goto((tmp_path / "page.html").as_uri())
    until(page, "'drawn' in document.body.dataset")
    standing = "twistarm.collision.obstacles.map(({ name, mesh }) => [name, ...mesh.matrix.elements.slice(12, 15)])"
    before = {name: np.array(at) for name, *at in page.evaluate(standing)}
    assert np.abs(before["table"] - [0.8, 0.0, 0.3]).max() < 1e-6
    assert np.abs(before["stone"] - arm.fk(arm.ready)[:3, 3]).max() < 1e-5
    page.get_by_role("button", name="zero", exact=True).click()
    until(page, "twistarm.state.frame.theta.every((value) => value === 0)")
    after = {name: np.array(at) for name, *at in page.evaluate(standing)}
    assert np.abs(after["stone"] - arm.fk(np.zeros(arm.n))[:3, 3]).max() < 1e-5
    shown = "twistarm.view.node('/collision').visible"
    assert not page.evaluate(shown)
    page.get_by_label("Collision", exact=True).check()
    assert page.evaluate(shown)
    assert page.evaluate("twistarm.collision.shapes.length") == len(scene.links)
    page.get_by_role("tab", name="Scene").click()
    assert page.get_by_role("button", name="Remove table").is_disabled()
