"""The reach on the pages: what they are told agrees with the map, and its surface is closed and around the tool."""

from __future__ import annotations

import base64
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from catalogue import load
from recorded_poses import done
from twistarm import Arm, InputError, ReachMap, Viewer, reach_map
from twistarm.cli.application import run
from twistarm.design.mapping import sphere
from twistarm.design.voxel_map import Grid
from twistarm.support.strict_json import encode
from twistarm.viewer.parts.reach import drawing, hull
from twistarm.viewer.stage import Stage
from viewer_page import Page, stored

ROVER = load("rover_arm")


@pytest.fixture(scope="module")
def m() -> ReachMap:
    return reach_map(ROVER, 0.2, 26, method="fk", samples=100_000)


def shares_at(drawn: dict[str, Any], p: NDArray[np.float64]) -> NDArray[np.float64]:
    """The share that pages draw at points (k, 3), by the nearest centre of a cube."""
    bytes_ = np.frombuffer(base64.b64decode(drawn["shares"]), np.uint8).reshape(drawn["shape"])
    centres = [first + drawn["voxel"] * np.arange(n) for first, n in zip(drawn["first"], drawn["shape"], strict=True)]
    nearest = [np.abs(axis - each[:, None]).argmin(axis=1) for axis, each in zip(centres, p.T, strict=True)]
    return bytes_[tuple(nearest)] / 255 * drawn["best"]


def drawn_on(stage: Stage) -> list[dict[str, Any]]:
    return [message for message in stage.messages() if message["type"] == "reach"]


def test_pages_are_told_the_shares_of_the_map(m: ReachMap) -> None:
    drawn = drawing(m)
    p = ROVER.fk(ROVER.random_theta(3, 500))[:, :3, 3]
    assert m.at(p).max() > 0.1
    assert_allclose(shares_at(drawn, p), m.at(p), atol=drawn["best"] / 255)
    assert_array_equal(shares_at(drawn, p) > 0, m.at(p) > 0)
    assert drawn["best"] == m.share.max()
    corners = np.frombuffer(base64.b64decode(drawn["points"]), "<f4").reshape(-1, 3)
    ends = m.grid.centres(np.flatnonzero(m.counts))
    assert_allclose([corners.min(axis=0), corners.max(axis=0)], [ends.min(axis=0), ends.max(axis=0)], atol=0.11)
    faces = np.frombuffer(base64.b64decode(drawn["faces"]), "<u4")
    assert faces.max() == len(corners) - 1 == len(base64.b64decode(drawn["values"])) - 1


def test_fine_maps_are_drawn_coarser_by_the_best_of_their_cubes(m: ReachMap) -> None:
    counts = np.zeros((161, 5, 4), dtype=np.uint16)
    counts[0, 1, 2], counts[160, 4, 3] = 3, 26
    fine = replace(m, grid=Grid(0.01, (-80, 2, 7), counts.shape), counts=counts)
    drawn = drawing(fine)
    assert drawn["shape"] == [54, 2, 2]
    assert_allclose(drawn["first"], [-0.79, 0.03, 0.08])
    p = fine.grid.centres(np.array([0, np.ravel_multi_index((160, 4, 3), counts.shape)]))
    assert_allclose(shares_at(drawn, p), [3 / 26, 1.0], atol=1 / 255)
    ur5 = load("ur5")
    assert len(encode(drawing(reach_map(ur5, 0.05, 26, method="fk", samples=300_000)))) < 2e6


def test_a_quick_map_is_made_when_it_is_first_switched_on() -> None:
    stage = Stage(ROVER)
    assert stage.reach.due(stage) is None
    stage.needed = frozenset({"reach"})
    job = stage.reach.due(stage)
    assert job is not None
    assert stage.reach.due(stage) is None, "it is under way"
    assert job.key == "reach"
    assert drawn_on(stage) == []
    shares: list[float] = []
    job.finish(job.work(shares.append))
    assert shares == sorted(shares)
    assert len(shares) > 10
    (first,), (second,) = drawn_on(stage), drawn_on(stage)
    assert first is second  # encoded once
    assert 20 * first["voxel"] < 2 * sphere(ROVER)[1] < 40 * first["voxel"]
    p = ROVER.fk(ROVER.random_theta(3, 500))[:, :3, 3]
    assert (shares_at(first, p) > 0).mean() > 0.99
    assert stage.reach.due(stage) is None


def test_a_map_of_the_program_stays_before_a_quick_one(m: ReachMap) -> None:
    stage, drawn = Stage(ROVER), drawing(m)
    stage.needed = frozenset({"reach"})
    job = stage.reach.due(stage)
    stage.show_reach(drawn)
    done(job)
    assert drawn_on(stage) == [drawn]
    stage.show_reach(None)
    assert stage.visible["reach"] == [False, 2]


def test_a_map_stays_with_an_arm_that_reaches_the_same(m: ReachMap) -> None:
    stage = Stage(ROVER)
    stage.show_reach(drawing(m))
    same, other = Stage(load("rover_arm")), Stage(load("scara"))
    for new in (same, other):
        new.take_over(stage)
    assert (len(drawn_on(same)), len(drawn_on(other))) == (1, 0)
    assert other.visible["reach"][0]


def test_a_map_of_another_arm_is_refused(arm: Arm, viewer: Viewer, m: ReachMap) -> None:
    with pytest.raises(InputError, match=rf"another arm \(rover_arm\).* {arm.name} "):
        viewer.show_reach(m)
    own = reach_map(arm, 0.3, "position", method="fk", samples=1000)
    viewer.show_reach(own)
    with Page(viewer) as page:
        page.until(lambda: page.latest.get("visible", {}).get("reach", [False])[0])
        assert page.latest["reach"] == drawing(own)
        viewer.show_reach(None)
        page.until(lambda: not page.latest["visible"]["reach"][0])


def test_the_command_shows_a_map(
    m: ReachMap, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file, shown = str(m.save(tmp_path / "map.npz")), []
    monkeypatch.setattr(Viewer, "open_page", lambda view: True)
    monkeypatch.setattr(Viewer, "wait", lambda view: shown.append(view.save_html(tmp_path / "page.html")))
    assert run(["view", "rover_arm", "--reach", file]) in (0, None)
    assert stored(shown[0].read_text("utf-8"))["reach"] == drawing(m)
    capsys.readouterr()
    for refused in (["scara", "--reach", file], ["rover_arm", "--reach", file, "-o", str(tmp_path / "a.html")]):
        assert run(["view", *refused]) == 2
        assert len(capsys.readouterr().err.splitlines()) == 1
    assert len(shown) == 1


def volume(points, faces):
    """By the divergence theorem."""
    return np.linalg.det(points[faces]).sum() / 6


def winding(points, faces, p):
    """How often the surface goes round points (k, 3), by the solid angles of its triangles.

    A. van Oosterom & J. Strackee, The solid angle of a plane triangle, IEEE Trans. Biomed. Eng. 30(2), 1983.
    """
    a, b, c = np.moveaxis(points[faces] - p[:, None, None], 2, 0)
    la, lb, lc = (np.linalg.norm(each, axis=-1) for each in (a, b, c))
    ab, bc, ca = ((u * v).sum(axis=-1) for u, v in ((a, b), (b, c), (c, a)))
    across = (a * np.cross(b, c)).sum(axis=-1)
    return np.arctan2(across, la * lb * lc + ab * lc + bc * la + ca * lb).sum(axis=-1) / (2 * np.pi)


def ball(radius):
    x = np.arange(-12, 13)
    return (x[:, None, None] ** 2 + x[:, None] ** 2 + x**2 <= radius**2).astype(float)


def test_a_ball_has_its_volume_and_no_edge_is_open():
    points, faces, values = hull(7 * ball(10))
    assert 9.9**3 < volume(points, faces) / (4 / 3 * np.pi) < 10.1**3
    radii = np.linalg.norm(points - 12, axis=1)
    assert 9.3 < radii.min() < radii.max() < 10.7
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    there, count = np.unique(edges, axis=0, return_counts=True)
    back, again = np.unique(edges[:, ::-1], axis=0, return_counts=True)
    assert np.array_equal(there, back)
    assert np.array_equal(count, again)
    assert np.all(values == 7)


def test_a_hollow_has_a_wall_on_its_inside():
    points, faces, _ = hull(ball(10) - ball(5))
    p = np.array([[12.0, 12.0, 12.0], [12.0, 12.0, 19.5], [12.0, 12.0, 24.0]])
    assert winding(points, faces, p) == pytest.approx([0, 1, 0], abs=1e-9)


def test_the_tool_never_leaves_it_by_more_than_a_cube(rover):
    m = reach_map(rover, 0.15, "position", method="fk", samples=500_000)
    points, faces, _ = hull(m.counts)
    points = m.grid.voxel * (points + m.grid.lower)
    p = rover.fk(rover.random_theta(7, 300))[:, :3, 3]
    inside = winding(points, faces, p) > 0.5
    assert inside.mean() > 0.9
    assert (np.linalg.norm(p[~inside, None] - points, axis=2).min(axis=1) < m.grid.voxel).all()
    assert not (winding(points, faces, 5 * np.eye(3)) > 0.5).any()
