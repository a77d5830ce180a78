"""Work in threads, of which the latest wins, and what pages are told: nothing that changed is lost or told twice."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from twistarm.support.errors import InputError
from twistarm.viewer import Viewer
from twistarm.viewer.protocol.jobs import Job, Progress, ReplacedError, Workers
from twistarm.viewer.protocol.messages import ChangePublisher
from viewer_page import WAIT, Page, until


class Loop:
    """What the server is to its workers."""

    def __init__(self) -> None:
        self.results: list[Any] = []
        self.errors: list[str] = []
        self.shares: list[tuple[str, float | None]] = []
        self.workers = Workers(self.deliver, lambda key, share: self.shares.append((key, share)))

    def deliver(self, action: Callable[[], None]) -> None:
        try:
            action()
        except Exception as error:
            self.errors.append(str(error))

    def submit(self, key: str, work: Callable[[Progress], Any]) -> None:
        self.workers.submit(Job(key, f"doing {key}", work, self.results.append))


@pytest.fixture
def loop() -> Iterator[Loop]:
    threads = set(threading.enumerate())
    begun = Loop()
    yield begun
    begun.workers.stop(WAIT)
    assert set(threading.enumerate()) <= threads


class Held:
    """Work that waits for leave at each word of progress."""

    def __init__(self, result: str, steps: int = 1000) -> None:
        self.result, self.steps = result, steps
        self.begun, self.leave, self.replaced = threading.Event(), threading.Event(), threading.Event()

    def __call__(self, progress: Progress) -> str:
        self.begun.set()
        assert self.leave.wait(WAIT)
        try:
            for k in range(self.steps):
                progress(k / self.steps)
        except ReplacedError:
            self.replaced.set()
            raise
        return self.result


def test_the_latest_job_wins_and_those_between_are_never_begun(loop: Loop) -> None:
    first = Held("first")
    begun: list[int] = []
    loop.submit("plan", first)
    assert first.begun.wait(WAIT)
    for k in range(50):
        loop.submit("plan", lambda progress, k=k: begun.append(k) or k)  # type: ignore[misc]
    first.leave.set()
    until(lambda: loop.results == [49])
    assert first.replaced.is_set()
    assert begun == [49]
    assert loop.errors == []


def test_what_goes_wrong_is_told_and_the_next_job_is_done(loop: Loop) -> None:
    def fail(progress: Progress) -> None:
        raise InputError("no such place")

    loop.submit("target", fail)
    until(lambda: loop.errors == ["doing target: no such place"])
    loop.submit("target", lambda progress: 1 / 0)
    until(lambda: loop.errors[1:] == ["doing target: division by zero"])
    loop.submit("target", lambda progress: "done")
    until(lambda: loop.results == ["done"])


def test_the_bar_goes_too_when_the_work_fails_or_is_replaced(loop: Loop) -> None:
    def fail(progress: Progress) -> None:
        progress(0.5)
        raise InputError("there is no way")

    def wait_for_a_later_one(progress: Progress) -> None:
        progress(0.25)
        loop.submit("target", lambda progress: "later")
        progress(0.75)

    loop.submit("plan", fail)
    until(lambda: len(loop.shares) == 2)
    assert loop.errors == ["doing plan: there is no way"]
    loop.submit("target", wait_for_a_later_one)
    until(lambda: loop.results == ["later"])
    assert loop.shares == [("plan", 0.5), ("plan", None), ("target", 0.25), ("target", None)]


def test_stopping_interrupts_at_the_next_progress(loop: Loop) -> None:
    working, waiting = Held("working"), Held("waiting")
    loop.submit("plan", working)
    assert working.begun.wait(WAIT)
    loop.submit("plan", waiting)
    stopper = threading.Thread(target=loop.workers.stop, args=(WAIT,))
    stopper.start()
    working.leave.set()
    stopper.join(WAIT)
    assert not stopper.is_alive()
    assert working.replaced.is_set()
    assert not waiting.begun.is_set()
    assert loop.results == loop.errors == []


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
