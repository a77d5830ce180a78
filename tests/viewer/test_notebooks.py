"""The view in a notebook: what its frames hold, and who may frame the live page."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest

from twistarm import Arm, Viewer, arm_from_screws, joints
from twistarm.support.errors import InputError
from twistarm.viewer import Inline, page_html
from viewer_page import THETA, get, stored, swing


class Frames(HTMLParser):
    """The attributes of each iframe, unescaped; nothing else may stand in what a notebook is given."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.found: list[dict[str, str | None]] = []
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag == "iframe"
        self.found.append(dict(attrs))

    def handle_data(self, data: str) -> None:
        pytest.fail(f"text beside the frame: {data[:80]}")


def frame(shown: Any) -> dict[str, str]:
    (only,) = Frames(shown._repr_html_()).found
    return {name: value or "" for name, value in only.items()}


def test_a_viewer_as_the_last_line_of_a_cell_is_its_live_page(viewer: Viewer) -> None:
    assert frame(viewer) == frame(viewer.inline())
    shown = frame(viewer.inline(height=300))
    assert shown["src"] == viewer.url
    assert shown["height"] == "300"
    assert shown["title"] == "small · twistarm"
    assert {word.strip() for word in shown["allow"].split(";")} == {"clipboard-write", "gamepad", "fullscreen"}


def test_a_static_frame_holds_the_page_of_what_is_on_show_and_is_shut_in(viewer: Viewer) -> None:
    shown = frame(viewer.inline(static=True))
    assert set(shown["sandbox"].split()) == {"allow-scripts", "allow-downloads"}
    assert viewer.url.split("/")[3] not in shown["srcdoc"], "the token is not handed on"
    assert stored(shown["srcdoc"])["samples"]["theta"] == [list(THETA)]


def test_a_page_of_an_arm_without_a_viewer(arm: Arm) -> None:
    motion = swing(arm)
    shown = frame(Inline.page(page_html(arm, trajectory=motion), arm.name))
    assert stored(shown["srcdoc"])["samples"]["times"][-1] == motion.duration


@pytest.mark.parametrize("static", [False, True])
def test_no_name_breaks_out_of_the_frame(static: bool) -> None:
    nasty = '"></iframe><script>hacked()</script>'
    other = arm_from_screws(joints.revolute([0, 0, 1], [0, 0, 0]), np.eye(4), joints=[nasty], name=nasty)
    with Viewer(other, open_browser=False) as view:
        assert frame(view.inline(static=static))["title"] == f"{nasty} · twistarm"


@pytest.mark.parametrize("height", [0, -5, float("nan"), "tall"])
def test_a_bad_height_is_refused(viewer: Viewer, height: Any) -> None:
    with pytest.raises(InputError, match="height must be a positive number; got"):
        viewer.inline(height=height)


def test_only_pages_of_this_machine_may_frame_the_live_page(viewer: Viewer) -> None:
    _, _, headers = get(viewer.url)
    (ancestors,) = re.findall(r"frame-ancestors ([^;]*)", headers["Content-Security-Policy"])
    assert ancestors.split() == ["http://localhost:*", "http://127.0.0.1:*"]
