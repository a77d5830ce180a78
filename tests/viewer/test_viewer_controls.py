"""A program's own controls and drawings: what pages are told, what the program is called with, what is refused."""

from __future__ import annotations

import base64
from pathlib import Path

import numpy as np
import pytest
import umsgpack

from twistarm import InputError, Viewer
from viewer_page import Page, stored, until


def entries(page: Page) -> dict[str, dict]:
    return {each["name"]: each for each in page.latest.get("controls", {"controls": []})["controls"]}


def test_pages_and_program_share_a_slider_and_call_in_order(viewer: Viewer) -> None:
    called: list[object] = []
    weight = viewer.slider("weight", -1.0, 3.0, called.append, value=0.5)
    viewer.button("again", lambda: called.append((weight.value, viewer.theta.shape)))  # it may ask the view
    with Page(viewer) as page, page.other() as other:
        page.until(lambda: len(entries(page)) == 2)
        assert entries(page)["weight"] == {"name": "weight", "value": 0.5, "ends": [-1.0, 3.0], "error": ""}
        page.ask(type="slide", name="weight", value=2.5)
        for _ in range(2):
            page.ask(type="press", name="again")
        until(lambda: len(called) == 3)
        assert called == [2.5, (2.5, (3,)), (2.5, (3,))]
        other.until(lambda: entries(other).get("weight", {}).get("value") == 2.5)
        weight.value = -1.0
        for each in (page, other):
            each.until(lambda each=each: entries(each)["weight"]["value"] == -1.0)
        page.ask(type="slide", name="weight", value=3.5)
        assert "weight" in page.latest["error"]["message"]
        page.ask(type="slide", name="again", value=1.0)
        assert "again is not a slider" in page.latest["error"]["message"]
        page.ask(type="press", name="agian")
        assert "closest: 'again'" in page.latest["error"]["message"]
    assert weight.value == -1.0
    assert len(called) == 3


def test_an_error_of_the_program_is_one_line_and_the_next_call_comes(viewer: Viewer, caplog) -> None:
    text = viewer.text("answer", "none")

    def divide(value: float) -> None:
        text.value = f"{1.0 / value:g}"

    slider = viewer.slider("divisor", 0.0, 4.0, divide, 1.0)
    with Page(viewer) as page:
        page.until(lambda: len(entries(page)) == 2)
        page.ask(type="slide", name="divisor", value=0.0)
        page.until(lambda: entries(page)["divisor"]["error"] != "")
        assert entries(page)["divisor"]["error"].startswith("ZeroDivisionError: float division by zero (test_viewer")
        page.ask(type="slide", name="divisor", value=4.0)
        page.until(lambda: entries(page)["answer"]["value"] == "0.25")
        page.until(lambda: entries(page)["divisor"]["error"] == "")
        slider.remove()
        page.until(lambda: list(entries(page)) == ["answer"])
        slider.value = 2.0
        text.value = "gone"
        page.until(lambda: entries(page).get("answer", {}).get("value") == "gone")
        assert list(entries(page)) == ["answer"]
    (line,) = caplog.messages
    assert line.startswith("divisor: ZeroDivisionError")


def test_a_button_may_close_the_view(viewer: Viewer) -> None:
    viewer.button("quit", viewer.close)
    page = Page(viewer)
    page.send('{"type": "press", "name": "quit"}')
    page.until_closed()
    with pytest.raises(InputError, match="closed"):
        viewer.text("late", "")
    with pytest.raises(InputError, match="closed"):
        viewer.draw.text("late", "", [0, 0, 0])


def placed(message: dict) -> list[dict]:
    return [umsgpack.unpackb(base64.b64decode(each)) for each in message["objects"]]


def test_a_drawing_replaces_the_one_of_its_name_and_is_saved(viewer: Viewer, tmp_path: Path) -> None:
    g = np.eye(4)
    g[:3, 3] = 0.1, 0.2, 0.3
    with Page(viewer) as page:
        viewer.draw.box("a/b", [0.1, 0.2, 0.3])
        page.until(lambda: "drawn" in page.latest)
        viewer.draw.box("a/b", [0.4, 0.2, 0.3], g)
        page.until(lambda: placed(page.latest["drawn"])[0]["object"]["object"]["matrix"][12:15] == [0.1, 0.2, 0.3])
    line = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 0], [1, 2, 0]], dtype=float)
    viewer.draw.line("line", line, radius=0.01)
    viewer.draw.mesh("mesh", [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    viewer.draw.text("words", "here", [1, 2, 3])
    viewer.draw.arrow("none", [1, 1, 1], [1, 1, 1])
    viewer.draw.remove("a/b")
    viewer.slider("weight", 0, 1)
    data = stored(viewer.save_html(tmp_path / "page.html").read_text("utf-8"))
    drawn = {each["node"].partition(":")[2]: each for kind, each in data.items() if kind.startswith("drawn")}
    assert drawn["a%2Fb"]["objects"] == drawn["none"]["objects"] == []
    assert drawn["words"]["text"] == {"words": "here", "at": [1, 2, 3]}
    corners, normals = (
        np.frombuffer(
            placed(drawn["line"])[0]["object"]["geometries"][0]["data"]["attributes"][of]["array"].data, "<f4"
        )
        for of in ("position", "normal")
    )
    corners, normals = corners.reshape(-1, 3), normals.reshape(-1, 3)
    assert np.isfinite(corners).all()
    off = [
        np.linalg.norm(corners - np.clip(corners, a, b), axis=1) for a, b in ((line[0], line[1]), (line[1], line[3]))
    ]
    assert np.abs(np.subtract(off, 0.01)).min(axis=0).max() < 1e-6  # of one segment or the other
    assert np.linalg.norm(normals[[0, -1]], axis=1) == pytest.approx([1.0, 1.0])
    flat = placed(drawn["mesh"])[0]["object"]["geometries"][0]["data"]["attributes"]["normal"]["array"].data
    assert np.frombuffer(flat, "<f4").reshape(3, 3) == pytest.approx(np.tile([0, 0, 1], (3, 1)))


def test_controls_and_drawings_stay_with_another_arm(viewer: Viewer, arm, rover) -> None:
    called: list[float] = []
    viewer.slider("weight", 0, 1, called.append)
    viewer.draw.frame("here", np.eye(4))
    viewer.load(rover)
    with Page(viewer) as page:
        page.until(lambda: "weight" in entries(page))
        page.until(lambda: page.latest.get("drawn", {}).get("node") == "/drawn/name:here")
        page.ask(type="slide", name="weight", value=1.0)
    until(lambda: called == [1.0])


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (lambda view: view.slider("a", 1, 1), "lo must be below hi"),
        (lambda view: view.slider("a", 0, 1, value=2), "value of .a. .*got 2"),
        (lambda view: view.slider("a", 0, 1, 7), "on_change must be a function"),
        (lambda view: view.button(7, print), "name must be text"),
        (lambda view: view.draw.box("a", [1, 1, 0]), "size must be positive"),
        (lambda view: view.draw.points("a", [[0, 0, 1e9]]), "at most 1e"),
        (lambda view: view.draw.line("a", [0, 0, 1]), "rows of 3 numbers"),
        (lambda view: view.draw.line("a", [[0, 0, 1]], (255, 0, 0)), "from 0 to 1"),
        (lambda view: view.draw.mesh("a", [[0, 0, 0]], [[0, 0, 1]]), "indices of the 1 vertices"),
        (lambda view: view.draw.text("a", "x" * 2000, [0, 0, 0]), "at most 1000 characters"),
    ],
)
def test_what_cannot_be_shown_is_refused(viewer: Viewer, wrong, says) -> None:
    with pytest.raises(InputError, match=says):
        wrong(viewer)
