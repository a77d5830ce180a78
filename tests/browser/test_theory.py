"""Screw theory on the page: what is drawn, written and copied, against Pinocchio, NumPy and finite differences."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from joint_arms import from_urdf, random_chain
from twistarm import Arm, ArmBuilder, ReachMap, load_arm, plan_joint, reach_map
from twistarm.planning.trajectory import Trajectory
from twistarm.viewer import Viewer
from twistarm.viewer.scene.arm_drawing import arm_size
from waiting import WAIT, after_frames, settled, until

pytestmark = pytest.mark.browser

Matrix = NDArray[np.float64]
Opened = Callable[[], AbstractContextManager[Any]]
ARM = load_arm("rover_arm")
SMALL = {"width": 960, "height": 480}  # A small window.
FLOAT = 2e-6  # Meshcat keeps matrices in double precision, three.js's colours and points are float32.

DRAWN = """() => {
  const { view, parts: { theory } } = twistarm;
  const { scene } = view.viewer;
  scene.updateMatrixWorld(true);
  const toBase = scene.matrixWorld.clone().invert();
  const Vector3 = scene.position.constructor;
  const at = (object, point) => new Vector3(...point).applyMatrix4(object.matrixWorld).applyMatrix4(toBase).toArray();
  const arrow = ({ group, head }) => group.visible ? [at(group, [0, 0, 0]), at(head, [0, 0.5, 0])] : null;
  const matrix = (object) => toBase.clone().multiply(object.matrixWorld).elements;
  const { instant, axes, labels } = theory;
  const seen = labels.layer.hidden ? [] : labels.pins;
  return {
    axes, spatial: theory.spatial.arrows.map((two) => two.map(arrow)),
    body: theory.body.arrows.map((two) => two.map(arrow)),
    linear: matrix(theory.linear.body), angular: matrix(theory.angular.body),
    axis: [at(instant.axis, [0, -0.5, 0]), at(instant.axis, [0, 0.5, 0])], coils: instant.helix.children.length,
    velocity: arrow(instant.velocity), time: twistarm.state.frame.time,
    labels: seen.map(({ text }) => text.textContent),
  };
}"""
"""Every object of the theory as it stands in the scene, in base axes."""


@pytest.fixture(scope="module")
def viewer() -> Iterator[Viewer]:
    with Viewer(ARM, [0.1, 0.4, -0.9, 0.4, 0.5], open_browser=False) as served:
        yield served


@pytest.fixture(scope="module")
def page(open_page: Opened, viewer: Viewer) -> Iterator[Any]:
    """One page for all of the rover arm: opening one takes a second."""
    with open_page() as opened:
        opened.context.grant_permissions(["clipboard-read", "clipboard-write"])
        opened.set_viewport_size(SMALL)
        settled(opened, viewer.url)
        show_theory(opened)
        yield opened


def show_theory(page: Any) -> None:
    page.get_by_role("tab", name="Theory").click()
    until(page, "document.getElementById('theory-rank')?.textContent")


def switch(page: Any, *names: str, on: bool = True) -> None:
    for name in names:
        page.locator("#theory-layers").get_by_label(name, exact=True).set_checked(on)


def shown(page: Any, theta: Matrix) -> dict[str, Any]:
    """What is drawn once the numbers on the page are those of theta."""
    until(page, f"Math.abs(twistarm.state.frame.theta[1] - {float(theta[1])!r}) < 1e-12")
    after_frames(page)
    return page.evaluate(DRAWN)  # type: ignore[no-any-return]


def assert_columns(drawn: dict[str, Any], arm: Arm, theta: Matrix, only: int | None = None) -> None:
    """Both Jacobians' columns as arrows from their frames, to the scales that the panel says."""
    scales = np.repeat([drawn["axes"]["linear"], drawn["axes"]["angular"]], 3)
    slide = np.array(arm.units) == "m"
    g = arm.fk(theta)
    turned = np.kron(np.eye(2), g[:3, :3]) @ arm.body_jacobian(theta)
    for name, J, origin in (("spatial", arm.spatial_jacobian(theta), np.zeros(3)), ("body", turned, g[:3, 3])):
        for i in range(arm.n):
            column = J[:, i] * scales
            for arrow, part in zip(drawn[name][i], (column[:3], column[3:]), strict=True):
                part = part * (arm.reach if slide[i] else 1.0)
                if only in (None, i) and np.linalg.norm(part) > 0.02 * arm_size(arm):
                    assert_allclose(arrow, [origin, origin + part], atol=FLOAT, err_msg=f"{name} {i}")
                elif only not in (None, i) or np.linalg.norm(part) < 1e-9:
                    assert arrow is None, f"{name} {i}"


def assert_ellipsoids(drawn: dict[str, Any], arm: Arm, theta: Matrix) -> None:
    """M Mᵀ = s² J Jᵀ of the drawn ball's matrix M; a flat direction has a little thickness."""
    J = arm.hybrid_jacobian(theta) * np.where(np.array(arm.units) == "m", arm.reach, 1.0)
    thick = (0.002 * arm_size(arm)) ** 2
    for name, rows in (("linear", J[:3]), ("angular", J[3:])):
        M = np.reshape(drawn[name], (4, 4)).T
        assert_allclose(M[:3, 3], arm.fk(theta)[:3, 3], atol=FLOAT)
        expected = drawn["axes"][name] ** 2 * rows @ rows.T
        values, vectors = np.linalg.eigh(expected)
        assert_allclose(M[:3, :3] @ M[:3, :3].T, vectors @ np.diag(np.maximum(values, thick)) @ vectors.T, atol=FLOAT)


def assert_screw(drawn: dict[str, Any], twist: Matrix, velocity: Matrix, close: float = 1e-5) -> None:
    """The line lies on the axis of (v, w): w × v + … = 0 across, that is v − h w = −w × q for its points q."""
    start, end = map(np.array, drawn["axis"])
    v, w = twist[:3], twist[3:]
    assert np.linalg.norm(end - start) > 1
    assert_allclose(np.cross(end - start, w if w.any() else v), 0, atol=close)
    for q in (start, end):
        at_q = v + np.cross(w, q)  # the velocity of the body's point at q: along the axis alone
        assert_allclose(np.cross(at_q, w), 0, atol=close)
    tail, tip = map(np.array, drawn["velocity"])
    assert_allclose(tip - tail, drawn["axes"]["linear"] * velocity, atol=0.2 * close)


def motion_of(arm: Arm) -> Trajectory:
    rng = np.random.default_rng(5)
    return plan_joint(arm, [arm.ready, arm.random_theta(rng)], limits={"velocity": 0.6, "acceleration": 1.0})


@pytest.mark.smoke
def test_columns_ellipsoids_and_labels(page: Any, viewer: Viewer) -> None:
    theta = viewer.theta
    switch(page, "Labels", "Columns of Jˢ", "Columns of Jᵇ", "Linear ellipsoid", "Angular ellipsoid")
    until(page, "Object.values(twistarm.parts.theory.visible).filter(Boolean).length >= 8")
    drawn = shown(page, theta)
    assert_columns(drawn, ARM, theta)
    assert_ellipsoids(drawn, ARM, theta)
    pitches = (
        f"{name} h = {'∞' if unit == 'm' else '0'}" for name, unit in zip(ARM.joint_names, ARM.units, strict=True)
    )
    assert drawn["labels"] == [*pitches, "S", "T"]
    moved = np.array([-0.2, 0.1, 0.7, -0.3, 1.2])
    viewer.show(moved)
    drawn = shown(page, moved)
    assert_columns(drawn, ARM, moved)
    assert_ellipsoids(drawn, ARM, moved)
    page.get_by_label("all columns").uncheck()
    page.get_by_label("Joint whose screw").select_option("elbow")
    assert_columns(shown(page, moved), ARM, moved, only=2)
    page.get_by_label("Joint whose screw").select_option("")
    page.get_by_label("all columns").check()
    switch(page, "Columns of Jˢ", "Columns of Jᵇ", "Linear ellipsoid", "Angular ellipsoid", on=False)


def test_the_screw_of_a_motion_and_the_trace_it_leaves(page: Any, viewer: Viewer) -> None:
    switch(page, "Instantaneous screw", "Trace")
    trajectory = motion_of(ARM)
    viewer.play(trajectory, speed=1.0)
    trace = "twistarm.parts.theory.trace.pieces"
    until(page, f"twistarm.state.frame.time > 0.6 && {trace}.flat().length > 5")
    page.get_by_role("button", name="Pause").click()
    until(page, "!twistarm.state.frame.running")
    drawn = page.evaluate(DRAWN)
    theta, rates = trajectory(drawn["time"]), trajectory(drawn["time"], 1)
    assert_screw(drawn, ARM.spatial_jacobian(theta) @ rates, ARM.hybrid_jacobian(theta)[:3] @ rates)
    assert drawn["coils"] == 1
    motion = copied(page, "Instantaneous screw")
    assert_allclose(motion["twist"], ARM.spatial_jacobian(theta) @ rates, atol=1e-12)
    assert_allclose(twist_of(motion), motion["twist"], atol=1e-12)
    points = np.array(page.evaluate(f"{trace}.flat().map((point) => point.toArray())"))
    way = ARM.fk(trajectory(np.linspace(0, drawn["time"], 2000)))[:, :3, 3]
    passed = points[-min(10, len(points) - 1) :]
    assert len(passed) > 3
    assert np.linalg.norm(passed[:, None] - way, axis=-1).min(axis=1).max() < 1e-3
    viewer.show(theta + 0.01)  # elsewhere: no longer the motion's
    until(page, "document.querySelector('#theory-joint').selectedOptions[0].text.startsWith('last moved')")
    page.get_by_role("button", name="Clear the trace").click()
    assert page.evaluate(f"{trace}.length") == 0
    switch(page, "Instantaneous screw", "Trace", on=False)


def copied(page: Any, name: str) -> Any:
    """What the button beside these numbers copies, as Python reads it."""
    button = page.get_by_role("button", name=f"Copy {name}", exact=True)
    page.evaluate("document.getElementById('copied').replaceChildren()")
    end = time.monotonic() + WAIT
    while not page.locator("#copied").inner_text():  # an arm that is loaded takes the button away
        assert time.monotonic() < end
        button.press("Enter")
        after_frames(page)
    return eval(page.evaluate("navigator.clipboard.readText()"), {"__builtins__": {"float": float}})


def twist_of(screw: Mapping[str, Any]) -> Matrix:
    """The twist of a screw by MLS §2.3.3: v = M (q × u + h u), w = M u; v = M u for infinite pitch."""
    axis, h, size = np.array(screw["axis"]), screw["pitch"], screw["magnitude"]
    if np.isinf(h):
        return size * np.r_[axis, 0, 0, 0]
    assert axis @ screw["point"] == pytest.approx(0, abs=1e-12)  # the point nearest to the origin
    return size * np.r_[np.cross(screw["point"], axis) + h * axis, axis]


def follower(folder: Path) -> Arm:
    """Two parallel axes, 0.4 m apart, of which the second turns the first one back."""
    joint = """<joint name="{0}" type="revolute"><parent link="{0}"/><child link="{1}"/><origin xyz="{2} 0 0"/>
      <axis xyz="0 0 1"/><limit lower="-2" upper="2" velocity="1" effort="1"/>{3}</joint>"""
    links = "".join(f'<link name="{name}"/>' for name in "abc")
    second = joint.format("b", "c", 0.4, '<mimic joint="a" multiplier="-1.0"/>')
    file = folder / "follower.urdf"
    file.write_text(f'<robot name="pair">{links}{joint.format("a", "b", 0, "")}{second}</robot>')
    return load_arm(file, tip="c")


def elbow() -> Arm:
    """Three parallel axes, 0.5 m apart, along x at rest."""
    built = ArmBuilder("elbow")
    for i in range(3):
        built = built.revolute(f"j{i}", [0, 0, 1], [0.5 * i, 0, 0])
    return built.tool([[1, 0, 0, 1.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]).build()


def scissors(sigma: float) -> Arm:
    """Two slides at an angle 2 a to each other: singular values √2 cos a along x and √2 sin a = sigma along y."""
    a = np.arcsin(sigma / np.sqrt(2))
    built = ArmBuilder("scissors").prismatic("p", [np.cos(a), np.sin(a), 0], lower=-1, upper=1)
    return built.prismatic("q", [np.cos(a), -np.sin(a), 0], lower=-1, upper=1).tool(np.eye(4)).build()


Show = Callable[[Arm, Any], None]


@pytest.fixture(scope="module")
def bench(open_page: Opened) -> Iterator[tuple[Any, Show]]:
    """A page with the panel Theory, and how it shows an arm at theta."""
    with Viewer(ARM, open_browser=False) as viewer, open_page() as page:
        page.context.grant_permissions(["clipboard-read", "clipboard-write"])
        settled(page, viewer.url)
        show_theory(page)

        def show(arm: Arm, theta: Any) -> None:
            viewer.load(arm)
            viewer.show(theta)
            end = time.monotonic() + WAIT
            while np.abs(np.subtract(copied(page, "g_st"), arm.fk(theta))).max() > 1e-9:
                assert time.monotonic() < end

        yield page, show


CHAIN = random_chain(["helical", "planar", "revolute"], 4)

ARMS: dict[str, Callable[[Path], Arm]] = {
    "rover_arm": lambda _: load_arm("rover_arm"),
    "joints": lambda folder: from_urdf(*CHAIN, folder),
    "follower that turns back": follower,
}


@pytest.mark.parametrize("name", ARMS)
def test_the_numbers_of_an_arm(bench: tuple[Any, Show], tmp_path: Path, name: str) -> None:
    arm = ARMS[name](tmp_path)
    theta = arm.random_theta(np.random.default_rng(3))
    page, show = bench
    show(arm, theta)
    g, spatial, body = (found[0] for found in arm.pinocchio.kinematics(theta[None], arm.base, arm.tip_link))
    for title, expected in (("g_st", g), ("Jˢ", spatial), ("Jᵇ", body)):
        assert_allclose(copied(page, title), expected, atol=1e-12, err_msg=title)
    rows = page.get_by_role("table", name="Jˢ").get_by_role("row").all_inner_texts()[1:]
    assert_allclose([[float(x.replace("−", "-")) for x in row.split()[1:]] for row in rows], spatial, atol=5.001e-4)
    rate = np.where(np.array(arm.units) == "m", arm.reach, 1.0)  # that counts as 1 rad/s
    J = body * rate / np.repeat([arm.reach, 1.0], 3)[:, None]
    values = copied(page, "Singular values")
    assert_allclose(values, np.linalg.svd(J, compute_uv=False), atol=1e-11)
    written = page.locator("#theory-numbers")
    rank = np.linalg.matrix_rank(J, 1e-9)
    assert written.get_by_text(f"Rank {rank} of {min(6, arm.n)}").is_visible()
    lines = written.locator("dl").first.locator("dd").all_inner_texts()
    condition, product = (float(line.replace("−", "-").replace("∞", "inf")) for line in lines[1:])
    assert condition == (pytest.approx(values[0] / values[-1], rel=2e-3) if rank == len(values) else np.inf)
    assert product == pytest.approx(np.prod(values), rel=6e-3)
    ellipsoids = copied(page, "Ellipsoids")
    for half, of in enumerate(("linear", "angular")):
        long, directions = np.array(ellipsoids[of]["semi_axes"]), np.array(ellipsoids[of]["directions"])
        rows = g[:3, :3] @ (body * rate)[3 * half : 3 * half + 3]
        assert_allclose(directions @ np.diag(long**2) @ directions.T, rows @ rows.T, atol=1e-11, err_msg=of)
        assert_allclose(directions.T @ directions, np.eye(3), atol=1e-14)
        assert np.all(np.diff(long) <= 0)
    for i, joint in enumerate(arm.joint_names):
        page.get_by_label("Joint whose screw").select_option(str(i))
        screw = copied(page, "Instantaneous screw")
        assert (screw["name"], np.isinf(screw["pitch"])) == (joint, np.linalg.norm(spatial[3:, i]) < 1e-12)
        assert_allclose(twist_of(screw), spatial[:, i], atol=1e-11)
    screws = copied(page, "Joint screws")
    assert [screw["name"] for screw in screws] == list(arm.moving_names)
    columns = np.array([twist_of(screw) for screw in screws]).T @ arm.coupling.A
    assert_allclose(columns, spatial, atol=1e-11)


def test_singular_and_nearly_singular_postures(bench: tuple[Any, Show]) -> None:
    page, show = bench

    def words(arm: Arm, theta: Any) -> str:
        show(arm, theta)
        return str(page.locator("#theory-rank").inner_text())

    arm = elbow()
    lost = words(arm, [0.7, 0.0, 0.0])  # stretched along the tool's x
    assert ("Rank 2" in lost, "its x axis" in lost, "nearly" in lost) == (True, True, False)
    near = words(arm, [0.7, 0.02, -0.01])
    assert ("Rank 3" in near, "nearly" in near) == (True, True)
    assert words(arm, [0.7, 0.9, 0.8]) == "Rank 3 of 3."
    for value, weak in ((1e-7, True), (0.039, True), (0.041, False)):
        assert ("its y axis" in words(scissors(value), [0.1, 0.2])) == weak
        assert copied(page, "Singular values")[1] == pytest.approx(value, abs=1e-15)
    show(arm, [0.3, 0.5, -0.4])
    disc = copied(page, "Ellipsoids")
    assert_allclose(disc["linear"]["semi_axes"][2], 0, atol=1e-15)
    assert_allclose(disc["angular"]["semi_axes"], [np.sqrt(3), 0, 0], atol=1e-14)  # a line along z


SLICE = """() => {
  const { map, slice, group } = twistarm.parts.theory.reach;
  const { data, width, height } = slice.material.map.image;
  const bar = getComputedStyle(document.getElementById('reach-bar')).backgroundImage;
  return {
    width, height, data: [...data], matrix: slice.matrix.elements, best: map.best, voxel: map.voxel,
    surface: [...group.children[0].geometry.attributes.position.array.slice(0, 300)],
    bar: [...bar.matchAll(/rgb\\((\\d+), (\\d+), (\\d+)\\)/g)].map((found) => found.slice(1).map(Number)),
  };
}"""
"""The slice as it is drawn, and the colours of its legend."""


def assert_slice(page: Any, m: ReachMap, theta: Matrix, across: int | None) -> None:
    """The slice passes through the tool, and the legend's colours in it are the shares of the map."""
    until(page, f"Math.abs(twistarm.state.frame.theta[1] - {float(theta[1])!r}) < 1e-12")
    after_frames(page)
    drawn = page.evaluate(SLICE)
    matrix = np.reshape(drawn["matrix"], (4, 4)).T
    tool = ARM.fk(theta)[:3, 3]
    normal, corner = matrix[:3, 2], matrix[:3, 3]
    assert normal @ (tool - corner) == pytest.approx(0, abs=1e-6)
    assert_allclose(normal[2] if across is None else np.delete(normal, across), 0, atol=1e-12)
    if across is None:
        assert normal @ corner == pytest.approx(0, abs=1e-12)  # the base's z axis is in the plane
    u, v = (np.arange(n)[:, None] / n + 0.5 / n for n in (drawn["width"], drawn["height"]))
    p = corner + (v * matrix[:3, 1])[:, None] + u * matrix[:3, 0]
    shares = m.at(p)
    pixels = np.reshape(drawn["data"], (*shares.shape, 4))
    edges = np.abs(p / m.grid.voxel + 0.5 - np.round(p / m.grid.voxel + 0.5)).min(axis=-1) < 1e-6  # either cube
    assert np.count_nonzero(shares) > 500
    assert_array_equal((pixels[..., 3] == 255)[~edges], (shares > 0)[~edges])
    ends = np.linspace(0, drawn["best"], len(drawn["bar"]))
    expected = np.stack([np.interp(shares, ends, channel) for channel in np.transpose(drawn["bar"])], axis=-1)
    seen = (shares > 0) & ~edges
    assert_allclose(pixels[..., :3][seen], expected[seen], atol=3)


def test_the_reach(page: Any, viewer: Viewer, tmp_path: Path, open_page: Opened) -> None:
    reach = "twistarm.parts.theory.reach"
    switch(page, "Reach")
    until(page, f"{reach}.map && !document.getElementById('reach-legend').hidden")
    assert "26 directions" in page.locator("#reach-words").inner_text()
    m = reach_map(ARM, 0.15, 26, method="fk", samples=200_000)
    viewer.show_reach(m)
    until(page, f"{reach}.map.voxel === 0.15")
    assert page.locator("#reach-best").inner_text() == f"{100 * m.share.max():.0f} %"
    for theta in (viewer.theta, np.array([0.2, 0.9, -1.4, 0.2, 0.1])):
        viewer.show(theta)
        assert_slice(page, m, theta, None)
    page.get_by_label("Plane of the slice").select_option("across y")
    assert_slice(page, m, theta, 1)
    cubes = m.grid.centres(np.flatnonzero(m.counts))
    surface = np.reshape(page.evaluate(SLICE)["surface"], (100, 1, 3))
    assert np.abs(surface - cubes).max(axis=-1).min(axis=1).max() < m.grid.voxel  # from the middle of one
    saved = viewer.save_html(tmp_path / "reach.html")
    switch(page, "Reach", on=False)
    until(page, f"document.getElementById('reach-legend').hidden && !{reach}.group.visible")
    with open_page() as opened:
        opened.goto(saved.as_uri())
        until(
            opened,
            "globalThis.twistarm?.parts.theory.reach.group.visible && twistarm.parts.theory.reach.map.voxel === 0.15",
        )
        opened.get_by_role("tab", name="Theory").click()
        switch(opened, "Reach", on=False)
        until(opened, f"document.getElementById('reach-legend').hidden && !{reach}.group.visible")
