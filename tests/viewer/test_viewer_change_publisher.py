"""What the pages are told: one source that fails leaves the others alone, and nothing that changed is lost."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from twistarm.support.errors import InputError
from twistarm.viewer import Viewer
from twistarm.viewer.protocol.messages import ChangePublisher
from viewer_page import Page


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


def test_what_says_the_same_is_not_told_again_and_a_late_page_gets_the_latest() -> None:
    news, one, two = ChangePublisher(), Source("one"), Source("two")
    assert set(news.gather([one, two])) == {"one", "two"}
    assert news.gather([one, two]) == {}
    one.count = 1
    assert read(news.gather([one, two])) == {"one": {"type": "one", "count": 1}}
    news.everything().clear()  # the caller's own
    assert {kind: message["count"] for kind, message in read(news.everything()).items()} == {"one": 1, "two": 0}


def test_what_a_page_needs_is_made_while_one_page_needs_it(viewer: Viewer) -> None:
    def needs(page: Page, theory: bool) -> None:
        page.ask(type="needs", theory=theory, collision=False, reach=False)

    def told(page: Page, *values: float) -> bool:
        page.latest.pop("theory", None)
        for value in values:
            page.ask(type="joint", name="pitch", value=value)
        page.until(lambda: page.latest["frame"]["theta"][1] == values[-1])
        return "theory" in page.latest

    with Page(viewer) as page:
        other = page.other()
        for each in (page, other):
            needs(each, True)
        other.until(lambda: "theory" in other.latest)
        other.close()
        other.until_closed()
        assert told(page, 0.1, 0.2)
        needs(page, False)
        assert not told(page, 0.3, 0.4)
