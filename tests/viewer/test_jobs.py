"""Work in threads, of which the latest wins, and what pages are told: nothing that changed is lost or told twice."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from twistarm.support.errors import InputError
from twistarm.viewer import Viewer
from twistarm.viewer.jobs import Job, Progress, ReplacedError, Workers
from twistarm.viewer.messages import ChangePublisher
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
    """Work that waits for leave before its next word of progress."""

    def __init__(self) -> None:
        self.begun, self.leave, self.replaced = threading.Event(), threading.Event(), threading.Event()

    def __call__(self, progress: Progress) -> str:
        progress(0.0)
        self.begun.set()
        assert self.leave.wait(WAIT)
        try:
            progress(0.5)
        except ReplacedError:
            self.replaced.set()
            raise
        return "held"


def test_the_latest_job_wins_and_those_between_are_never_begun(loop: Loop) -> None:
    first, begun = Held(), list[int]()
    loop.submit("plan", first)
    assert first.begun.wait(WAIT)
    for k in range(50):
        loop.submit("plan", lambda progress, k=k: begun.append(k) or k)  # type: ignore[misc]
    first.leave.set()
    until(lambda: loop.results == [49])
    assert first.replaced.is_set()
    assert begun == [49]
    assert loop.errors == []
    assert loop.shares == [("plan", 0.0), ("plan", None)], "the bar goes when the work is replaced"


def test_what_goes_wrong_is_told_and_the_next_job_is_done(loop: Loop) -> None:
    def fail(progress: Progress) -> None:
        progress(0.5)
        raise InputError("no such place")

    loop.submit("target", fail)
    until(lambda: loop.shares == [("target", 0.5), ("target", None)])
    assert loop.errors == ["doing target: no such place"]
    loop.submit("target", lambda progress: 1 / 0)
    until(lambda: len(loop.errors) == 2)
    loop.submit("target", lambda progress: "done")
    until(lambda: loop.results == ["done"])


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_report_that_fails_stops_no_later_job(loop: Loop) -> None:
    shares, loop.shares = loop.shares, None  # type: ignore[assignment]
    loop.submit("reach", lambda progress: progress(0.5))
    until(lambda: not loop.workers._threads)
    loop.shares = shares
    loop.submit("reach", lambda progress: "done")
    until(lambda: loop.results == ["done"])


def test_stopping_interrupts_at_the_next_progress(loop: Loop) -> None:
    working, waiting = Held(), Held()
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


class Source:
    """Says its count, or fails."""

    def __init__(self, kind: str) -> None:
        self.kind, self.count, self.failure = kind, 0, ""

    def __call__(self) -> Iterator[dict[str, Any]]:
        if self.failure:
            raise InputError(self.failure)
        yield {"type": self.kind, "count": self.count}


def test_pages_are_told_each_change_once_and_a_failing_source_stops_no_other() -> None:
    news, bad, good = ChangePublisher(), Source("bad"), Source("good")
    assert set(news.gather([bad, good])) == {"bad", "good"}
    assert news.gather([bad, good]) == {}
    bad.failure, good.count = "out of numbers", 1
    told = {kind: json.loads(text) for kind, text in news.gather([bad, good]).items()}
    assert told == {"error": {"type": "error", "message": "out of numbers"}, "good": {"type": "good", "count": 1}}
    good.count = 2
    assert set(news.gather([bad, good])) == {"good"}
    late = {kind: json.loads(text) for kind, text in news.everything().items()}
    assert (late["bad"]["count"], late["good"]["count"], late["error"]["message"]) == (0, 2, "out of numbers")
    bad.failure, bad.count = "", 3
    assert set(news.gather([bad, good])) == {"bad"}
    assert "error" not in news.everything()


def test_what_a_page_needs_is_made_while_one_page_needs_it(viewer: Viewer) -> None:
    def needs(page: Page, on: bool) -> None:
        page.ask(type="needs", collision=on, reach=False)

    def told(page: Page, value: float) -> bool:
        page.latest.pop("collision", None)
        page.ask(type="joint", name="pitch", value=value)
        page.until(lambda: page.latest["frame"]["theta"][1] == value)
        return "collision" in page.latest

    with Page(viewer) as page:
        other = page.other()
        for each in (page, other):
            needs(each, True)
        other.until(lambda: other.latest["collision"]["ready"])
        other.close()
        other.until_closed()
        assert told(page, 0.1)
        needs(page, False)
        told(page, 0.2)  # what it was told is taken back
        assert not told(page, 0.3)
