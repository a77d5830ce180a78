"""What the live view hands on: a saved page and its kinematics by matrix exponentials, and the motion as a file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.linalg import expm

from twistarm import Arm, Trajectory, arm_from_screws, joints, load_arm, save_trajectory
from twistarm.planning.joint_space import plan_joint
from twistarm.viewer import Viewer
from twistarm.viewer.parts.arm_data import extra_joints
from twistarm.viewer.scene.drawing import link_path
from twistarm.viewer.scene.kinematics import kinematics
from viewer_page import Page, get, matrix, stored, swing

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


TOL = 1e-9

BRANCHED = """<robot name="branched">
  <link name="root"/><link name="mast"/><link name="base_link"/><link name="upper"/><link name="rod"/>
  <link name="tool0"/><link name="left"/><link name="right"/><link name="bogie"/>
  <joint name="lift" type="prismatic"><parent link="root"/><child link="mast"/><origin xyz="0.1 0 0.2" rpy="0.1 0.2 0"/>
    <axis xyz="0 0 1"/><limit lower="0" upper="0.5" velocity="1" effort="1"/></joint>
  <joint name="turn" type="continuous"><parent link="mast"/><child link="base_link"/>
    <origin xyz="0 0.1 0" rpy="0 0 0.4"/><axis xyz="0 1 0"/></joint>
  <joint name="a" type="revolute"><parent link="base_link"/><child link="upper"/><origin xyz="0 0 0.3" rpy="0 0.7 0"/>
    <axis xyz="0.6 0 0.8"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="b" type="revolute"><parent link="upper"/><child link="rod"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/><mimic joint="a" multiplier="-0.5" offset="0.3"/></joint>
  <joint name="c" type="prismatic"><parent link="rod"/><child link="tool0"/><origin xyz="0.2 0 0"/><axis xyz="1 0 0"/>
    <limit lower="0.1" upper="0.6" velocity="1" effort="1"/></joint>
  <joint name="finger" type="prismatic"><parent link="tool0"/><child link="left"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.04" velocity="1" effort="1"/></joint>
  <joint name="follower" type="prismatic"><parent link="tool0"/><child link="right"/><axis xyz="0 -1 0"/>
    <limit lower="0" upper="0.04" velocity="1" effort="1"/><mimic joint="finger"/></joint>
  <joint name="wheel" type="continuous"><parent link="root"/><child link="bogie"/><origin xyz="0 0 -0.1"/>
    <axis xyz="0 1 0"/></joint>
</robot>"""


def placed(told: Any, coordinates: Any) -> dict[str, NDArray[np.float64]]:
    """Every node at the coordinates: theta, then the joints beside the chain."""
    moved: list[NDArray[np.float64]] = []
    for joint in told["joints"]:
        v, w = np.array(joint["screw"][:3]), np.array(joint["screw"][3:])
        xi = np.zeros((4, 4))
        xi[:3, :3], xi[:3, 3] = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]]), v
        step = expm(xi * sum(factor * coordinates[i] for i, factor in joint["terms"]))
        moved.append(step if joint["parent"] is None else moved[joint["parent"]] @ step)
    moved.append(np.eye(4))
    base = np.linalg.inv(moved[-1 if told["base"] is None else told["base"]])
    return {
        path: base @ moved[-1 if node["joint"] is None else node["joint"]] @ matrix(node["rest"])
        for path, node in told["nodes"].items()
    }


def assert_poses(arm: Arm, *, count: int = 3) -> None:
    rng = np.random.default_rng(5)
    beside = extra_joints(arm)
    told = kinematics(arm, list(beside))
    for _ in range(count):
        theta = arm.random_theta(rng)
        others = {name: float(np.clip(rng.normal(), joint.lower, joint.upper)) for name, joint in beside.items()}
        poses, nodes = arm.poses(theta, others), placed(told, [*theta, *others.values()])
        assert_allclose(nodes["/frames/tool"], poses[arm.tip], atol=TOL)
        for name in () if arm.description is None else arm.description.links:
            assert_allclose(nodes[link_path(name)], poses[name], atol=TOL, err_msg=name)


def test_of_every_arm_of_the_catalogue(catalogue_arm: Arm) -> None:
    assert_poses(catalogue_arm)


@pytest.mark.parametrize("locked", [{}, {"b": 0.4}])
def test_a_base_that_is_carried_followers_and_joints_beside_the_chain(tmp_path: Path, locked: Any) -> None:
    path = tmp_path / "branched.urdf"
    path.write_text(BRANCHED)
    for base in ("root", "base_link"):
        arm = load_arm(path, base=base, tip="tool0", locked_joints=locked)
        assert_poses(arm)
    assert {"lift", "turn", "finger", "wheel"} == set(extra_joints(arm))


def test_an_arm_of_screws_with_a_thread_and_a_ball() -> None:
    parts = [joints.helical([0, 0, 1], [0.1, 0, 0], 0.05), joints.spherical([0.3, 0, 0.1]), joints.prismatic([1, 0, 0])]
    home = np.eye(4)
    home[:3, 3] = 0.6, 0.1, 0.2
    arm = arm_from_screws(np.column_stack(parts), home)
    told = kinematics(arm, [])
    theta = np.linspace(-0.7, 0.9, arm.n)
    nodes = placed(told, theta)
    assert_allclose(nodes["/frames/tool"], arm.fk(theta), atol=TOL)
    assert set(nodes) == {"/frames/tool", *(f"/{kind}:{i}" for i in range(5) for kind in ("screws/screw", "arm/rod"))}
