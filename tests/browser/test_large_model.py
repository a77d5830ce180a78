"""A model whose meshes take their time: what the page shows meanwhile, that it answers, and that it ends complete."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import trimesh
from numpy.testing import assert_allclose

import schema_samples as samples
from twistarm import load_arm
from twistarm.description.meshes import Mesh, read_mesh
from twistarm.viewer import Viewer
from twistarm.viewer.messages import LARGEST_VALUE, SCHEMA
from twistarm.viewer.scene import links
from waiting import WAIT, settled, until

pytestmark = pytest.mark.browser

MESHES = 4

STATUS = "document.getElementById('status').textContent"
DRAWN = "twistarm.parts.progress.drawn"


class Gate:
    """Lets one mesh be read for each time it is opened."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.leave = threading.Semaphore(0)

        def wait_and_read(path: Path) -> Mesh:
            assert self.leave.acquire(timeout=WAIT)
            return read_mesh(path)

        monkeypatch.setattr(links, "read_mesh", wait_and_read)

    def open(self, times: int) -> None:
        for _ in range(times):
            self.leave.release()


@pytest.fixture
def gate(monkeypatch: pytest.MonkeyPatch) -> Iterator[Gate]:
    made = Gate(monkeypatch)
    yield made
    made.open(MESHES)


@pytest.fixture
def viewer(gate: Gate, tmp_path: Path) -> Iterator[Viewer]:
    """Three links of one, two and one meshes, the last of which cannot be read."""
    for i in range(MESHES - 1):
        trimesh.creation.icosphere(3, 0.1).export(tmp_path / f"{i}.stl")
    (tmp_path / "3.stl").write_text("no mesh")
    visual = '<visual><geometry><mesh filename="{}.stl"/></geometry></visual>'
    joint = (
        '<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/><origin xyz="0 0 0.3"/>'
        '<axis xyz="0 1 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
    )
    parts = [
        f'<link name="base">{visual.format(0)}</link>',
        f'<link name="upper">{visual.format(1)}{visual.format(2)}</link>',
        f'<link name="fore">{visual.format(3)}</link><link name="tip"/>',
        joint.format("shoulder", "base", "upper") + joint.format("elbow", "upper", "fore"),
        joint.format("wrist", "fore", "tip"),
    ]
    (tmp_path / "arm.urdf").write_text(f'<robot name="slow">{"".join(parts)}</robot>')
    with Viewer(load_arm(tmp_path / "arm.urdf"), [0.1, 0.2, 0.3], open_browser=False) as served:
        yield served
        gate.open(MESHES)


@pytest.mark.smoke
def test_a_slow_model_shows_its_progress_and_ends_complete(
    page: Any, open_page: Any, viewer: Viewer, gate: Gate
) -> None:
    page.goto(viewer.url)
    until(page, "globalThis.twistarm?.state.frame")
    plain = viewer._server.drawing.plain
    until(page, f"{DRAWN} === {plain}")
    bar = page.get_by_role("progressbar", name="Progress of the drawing")
    assert bar.is_visible()
    assert page.locator("#status").inner_text() == f"{plain} / {plain + MESHES}"
    assert (bar.get_attribute("aria-valuenow"), bar.get_attribute("aria-valuemax")) == (str(plain), str(plain + MESHES))
    gate.open(1)
    until(page, f"{STATUS} === '{plain + 2} / {plain + MESHES + 1}'")  # with the end of what stood in
    page.locator('input[data-joint="shoulder"]').press("End")
    until(page, "twistarm.state.frame.theta[0] === 1")
    assert_allclose(viewer.theta, [1, 0.2, 0.3])
    assert page.evaluate("twistarm.state.fitted") is False
    gate.open(MESHES)
    until(page, "twistarm.state.fitted")
    assert page.locator("#status").inner_text() == "live"
    assert bar.is_hidden()
    assert page.evaluate(DRAWN) == len(viewer._server.drawing.objects)
    assert "cannot read mesh" in page.locator("#notes").inner_text()
    fore = viewer._server.drawing.links["fore"]
    assert page.evaluate(f"twistarm.view.node('{fore}/stand-in/stick0').children.length") > 0
    with open_page() as late:
        settled(late, viewer.url)
        assert late.evaluate(DRAWN) == page.evaluate(DRAWN)


def test_a_page_whose_socket_breaks_comes_back_by_itself(page: Any, viewer: Viewer, gate: Gate) -> None:
    gate.open(MESHES)
    settled(page, viewer.url)
    first = page.evaluate("globalThis.before = twistarm.state.hello, twistarm.state.frame.theta")
    viewer._server.ask(lambda stage: [client.close() for client in list(viewer._server.clients)])
    until(page, f"{STATUS} === 'offline'")
    viewer.show([0.5, 0, 0])
    until(page, f"{STATUS} === 'live' && twistarm.state.hello !== globalThis.before")
    until(page, "twistarm.state.frame?.theta[0] === 0.5")
    assert first == [0.1, 0.2, 0.3]
    assert page.evaluate(DRAWN) == len(viewer._server.drawing.objects)


def test_page_and_process_read_the_schema_alike(page: Any, viewer: Viewer, gate: Gate) -> None:
    gate.open(MESHES)
    settled(page, viewer.url)
    good = [samples.request(kind) for kind in SCHEMA["requests"]]
    spoilt = [{**request, "more": 1} for request in good]
    for request in good:
        for field, word in SCHEMA["requests"][request["type"]].items():
            spoilt.append({name: value for name, value in request.items() if name != field})
            spoilt += [{**request, field: value} for value in samples.bad(word) if told_alike(value)]
    violations = page.evaluate(
        """async (requests) => {
          const { violation } = await import("./schema.js");
          const schema = await (await fetch("schema.json")).json();
          return requests.map((request) => violation(schema.requests, request));
        }""",
        [*good, *spoilt],
    )
    assert violations[: len(good)] == [""] * len(good)
    assert [spoilt[k] for k, violation in enumerate(violations[len(good) :]) if not violation] == []


def told_alike(value: Any) -> bool:
    """Whether JSON has it, and the process does not refuse it for its size alone, which the page leaves to it."""
    try:
        json.dumps(value, allow_nan=False).encode()
    except ValueError:
        return False
    values = value if isinstance(value, list) else [value]
    return not any(type(each) in (int, float) and abs(each) >= LARGEST_VALUE for each in values)
