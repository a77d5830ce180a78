"""What the pages are told: one source that fails leaves the others alone, and nothing that changed is lost."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import pytest

from twistarm import Arm
from twistarm.support.errors import InputError
from twistarm.viewer import Viewer
from twistarm.viewer.protocol.messages import ChangePublisher
from twistarm.viewer.stage import Stage
from viewer_page import Page, swing


def read(texts: dict[str, str]) -> dict[str, Any]:
    return {kind: json.loads(text) for kind, text in texts.items()}


class Source:
    """Says its count, or fails."""

    def __init__(self, kind: str) -> None:
        self.kind, self.count, self.failure = kind, 0, ""

    def __call__(self) -> Iterator[dict[str, Any]]:
        if self.failure:
            raise InputError(self.failure)
        yield {"type": self.kind, "count": self.count}


def test_a_source_that_fails_is_reported_once_and_stops_no_other() -> None:
    news, bad, good = ChangePublisher(), Source("bad"), Source("good")
    assert set(news.gather([bad, good])) == {"bad", "good"}
    bad.failure, good.count = "out of numbers", 1
    told = read(news.gather([bad, good]))
    assert told == {"error": {"type": "error", "message": "out of numbers"}, "good": {"type": "good", "count": 1}}
    good.count = 2
    assert set(news.gather([bad, good])) == {"good"}
    late = read(news.everything())
    assert (late["bad"]["count"], late["good"]["count"], late["error"]["message"]) == (0, 2, "out of numbers")
    bad.failure, bad.count = "", 3
    assert set(news.gather([bad, good])) == {"bad"}
    assert "error" not in news.everything()
    bad.failure = "out of numbers again"
    assert read(news.gather([bad, good]))["error"]["message"] == "out of numbers again"


def test_what_is_no_json_is_a_failure_of_its_source_and_leaves_what_was_shown() -> None:
    news, bad = ChangePublisher(), Source("bad")
    news.gather([bad])
    bad.count = float("nan")  # type: ignore[assignment]
    assert set(news.gather([bad, Source("good")])) == {"error", "good"}
    assert read(news.everything())["bad"]["count"] == 0


def test_what_says_the_same_is_not_told_again_and_a_late_page_gets_the_latest() -> None:
    news, one, two = ChangePublisher(), Source("one"), Source("two")
    assert set(news.gather([one, two])) == {"one", "two"}
    assert news.gather([one, two]) == {}
    one.count = 1
    assert read(news.gather([one, two])) == {"one": {"type": "one", "count": 1}}
    news.everything().clear()  # the caller's own
    assert {kind: message["count"] for kind, message in read(news.everything()).items()} == {"one": 1, "two": 0}


def test_a_part_that_fails_stops_neither_frames_nor_newcomers(viewer: Viewer, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(stage: Stage) -> None:
        raise InputError("the plots are lost")

    with Page(viewer) as page:
        monkeypatch.setattr(viewer._server.stage.parts[-1], "messages", fail)
        page.ask(type="joint", name="pitch", value=0.25)
        page.until(lambda: page.latest["frame"]["theta"][1] == 0.25 and "error" in page.latest)
        assert page.latest["error"]["message"] == "the plots are lost"
        newcomer = page.other()
        newcomer.until(lambda: "error" in newcomer.latest)
        assert newcomer.latest["frame"]["theta"][1] == 0.25
        newcomer.close()


def test_a_newcomer_takes_nothing_from_those_who_are_there(viewer: Viewer) -> None:
    with Page(viewer) as page:
        viewer._server.ask(lambda stage: stage.set_visible("frames", False))  # and nobody is told as yet
        newcomer = page.other()
        assert newcomer.latest["visible"]["frames"] == [False, 1]
        page.until(lambda: not page.latest["visible"]["frames"][0])
        newcomer.close()


def test_what_a_page_needs_is_made_while_one_page_needs_it(viewer: Viewer) -> None:
    with Page(viewer) as page:
        other = page.other()
        for each in (page, other):
            each.ask(type="needs", theory=True, collision=False, reach=False)
        other.until(lambda: "theory" in other.latest)
        other.close()
        other.until_closed()
        assert viewer._server.ask(lambda stage: stage.needed) == {"theory"}
        page.ask(type="needs", theory=False, collision=False, reach=False)
        assert viewer._server.ask(lambda stage: stage.needed) == set()
        page.ask(type="needs", theory=True, collision=False, reach=False)
        page.close()
        page.until_closed()
    assert viewer._server.ask(lambda stage: stage.needed) == set()


def test_a_speed_that_python_set_is_kept_when_a_page_loops(arm: Arm, viewer: Viewer) -> None:
    viewer.play(swing(arm), speed=50.0)
    with Page(viewer) as page:
        page.until(lambda: page.latest["player"]["speed"] == 50.0)
        page.ask(type="pace", speed=50.0, loop=True)
        page.until(lambda: page.latest["player"]["loop"])
        page.ask(type="pace", speed=49.0, loop=False)
        assert "speed must be 0.05 … 20 times" in page.latest["error"]["message"]
        assert (page.latest["player"]["speed"], page.latest["player"]["loop"]) == (50.0, True)
