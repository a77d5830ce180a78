"""Results of the state on show: computed at once and kept (`Memo`), or by a thread (`Job`)."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Generic, TypeVar

from ..support.checks import Progress
from ..support.errors import TwistarmError
from ..support.messages import Text

T = TypeVar("T")


class Memo(Generic[T]):
    """Calls `make` again once an argument is another object than at the last call.

    What is on show is replaced and never changed in place, so identity is enough and costs nothing.
    """

    def __init__(self, make: Callable[..., T]) -> None:
        self._make = make
        self._last: tuple[tuple[object, ...], T] | None = None

    def __call__(self, *arguments: object) -> T:
        """The result of `make(*arguments)`."""
        if self._last is None or not same(self._last[0], arguments):
            self._last = arguments, self._make(*arguments)
        return self._last[1]


def same(first: tuple[object, ...], second: tuple[object, ...]) -> bool:
    """Whether both hold the same objects."""
    return len(first) == len(second) and all(a is b for a, b in zip(first, second, strict=True))


@dataclass(frozen=True)
class Job:
    """`work(progress)` runs in the thread of its `key`. `finish(result)` runs in the loop and may change the stage.

    `progress` takes the fraction done. It raises ReplacedError once a later job with the same key waits. Errors of
    `work` go to the pages after `doing`, such as `planning the motion`.
    """

    key: str
    doing: str
    work: Callable[[Progress], Any]
    finish: Callable[[Any], None]


class ReplacedError(Exception):
    """A later job waits or the viewer closes, so the result is not needed."""


class Workers:
    """At most one thread for each key, while it has a job. The latest job of a key wins.

    deliver: runs an action in the loop. report: takes a key and the share done, 0 … 1, or None once that job has ended.
    Both are called from those threads.
    """

    def __init__(
        self, deliver: Callable[[Callable[[], None]], None], report: Callable[[str, float | None], None]
    ) -> None:
        self._deliver, self._report = deliver, report
        self._lock = threading.Lock()
        self._waiting: dict[str, Job] = {}
        self._threads: dict[str, threading.Thread] = {}
        self._stopped = False

    def submit(self, job: Job) -> None:
        """Queue `job` and return at once. A waiting job with the same key is dropped."""
        with self._lock:
            self._waiting[job.key] = job
            if job.key not in self._threads and not self._stopped:
                thread = threading.Thread(target=self._run, args=(job.key,), name=f"twistarm {job.key}", daemon=True)
                self._threads[job.key] = thread
                thread.start()

    def stop(self, timeout: float) -> None:
        """End every thread at its next progress call or with its job. Waits `timeout` [s] for each."""
        with self._lock:
            self._stopped = True
            threads = list(self._threads.values())
        for thread in threads:
            if thread is not threading.current_thread():  # a callback of the program may close the view
                thread.join(timeout)

    def _run(self, key: str) -> None:
        while True:
            with self._lock:
                job = None if self._stopped else self._waiting.pop(key, None)
                if job is None:
                    del self._threads[key]
                    return
            try:
                self._do(job)
            except BaseException:  # of a report or a delivery: without this no later job of the key would start
                with self._lock:
                    del self._threads[key]
                raise

    def _do(self, job: Job) -> None:
        has_reported = False

        def progress(share: float) -> None:
            nonlocal has_reported
            if self._stopped or job.key in self._waiting:  # looks that need no lock: if too early, the next one sees it
                raise ReplacedError
            has_reported = True
            self._report(job.key, share)

        try:
            result = job.work(progress)
        except ReplacedError:
            pass
        except Exception as error:
            self._deliver(partial(_fail, job, error))  # raised in the loop, which tells the pages
        else:
            self._deliver(lambda: job.finish(result))
        if has_reported:
            self._report(job.key, None)


def _fail(job: Job, error: Exception) -> None:
    why = error.message if isinstance(error, TwistarmError) else str(error) or type(error).__name__
    raise TwistarmError(Text("{doing}: {why}", doing=job.doing, why=why)) from error
