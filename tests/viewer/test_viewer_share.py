"""What the live view hands on: a saved page and its kinematics by matrix exponentials, and the motion as a file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.testing import assert_allclose

from twistarm import Arm, Trajectory, load_arm, save_trajectory
from twistarm.viewer import Viewer
from viewer_page import Page, get, stored, swing

ROUNDED = 1e-8  # Of joint values with nine decimals.
LIVE = {"collision", "colliding", "controls", "work", "notice", "done", "shapes"}


def downloaded(viewer: Viewer) -> Any:
    status, text, _ = get(viewer.url + "arm.html")
    assert status == 200
    return stored(text)


def test_the_page_is_told_what_a_page_of_the_view_is_told(arm: Arm, viewer: Viewer, tmp_path: Path) -> None:
    motion = swing(arm)
    viewer.play(motion, speed=0.5, loop=True)
    viewer.show_frames(False)
    with Page(viewer) as page:
        page.ask(type="seek", time=0.25)
        page.ask(type="joint", name="finger", value=0.03)
        page.ask(type="record", name="mine")
        page.until(lambda: page.latest["findings"]["note"] == "")
        page.until(lambda: "history" in page.latest and page.latest["history"]["undo"] is not None)
        data = downloaded(viewer)
        live = {kind: message for kind, message in page.latest.items() if kind not in LIVE}
        live["hello"]["number"] = 0  # it is the same text each time
    assert {kind: message for kind, message in data.items() if kind in live} == live
    assert data["frame"] | data["player"] | {"type": ""} == {
        "type": "", "theta": motion(0.25).tolist(), "others": {"finger": 0.03}, "time": 0.25, "running": False,
        "rates": motion(0.25, 1).tolist(), "duration": motion.duration, "speed": 0.5, "loop": True,
    }  # fmt: skip
    assert data["hello"]["arm"]["poses"]["zero"] == [0.0, 0.0, 0.0]
    times, theta, rates = (np.array(data["motion"][what]) for what in ("times", "theta", "rates"))
    assert times[[0, -1]].tolist() == [0.0, motion.duration]
    assert np.diff(times).max() < 1 / 29
    assert_allclose(theta, motion(times), atol=ROUNDED)
    assert_allclose(rates, motion(times, 1), atol=ROUNDED)
    assert stored(viewer.save_html(tmp_path / "a.html").read_text()) == data


def test_a_motion_runs_on_and_one_of_its_own_from_its_start(arm: Arm, viewer: Viewer, tmp_path: Path) -> None:
    viewer.play(swing(arm), loop=True)
    with Page(viewer) as page:
        page.ask(type="record", name="mine")
    assert downloaded(viewer)["frame"]["running"] is True
    other = Trajectory(
        arm.joint_names, arm.units, [[0, 0, 0], [0.5, 0, 0]], [0, 1], [0, 1], np.array([[[0.5, 0, 0]], [[0, 0, 0]]])
    )
    data = stored(viewer.save_html(tmp_path / "a.html", other).read_text())
    assert (data["frame"]["time"], data["frame"]["running"], data["player"]["loop"]) == (0.0, True, False)
    assert [pose["name"] for pose in data["program"]["poses"]] == ["mine"]
    theta = np.array(data["motion"]["theta"])
    assert_allclose(theta[:, 0], 0.5 * np.array(data["motion"]["times"]), atol=ROUNDED)
    drawn = np.array(data["path"]["points"])
    assert_allclose(np.linalg.norm(drawn[:, None] - arm.fk(theta)[:, :3, 3], axis=-1).min(axis=1), 0.0, atol=0.01)


def test_the_motion_on_show_is_downloaded(arm: Arm, viewer: Viewer, tmp_path: Path) -> None:
    """As the trajectory writes it, which tests/planning/test_export.py reads back."""
    status, text, headers = get(viewer.url + "motion.csv")
    assert (status, "no motion to export" in text) == (404, True)
    assert headers["Content-Type"] == "text/plain; charset=utf-8"
    motion = swing(arm)
    viewer.play(motion)
    assert viewer.theta.shape == (3,)  # applied
    for kind in ("csv", "json", "h"):
        status, text, headers = get(viewer.url + f"motion.{kind}")
        assert (status, text) == (200, save_trajectory(motion, tmp_path / f"motion.{kind}").read_text())
        assert headers["Content-Disposition"] == f'attachment; filename="small_motion.{kind}"'
        assert headers["Cache-Control"] == "no-store"
        assert kind != "csv" or headers["Content-Type"] == "text/csv; charset=utf-8"


def test_a_file_s_name_has_letters_that_a_header_takes(tmp_path: Path) -> None:
    path = tmp_path / "odd.urdf"
    path.write_text(
        '<robot name="a&quot;b/ü c"><link name="b"/><link name="t"/><joint name="j" type="continuous">'
        '<parent link="b"/><child link="t"/></joint></robot>'
    )
    arm = load_arm(path)
    with Viewer(arm, open_browser=False) as viewer:
        headers = get(viewer.url + "arm.html")[2]
    assert headers["Content-Disposition"] == 'attachment; filename="a_b___c.html"'
    assert headers["Content-Type"] == "text/html; charset=utf-8"
