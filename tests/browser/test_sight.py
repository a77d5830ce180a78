"""How the arm is looked at: from which side, which of its links, how exactly; and how a missed target is seen."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from arms import load
from twistarm import load_arm, solve_ik
from twistarm.ik import Pose
from twistarm.viewer import Viewer
from waiting import after_frames, settled, until

pytestmark = pytest.mark.browser

TOWARDS = """() => {
  const { camera, controls, scene } = twistarm.view.viewer;
  scene.updateMatrixWorld(true);
  const [eye, at] = [camera.position, controls.target].map((each) => scene.worldToLocal(each.clone()));
  return eye.sub(at).normalize().toArray();
}"""
"""The direction from what is looked at towards the camera, in base axes."""

SIDES = {"front": [1, 0, 0], "right": [0, -1, 0], "top": [0, 0, 1]}


ARM = load("rover_arm_6dof")


@pytest.fixture
def page(shown: Callable[[str], tuple[Any, Viewer]]) -> Any:
    """The one page, as it was at first."""
    page, viewer = shown(ARM.name)
    viewer.show(ARM.ready)
    until(page, f"twistarm.state.frame.theta.every((value, i) => value === {ARM.ready.tolist()}[i])")
    page.evaluate("twistarm.parts.links.recall({ hidden: [], opacity: 1 }), twistarm.view.fit()")
    return page


OUTERMOST = """() => {
  const { camera } = twistarm.view.viewer;
  const seen = [];
  for (const layer of ["/arm", "/screws", "/frames"]) twistarm.view.node(layer).traverseVisible((part) => {
    if (!part.geometry) return;
    const { array, count } = part.geometry.getAttribute("position");
    for (let i = 0; i < count; i += 1) {
      seen.push(new MeshCat.THREE.Vector3().fromArray(array, 3 * i).applyMatrix4(part.matrixWorld).project(camera));
    }
  });
  const pane = document.getElementById("pane").getBoundingClientRect();
  const xs = seen.map(({ x }) => ((1 + x) / 2) * pane.width + pane.left);
  const ys = seen.map(({ y }) => ((1 - y) / 2) * pane.height + pane.top);
  const over = document.getElementById("switches").getBoundingClientRect().bottom;
  return [
    Math.min(...xs) - pane.left, pane.right - Math.max(...xs), Math.min(...ys) - over, pane.bottom - Math.max(...ys),
    pane.height - over,
  ];
}"""
"""How far within the sides of what is free of the view everything drawn lies [px]: left, right, top and bottom; the
height of what is free."""


def in_view(page: Any) -> bool:
    """Whether all that is drawn can be seen, and is as large as the view allows."""
    *margins, height = page.evaluate(OUTERMOST)
    across, along = margins[:2], margins[2:]
    return min(margins) > 0 and (sum(across) < 0.3 * height or sum(along) < 0.3 * height)


@pytest.mark.smoke
def test_the_faces_of_the_cube_show_the_arm_from_that_side(page: Any) -> None:
    first = page.evaluate(TOWARDS)
    for side in ("front", "right", "top"):  # by keyboard
        face = page.get_by_role("button", name=side, exact=True)
        face.focus()
        page.keyboard.press("Enter")
        until(page, "twistarm.presets.moving === 0")
        assert_allclose(page.evaluate(TOWARDS), SIDES[side], atol=2e-3)
        assert in_view(page)
    page.get_by_role("button", name="Fit view", exact=True).click()
    assert_allclose(page.evaluate(TOWARDS), first, atol=1e-6)


def test_links_are_hidden_and_seen_through_and_another_page_can_be_told(page: Any) -> None:
    forearm = page.evaluate("twistarm.state.hello.links.forearm")
    shown = f"twistarm.view.node({forearm!r}).visible"
    page.get_by_text("View", exact=True).click()
    page.get_by_role("button", name="Hide forearm", exact=True).focus()
    page.keyboard.press("Enter")
    assert not page.evaluate(shown)
    page.get_by_role("slider", name="Opacity").fill("0.4")
    page.get_by_role("button", name="See through upper_arm", exact=True).click()
    opacity = """(name) => {
      const found = [];
      const node = twistarm.view.node(twistarm.state.hello.links[name]);
      node.traverse(({ material }) => material && found.push(material.opacity));
      return found;
    }"""
    assert set(page.evaluate(opacity, "forearm")) == {0.4}
    assert max(page.evaluate(opacity, "upper_arm")) < 0.2
    told = page.evaluate("twistarm.parts.links.remembered()")
    assert (told["hidden"], told["faint"], told["opacity"]) == (["forearm"], ["upper_arm"], 0.4)
    page.get_by_role("button", name="All", exact=True).click()
    assert page.evaluate(shown)
    assert set(page.evaluate(opacity, "upper_arm")) == {1}
    page.evaluate("(told) => twistarm.parts.links.recall(told)", told)
    assert not page.evaluate(shown)
    assert page.get_by_role("button", name="Hide forearm", exact=True).get_attribute("aria-pressed") == "true"
    page.keyboard.press("Escape")


TREE = """() => {
  const name = (item) => item?.querySelector("button").title.replace("Hide ", "") ?? null;
  const items = [...document.querySelectorAll("#links li")];
  return Object.fromEntries(items.map((item) => [name(item), name(item.parentElement.closest("li"))]));
}"""

EXTRAS = """() => twistarm.parts.links.bodies.map(({ node, mesh }) => {
  mesh.updateMatrixWorld(true);
  return [node, mesh.matrix.toArray()];
})"""


def test_each_link_has_its_place_in_the_tree_a_frame_and_collision_shapes(page: Any) -> None:
    assert ARM.description is not None
    joints = ARM.description.joints.values()
    parents = {joint.child: joint.parent for joint in joints}
    assert page.evaluate(TREE) == {name: parents.get(name) for name in ARM.description.links}
    page.get_by_text("View", exact=True).click()
    for words in ("Frame of", "Collision shapes of"):
        page.get_by_role("button", name=f"{words} forearm", exact=True).click()
    until(page, "twistarm.parts.links.bodies.length >= 2")  # the shapes come from the process
    frame, *shapes = page.evaluate(EXTRAS)
    pose = ARM.poses(ARM.ready)["forearm"]
    assert_allclose(np.reshape(frame[1], (4, 4)).T, pose, atol=1e-9)
    assert {each[0] for each in shapes} == {frame[0]}
    assert not page.evaluate("twistarm.view.node('/collision').visible")
    page.get_by_role("button", name="All", exact=True).click()
    assert page.evaluate("twistarm.parts.links.bodies.length") == 0
    page.keyboard.press("Escape")


def forbidden() -> Any:
    """A pose that the arm would meet but for the limit of its elbow."""
    theta = ARM.ready.copy()
    theta[2] = ARM.limits.upper[2] + 0.4
    g = ARM.fk(theta)
    found = solve_ik(ARM, Pose(g))
    assert not found.converged
    assert found.unlimited is not None
    return g


ASK = """([position, xyzw]) => twistarm.parts.target.solve({
  position: new MeshCat.THREE.Vector3(...position), quaternion: new MeshCat.THREE.Quaternion(...xyzw),
})"""

GHOST = """() => {
  const { ghost, target } = twistarm.parts;
  return [target.reported.ghost, ghost.arm.parts.length, ghost.frame.children.length, ghost.frame.position.toArray()];
}"""


def test_an_unmet_target_is_drawn_with_the_arm_that_would_meet_it(page: Any) -> None:
    g = forbidden()
    page.get_by_label("Kind of target").select_option("pose")
    page.evaluate(ASK, [g[:3, 3].tolist(), Rotation.from_matrix(g[:3, :3]).as_quat().tolist()])
    after_frames(page)
    assert page.locator("#target-words").inner_text().startswith("✕")
    theta, copies, parts, place = page.evaluate(GHOST)
    poses = ARM.poses(theta)
    assert_allclose(poses[ARM.tip], g, atol=1e-5)  # it does meet the target
    i = int(np.argmax(np.abs(theta) - ARM.limits.upper))
    needed = f"{ARM.joint_names[i]} {np.degrees(theta[i]):.1f}°".replace("-", "−")
    assert needed in page.locator("#target-words details").text_content()
    assert copies > 10
    assert parts == 4  # three axes and the origin
    assert_allclose(place, g[:3, 3])
    drawn = page.evaluate(
        """() => {
          const { path, source, copy } = twistarm.parts.ghost.arm.parts.at(-1);
          const { scene } = twistarm.view.viewer;
          const inNode = twistarm.view.node(path).matrixWorld.clone().invert().multiply(source.matrixWorld);
          return [path, copy.matrix.toArray(), inNode.toArray()];
        }"""
    )
    copy, in_node = (np.array(each).reshape(4, 4).T for each in drawn[1:])
    assert_allclose(copy, poses[drawn[0].removeprefix("/arm/link:")] @ in_node, atol=1e-9)
    page.get_by_role("button", name="Clear target").click()
    until(page, "twistarm.parts.target.given === null")
    after_frames(page)
    assert page.evaluate(GHOST)[1:3] == [0, 0]


URDF = """<robot name="scaled"><link name="base"/><link name="arm"><visual><origin xyz="{half} 0 0"/><geometry>
<box size="{long} {wide} {wide}"/></geometry></visual></link><link name="tip"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
<joint name="end" type="fixed"><parent link="arm"/><child link="tip"/><origin xyz="{long} 0 0"/></joint></robot>"""

SCALE = """() => {
  const { floor, viewer } = twistarm.view;
  viewer.scene.updateMatrixWorld(true);
  const size = new MeshCat.THREE.Box3().setFromObject(floor.bar).getSize(new MeshCat.THREE.Vector3()).toArray();
  const away = viewer.camera.position.distanceTo(viewer.controls.target);
  return [floor.text.textContent, size, viewer.camera.near / away, viewer.camera.far / away];
}"""


@pytest.mark.parametrize("long", [48.0, 0.05])
def test_the_floor_s_scale_and_the_depth_of_the_view_suit_the_arm(page: Any, tmp_path: Path, long: float) -> None:
    (tmp_path / "scaled.urdf").write_text(URDF.format(long=long, half=long / 2, wide=long / 20))
    arm = load_arm(tmp_path / "scaled.urdf")
    with page.context.browser.new_context() as context, Viewer(arm, open_browser=False) as viewer:
        fresh = settled(context.new_page(), viewer.url)
        for zoom in (1.0, 0.1):
            fresh.evaluate(
                """(zoom) => {
                  const { camera, controls } = twistarm.view.viewer;
                  camera.position.sub(controls.target).multiplyScalar(zoom).add(controls.target);
                  twistarm.view.viewer.set_dirty();
                }""",
                zoom,
            )
            after_frames(fresh)
            words, size, near, far = fresh.evaluate(SCALE)
            number = words.removesuffix(" m")
            assert max(size) == pytest.approx(float(number), rel=1e-6)
            assert near < 0.05
            assert far > 2
            if zoom == 1.0:
                assert 0.1 < float(number) / long < 0.6
