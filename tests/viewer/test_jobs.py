"""Work in threads: the latest wins, what goes wrong is told, and nothing is left running."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from twistarm.support.errors import InputError
from twistarm.viewer.protocol.jobs import Job, Progress, ReplacedError, Workers
from viewer_page import WAIT, until


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
