"""Another arm in a view that is open: what stays of what was shown, and files that are watched while they change."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from twistarm import Arm, load_arm, plan_joint
from twistarm.description.meshes import read_mesh
from twistarm.support.errors import InputError
from twistarm.viewer import Viewer
from twistarm.viewer.scene import links
from twistarm.viewer.scene.arm_drawing import Drawing
from twistarm.viewer.server.watching import load_with_files
from viewer_page import ARM, THETA, Page, until, visit

XACRO = """<robot name="small" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:include filename="links.xacro"/>
  <joint name="pitch" type="revolute"><parent link="base_link"/><child link="tool0"/><origin xyz="0 0 0.4"/>
    <axis xyz="0 1 0"/><limit lower="-1.5" upper="1.5" velocity="2" effort="5"/></joint>
</robot>"""

LINKS = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <link name="base_link"/>
  <link name="tool0"><visual><geometry><mesh filename="tool.stl"/></geometry></visual></link>
</robot>"""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    file = tmp_path / "small.urdf"
    file.write_text(ARM)
    return file


def changed(path: Path, *pairs: tuple[str, str]) -> Arm:
    """The arm with other words in its file."""
    text = ARM
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)
    return load_arm(path, tip="tool0")


def two_poses(viewer: Viewer) -> None:
    with Page(viewer) as page:
        page.ask(type="record", name="one")
        page.ask(type="joint", name="pitch", value=1.2)
        page.ask(type="record", name="two")
        page.ask(type="joint", name="pitch", value=-0.7)
        page.ask(type="joint", name="finger", value=0.03)
    viewer.show_frames(False)


def test_theta_poses_layers_and_motion_stay_where_the_arm_allows_them(viewer: Viewer, path: Path) -> None:
    two_poses(viewer)
    motion = plan_joint(viewer.arm, [(0, 0, 0), (0.5, 1.0, 0.1)], limits={"velocity": 1.0, "acceleration": 2.0})
    viewer.play(motion)
    viewer.show_path(motion)
    viewer.show(THETA)
    longer = changed(path, ('<origin xyz="0 0 0.4"/>', '<origin xyz="0 0 0.6"/>'))
    assert viewer.load(longer) == ()
    assert viewer.arm is longer
    assert_allclose(viewer.theta, THETA)
    assert list(viewer.recorded) == ["one", "two"]
    page = visit(viewer)
    assert page.latest["frame"]["others"] == {"finger": 0.03}
    assert page.latest["visible"]["frames"] == [False, 1]
    assert page.latest["player"]["duration"] == motion.duration
    assert_allclose(page.latest["path"]["points"][0], longer.fk(np.zeros(3))[:3, 3], atol=1e-6)
    tighter = changed(path, ('upper="1.5"', 'upper="0.4"'), ('lower="-1.5"', 'lower="-0.4"'))
    left = viewer.load(tighter)
    assert [name in words for name, words in zip(("pitch", "2 poses", "motion"), left, strict=True)] == [True] * 3
    assert_allclose(viewer.theta, [THETA[0], -0.4, THETA[2]])
    assert viewer.recorded == {}


def test_joints_that_come_and_go(viewer: Viewer, path: Path) -> None:
    two_poses(viewer)
    fixed = changed(path, ('name="slide" type="prismatic"', 'name="slide" type="fixed"'))
    (left,) = viewer.load(fixed)
    assert "2 poses" in left
    assert_allclose(viewer.theta, THETA[:2])
    viewer.load(changed(path))
    assert_allclose(viewer.theta[:2], THETA[:2])
    assert viewer.recorded == {}


def test_open_pages_are_given_the_arm_and_their_answers(viewer: Viewer, path: Path) -> None:
    other = load_arm("rr_planar")
    with Page(viewer) as page:
        objects = len(page.objects)
        page.latest.clear()
        viewer.load(other)
        page.until(lambda: page.latest.get("hello", {}).get("arm", {}).get("name") == other.name)
        page.until(lambda: len(page.objects) == objects + page.latest.get("scene", {}).get("objects", 0))
        page.until(lambda: "frame" in page.latest)
        assert set(page.latest["hello"]["kinematics"]["nodes"]) >= set(page.latest["hello"]["links"].values())
        assert page.latest["frame"]["theta"] == viewer.theta.tolist()
        page.ask(type="theta", theta=[0.1, 0.2])
        assert_allclose(viewer.theta, [0.1, 0.2])
        page.ask(type="theta", theta=[0.1, 0.2, 0.3])
        assert "error" in page.latest
    with pytest.raises(InputError, match=r"got \(3,\)|3"):
        viewer.show(THETA)


def test_not_under_the_hands_of_a_servo_nor_in_a_view_that_is_closed(viewer: Viewer, path: Path) -> None:
    arm = changed(path)
    assert viewer.commands is not None
    with pytest.raises(InputError, match="a servo drives small"):
        viewer.load(arm)
    viewer.show_servo(None)
    viewer.load(arm)
    viewer.close()
    with pytest.raises(InputError, match="closed"):
        viewer.load(arm)


@pytest.fixture
def source(tmp_path: Path) -> Path:
    (tmp_path / "links.xacro").write_text(LINKS)
    (tmp_path / "tool.stl").write_text("solid a\nendsolid a\n")
    (tmp_path / "arm.toml").write_text('source = "arm.xacro"\ntip = "tool0"\n')
    (tmp_path / "arm.xacro").write_text(XACRO)
    return tmp_path / "arm.toml"


@pytest.fixture
def watched(source: Path) -> Iterator[tuple[Viewer, list[str]]]:
    load, said = partial(load_arm, source), []
    arm, files = load_with_files(load)
    with Viewer(arm, [0.9], open_browser=False) as viewer:
        viewer.watch(load, files, said.append)
        yield viewer, said


def test_every_file_that_was_read_is_known(source: Path) -> None:
    (source.parent / "arm.srdf").write_text('<robot name="small"/>')
    _, files = load_with_files(partial(load_arm, source))
    assert {"arm.toml", "arm.xacro", "links.xacro", "tool.stl", "arm.srdf"} <= {path.name for path in files}


def test_an_include_that_changes_breaks_vanishes_and_is_mended(watched: Any, source: Path) -> None:
    viewer, said = watched
    first, include = viewer.arm, source.parent / "links.xacro"
    include.write_text(LINKS.replace("</robot>", '<link name="more"/></robot>'))  # no joint leads there
    until(lambda: "more" in said[-1:][0] if said else False)
    assert said[0].startswith("not loaded again: ")
    assert viewer.arm is first
    include.unlink()
    until(lambda: "links.xacro" in said[-1])
    new = source.parent / "saved by an editor"
    new.write_text(LINKS)
    os.replace(new, include)
    until(lambda: said[-1] == "loaded again")
    assert viewer.arm is not first
    assert_allclose(viewer.theta, [0.9])
    main = source.parent / "arm.xacro"
    main.write_text(XACRO.replace('upper="1.5"', 'upper="0.5"'))
    until(lambda: said[-1].startswith("loaded again; ") and "pitch" in said[-1])
    assert_allclose(viewer.theta, [0.5])


def test_a_mesh_that_has_not_changed_is_not_read_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import trimesh

    for name in ("one", "two"):
        trimesh.creation.box((0.1, 0.1, 0.1)).export(tmp_path / f"{name}.stl")
    mesh = '<visual><geometry><mesh filename="{}.stl"/></geometry></visual>'
    drawn = LINKS.replace("</robot>", "").replace('mesh filename="tool.stl"', 'mesh filename="one.stl"')
    base = drawn.replace('<link name="base_link"/>', f'<link name="base_link">{mesh.format("two")}</link>') + "</robot>"
    (tmp_path / "links.xacro").write_text(base)
    (tmp_path / "arm.xacro").write_text(XACRO)
    first = Drawing(load_arm(tmp_path / "arm.xacro")).whole()
    read: list[str] = []
    monkeypatch.setattr(links, "read_mesh", lambda path: read.append(path.name) or read_mesh(path))
    (tmp_path / "arm.xacro").write_text(XACRO.replace("0 0 0.4", "0 0 0.5"))
    second = first.successor(load_arm(tmp_path / "arm.xacro"))
    assert second.left == 2
    second.whole()
    assert read == []
    assert len(second.objects) == len(first.objects)
    trimesh.creation.box((0.2, 0.1, 0.1)).export(tmp_path / "two.stl")
    second.successor(load_arm(tmp_path / "arm.xacro")).whole()
    assert read == ["two.stl"]


def test_what_changes_while_a_servo_drives_is_loaded_once_it_has_ended(watched: Any, source: Path) -> None:
    viewer, said = watched
    first = viewer.arm
    assert viewer.commands is not None
    (source.parent / "links.xacro").write_text(LINKS + " ")
    until(lambda: bool(said))
    time.sleep(0.6)
    assert len(said) == 1
    assert viewer.arm is first
    viewer.show_servo(None)
    until(lambda: viewer.arm is not first)
