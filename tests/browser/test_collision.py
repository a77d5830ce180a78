"""Collisions on the page: red links, the nearest pair, the band of a motion, obstacles changed and saved."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from twistarm import Scene, load_arm, plan_joint
from twistarm.viewer import Viewer
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
        until(page, "document.getElementById('collides').textContent.startsWith('Collision: ')")
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
