"""The process of a saved page: it answers as Python does, servo included, and what it cannot do is out of reach."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from arms import load
from twistarm import plan_joint
from twistarm.viewer import Viewer
from viewer_page import Page, stored
from waiting import settled, until

pytestmark = pytest.mark.browser

START = """async ({ motion, hello, note, objects, digest, ...said }) => {
  const [{ Process }, { Core, loaded }] = await Promise.all(["process", "core"].map((name) => import(`./${name}.js`)));
  globalThis.told = {};
  const message = (said) => { told[said.type] = said; };
  const on = { message, object() {}, status() {}, idle: () => done?.() };
  globalThis.done = null;
  const saved = { motion, hello, note, objects, digest, messages: Object.values(said) };
  globalThis.process = new Process(saved, new Core(await loaded(), hello), on);
  await process.begin();
}"""
"""A process of its own on a live page, from what a saved page holds; `told` has what it tells."""

ASK = """async (request) => {
  delete told.error;
  await new Promise((idle) => { done = idle; process.send(request); });
  return told;
}"""

SAME = ("frame", "player", "program", "history", "tolerances", "target", "solution")

LIST = {
    "joints": ["wrist_roll", "wrist_pitch", "elbow", "shoulder", "slide"],
    "poses": [{"name": "x", "theta": [5, 0.4, 0.3, 0.2, 0.1]}],
}
GIVEN = {"kind": "position", "position": [0.8, 0.0, 0.4], "xyzw": [0, 0, 0, 1], "converged": False, "words": "far"}

REQUESTS: list[dict[str, Any]] = [
    {"type": "joint", "name": "elbow", "value": 0.5},
    {"type": "joint", "name": "finger_left", "value": 0.02},
    {"type": "joint", "name": "elbow", "value": 9.0},
    {"type": "record", "name": "  a  b "},
    {"type": "theta", "theta": [0.1, 0.2, 0.3, 0.4, 0.5]},
    {"type": "theta", "theta": [0.1, 0.2]},
    {"type": "theta", "theta": [9.0, 0.2, 0.3, 0.4, 0.5]},
    {"type": "record", "name": "a b"},
    {"type": "record", "name": ""},
    {"type": "rename", "id": 2, "name": "c"},
    {"type": "rename", "id": 2, "name": "c"},
    {"type": "reorder", "id": 1, "place": 9},
    {"type": "move", "id": 3, "by": "line"},
    {"type": "delete", "id": 2},
    {"type": "delete", "id": 2},
    {"type": "undo"},
    {"type": "undo"},
    {"type": "redo"},
    {"type": "go", "id": 1, "ease": False},
    {"type": "go", "id": 7, "ease": False},
    {"type": "poses", **LIST},
    {"type": "poses", **LIST, "joints": ["elbow"]},
    {"type": "poses", **LIST, "poses": [{**LIST["poses"][0], "by": "linear"}]},
    {"type": "pose", "name": "zero", "ease": False},
    {"type": "pose", "name": "nowhere", "ease": False},
    {"type": "target", **GIVEN, "ghost": [], "theta": [0.1, 0.2, 0.3, 0.4, 0.5]},
    {"type": "target", **GIVEN, "ghost": [], "theta": [0.1, 0.2, 0.3, 0.4, 0.5], "xyzw": [0, 0, 0, 2]},
    {"type": "release"},
    {"type": "tolerances", "position": 1e-3, "orientation": 0.0},
    {"type": "tolerances", "position": -1.0, "orientation": 0.0},
    {"type": "seek", "time": 0.4},
    {"type": "seek", "time": 99.0},
    {"type": "pace", "speed": 2.0, "loop": True},
    {"type": "pace", "speed": 99.0, "loop": True},
    {"type": "pause"},
    {"type": "solution", "place": 0, "ease": False},
    {"type": "jog", "twist": [0.0] * 6, "frame": "base"},
]


@pytest.fixture
def desk(page: Any, tmp_path: Path) -> Iterator[tuple[Page, Callable[[dict[str, Any]], Any]]]:
    """Python, and what a saved page's process tells once it was asked; both at the same state, aside of a motion."""
    arm = load("rover_arm")
    with Viewer(arm, open_browser=False) as viewer:
        settled(page, viewer.url)
        viewer.play(plan_joint(arm, [arm.ready, 0.8 * arm.ready], limits={"velocity": 0.5, "acceleration": 1.0}))
        viewer.show(0.9 * arm.ready)  # aside of its motion
        page.evaluate(START, stored(viewer.save_html(tmp_path / "page.html").read_text("utf-8")))
        with Page(viewer) as python:
            yield python, lambda request: page.evaluate(ASK, request)


@pytest.mark.smoke
def test_it_answers_as_python_does(desk: Any) -> None:
    python, ask = desk
    for request in REQUESTS:
        if request["type"] == "target":
            request = {**request, "stage": python.latest["hello"]["number"]}
        python.ask(**request)
        told = ask(request)
        assert ("error" in told) == ("error" in python.latest), request
        for kind in SAME:
            ours, theirs = told[kind], dict(python.latest[kind])
            for numbers, near in (("theta", 1e-7), ("rates", 1e-3)):
                one, other = ours.pop(numbers, None), theirs.pop(numbers, None)
                assert (one is None) == (other is None), request
                assert_allclose(one or [], other or [], atol=near, err_msg=str(request))
            assert ours == theirs, request


def test_it_finds_the_same_configurations(desk: Any) -> None:
    python, ask = desk
    for kind in ("approach", "position"):
        asked = {"type": "solutions", "kind": kind, "position": [0.8, 0.1, 0.4], "xyzw": [0, 0.6, 0, 0.8]}
        python.ask(**asked)
        python.until(lambda: python.latest["solutions"]["requested"])
        ours, theirs = ask(asked)["solutions"], python.latest["solutions"]
        count = sum(not place["beyond"] for place in theirs["places"])
        assert count == sum(not place["beyond"] for place in ours["places"]) > 0
        for one, other in ((ours, theirs), (theirs, ours)):
            apart = np.abs(np.subtract(np.array(one["theta"])[:, None], np.array(other["theta"])))
            assert apart.max(axis=-1).min(axis=1).max() < 1e-6
        for page in (lambda **request: ask(request), python.ask):
            page(type="solution", place=count - 1, ease=False)
            page(type="solutions_end")


def test_its_servo_moves_the_tool_while_it_is_told_to(desk: Any, page: Any) -> None:
    _, ask = desk
    assert "error" in ask({"type": "jog", "twist": [0.0] * 6, "frame": "base"})
    begun = ask({"type": "servo", "on": True})
    assert begun["drive"]["on"]
    assert begun["servo"]["jog"]
    arm, theta = load("rover_arm"), [begun["frame"]["theta"]]
    for _ in range(12):
        theta.append(ask({"type": "jog", "twist": [0, 0, 0.1, 0, 0, 0], "frame": "base"})["frame"]["theta"])
        time.sleep(0.04)
    way = arm.fk(theta[-1])[:3, 3] - arm.fk(theta[0])[:3, 3]
    assert way[2] > 0.01
    assert_allclose(way[:2], 0.0, atol=1e-3)
    assert "error" in ask({"type": "pose", "name": "zero", "ease": False})
    until(page, "told.servo.status === 'STALE'")
    ask({"type": "servo", "on": False})
    until(page, "!told.servo.driven && !told.drive.on")
    assert "error" not in ask({"type": "pose", "name": "zero", "ease": False})
