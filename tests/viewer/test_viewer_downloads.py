"""Files that a page can have: the motion on show."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import numpy as np
import yaml
from numpy.testing import assert_array_equal

from recorded_poses import HOME, REACH
from twistarm import Arm, load_arm
from twistarm.planning.joint_space import plan_joint
from twistarm.viewer import Viewer
from viewer_page import get, swing


def test_the_motion_on_show_is_downloaded_and_reads_back(arm: Arm, viewer: Viewer) -> None:
    status, text, headers = get(viewer.url + "motion.csv")
    assert (status, text) == (404, "nothing to export: no trajectory is loaded\n")
    assert headers["Content-Type"] == "text/plain; charset=utf-8"
    motion = swing(arm)
    viewer.play(motion)
    t, *values = motion.sample(0.01)
    assert viewer.theta.shape == (3,)  # applied
    status, text, headers = get(viewer.url + "motion.csv")
    assert status == 200
    assert headers["Content-Disposition"] == 'attachment; filename="small_motion.csv"'
    assert headers["Content-Type"] == "text/csv; charset=utf-8"
    assert headers["Cache-Control"] == "no-store"
    header, *rows = csv.reader(io.StringIO(text))
    assert header[:3] == ["time [s]", "yaw.position [rad]", "yaw.velocity [rad/s]"]
    table = np.array(rows, dtype=float)
    assert_array_equal(table[:, 0], t)
    for order, samples in enumerate(values):
        assert_array_equal(table[:, 1 + order :: 3], samples)
    status, text, headers = get(viewer.url + "motion.json")
    assert headers["Content-Disposition"] == 'attachment; filename="small_motion.json"'
    message = json.loads(text)
    assert message["joint_names"] == list(arm.joint_names)
    assert_array_equal([point["velocities"] for point in message["points"]], values[1])
    status, text, headers = get(viewer.url + "motion.yaml")
    assert headers["Content-Disposition"] == 'attachment; filename="small_motion.yaml"'
    assert yaml.safe_load(text) == message
    status, text, headers = get(viewer.url + "motion.h")
    assert headers["Content-Disposition"] == 'attachment; filename="small_motion.h"'
    assert "static inline void motion_theta(" in text


def test_a_download_needs_the_token_and_a_host_of_ours(viewer: Viewer) -> None:
    token = viewer.url.split("/")[3]
    assert get(viewer.url.replace(token, "guess") + "motion.csv")[0] == 403
    assert get(viewer.url + "motion.csv", Host="evil.example")[0] == 403
    assert get(viewer.url + "motion.csv", Origin="http://evil.example")[0] == 403
    assert get(viewer.url + "motion.txt")[0] == 404


def test_a_very_long_motion_is_exported_more_coarsely(arm: Arm, viewer: Viewer) -> None:
    times = {"times": [0.0, 10_000.0]}
    viewer.play(plan_joint(arm, [HOME, REACH], limits={"velocity": 1.0, "acceleration": 1.0}, **times))
    assert viewer.theta.shape == (3,)
    text = get(viewer.url + "motion.csv")[1]
    assert text.count("\n") == 1 + 20_001
    assert text.rstrip().split("\n")[-1].startswith("10000.0,1.0,")


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
