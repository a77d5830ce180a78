"""What the live view hands on: a stand-alone page of all that is on show, and the motion as a file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.testing import assert_allclose

from test_viewer_kinematics import placed
from twistarm import Arm, Trajectory, load_arm, save_trajectory
from twistarm.planning.joint_space import plan_joint
from twistarm.viewer import Viewer
from viewer_page import THETA, Page, get, stored, swing

ROUNDED = 1e-8
"""Of joint values with nine decimals."""


def downloaded(viewer: Viewer) -> Any:
    status, text, _ = get(viewer.url + "arm.html")
    assert status == 200
    return stored(text)


def assert_stands(arm: Arm, data: Any, told: Any, theta: Any) -> None:
    """What is told of theta has every link, and the tool, where arm.poses has them."""
    assert_allclose(told, theta, atol=ROUNDED)
    nodes, poses = placed(data["kinematics"], [*told, *data["others"].values()]), arm.poses(theta, data["others"])
    for name, path in {**data["links"], arm.tip: "/frames/tool"}.items():
        assert_allclose(nodes[path], poses[name], atol=ROUNDED, err_msg=name)


def load_paused(viewer: Viewer, motion: Trajectory, time: float) -> None:
    viewer.play(motion, speed=0.5, loop=True)
    with Page(viewer) as page:
        page.ask(type="seek", time=time)


def test_the_page_has_every_joint_and_layer_as_it_stands(arm: Arm, viewer: Viewer) -> None:
    with Page(viewer) as page:
        page.ask(type="joint", name="finger", value=0.03)
    viewer.show_frames(False)
    data = downloaded(viewer)
    assert data["others"] == {"finger": 0.03}
    assert data["visible"]["frames"] is False
    assert data["visible"]["screws"] is True
    assert data["samples"]["times"] == [0.0]
    assert_stands(arm, data, data["samples"]["theta"][0], THETA)
    assert data["player"] is data["aside"] is None


def test_the_page_has_the_motion_and_the_moment_and_pace_of_it(arm: Arm, viewer: Viewer) -> None:
    motion = swing(arm)
    load_paused(viewer, motion, 0.25)
    data = downloaded(viewer)
    assert data["player"] == {"time": 0.25, "running": False, "speed": 0.5, "loop": True}
    assert data["aside"] is None
    samples = data["samples"]
    assert samples["times"][0] == 0.0
    assert samples["times"][-1] == motion.duration
    assert np.diff(samples["times"]).max() < 1 / 29
    for k in (0, 7, len(samples["times"]) // 2, -1):
        assert_stands(arm, data, samples["theta"][k], motion(samples["times"][k]))


def test_the_page_has_the_poses_of_the_arm_and_those_recorded(arm: Arm, viewer: Viewer) -> None:
    with Page(viewer) as page:
        for name in ("mine", "zero"):
            page.ask(type="record", name=name)
    poses = downloaded(viewer)["poses"]
    assert list(poses) == ["zero", "ready", "mine", "zero (recorded)"]
    assert poses["zero"] == [0.0, 0.0, 0.0]
    assert poses["mine"] == poses["zero (recorded)"] == list(THETA)


def test_a_motion_that_runs_goes_on_from_where_it_is(arm: Arm, viewer: Viewer) -> None:
    viewer.play(swing(arm), loop=True)
    data = downloaded(viewer)
    assert data["player"]["running"] is True
    assert data["aside"] is None


def test_save_html_writes_the_same_and_a_motion_of_its_own_if_given(arm: Arm, viewer: Viewer, tmp_path: Path) -> None:
    load_paused(viewer, swing(arm), 0.25)
    assert stored(viewer.save_html(tmp_path / "a.html").read_text()) == downloaded(viewer)
    other = Trajectory(
        arm.joint_names, arm.units, [[0, 0, 0], [0.5, 0, 0]], [0, 1], [0, 1], np.array([[[0.5, 0, 0]], [[0, 0, 0]]])
    )
    data = stored(viewer.save_html(tmp_path / "a.html", other).read_text())
    assert data["player"] == {"time": 0.0, "running": True, "speed": 1.0, "loop": False}
    assert_allclose(np.array(data["samples"]["theta"])[:, 0], 0.5 * np.array(data["samples"]["times"]), atol=ROUNDED)
    way = arm.fk(np.array(data["samples"]["theta"]))[:, :3, 3]
    drawn = np.array(data["path"]["points"])
    assert_allclose(np.linalg.norm(drawn[:, None] - way, axis=-1).min(axis=1), 0.0, atol=0.01)


def test_the_download_is_named_after_the_arm(viewer: Viewer) -> None:
    _, _, headers = get(viewer.url + "arm.html")
    assert headers["Content-Disposition"] == 'attachment; filename="small.html"'
    assert headers["Content-Type"] == "text/html; charset=utf-8"


def test_the_motion_on_show_is_downloaded(arm: Arm, viewer: Viewer, tmp_path: Path) -> None:
    """As the trajectory writes it, which tests/planning/test_export.py reads back."""
    status, text, headers = get(viewer.url + "motion.csv")
    assert (status, text) == (404, "nothing to export: no trajectory is loaded\n")
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


def test_a_download_needs_the_token_and_a_host_of_ours(viewer: Viewer) -> None:
    token = viewer.url.split("/")[3]
    assert get(viewer.url.replace(token, "guess") + "motion.csv")[0] == 403
    assert get(viewer.url + "motion.csv", Host="evil.example")[0] == 403
    assert get(viewer.url + "motion.csv", Origin="http://evil.example")[0] == 403
    assert get(viewer.url + "motion.txt")[0] == 404


def test_a_file_s_name_has_letters_that_a_header_takes(tmp_path: Path) -> None:
    path = tmp_path / "odd.urdf"
    path.write_text(
        '<robot name="a&quot;b/ü c"><link name="b"/><link name="t"/><joint name="j" type="continuous">'
        '<parent link="b"/><child link="t"/></joint></robot>'
    )
    arm = load_arm(path)
    with Viewer(arm, open_browser=False) as viewer:
        viewer.play(plan_joint(arm, [[0.0], [1.0]], limits={"velocity": 1.0, "acceleration": 1.0}))
        assert viewer.theta.shape == (1,)
        headers = get(viewer.url + "motion.csv")[2]
    assert headers["Content-Disposition"] == 'attachment; filename="a_b___c_motion.csv"'
