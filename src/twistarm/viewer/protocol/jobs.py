"""Long work in threads, one for each kind. The latest job of a kind wins."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from ...support.errors import TwistarmError

Progress = Callable[[float], None]

Deliver = Callable[[Callable[[], None]], None]
"""Runs an action in the loop."""

Tell = Callable[[str, float | None], None]
"""Reports the progress of a key's job, 0 … 1. None: that job has ended."""


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
    """A thread for each key, begun with its first job. `deliver` and `tell` are called from those threads."""

    def __init__(self, deliver: Deliver, tell: Tell) -> None:
        self._deliver, self._tell = deliver, tell
        self._workers: dict[str, _Worker] = {}

    def submit(self, job: Job) -> None:
        """Queue `job` and return at once. A waiting job with the same key is dropped."""
        if job.key not in self._workers:
            self._workers[job.key] = _Worker(job.key, self._deliver, self._tell)
        self._workers[job.key].submit(job)

    def stop(self, timeout: float) -> None:
        """End every thread at its next progress call or with its job. Waits `timeout` [s] for each."""
        workers = list(self._workers.values())
        for worker in workers:
            worker.stop()
        for worker in workers:
            if worker.thread is not threading.current_thread():  # a callback of the program may close the view
                worker.thread.join(timeout)


class _Worker:
    def __init__(self, key: str, deliver: Deliver, tell: Tell) -> None:
        self._key, self._deliver, self._tell = key, deliver, tell
        self._changed = threading.Condition()
        self._waiting: Job | None = None
        self._stopped = False
        self._reported = False
        self.thread = threading.Thread(target=self._run, name=f"twistarm {key}", daemon=True)
        self.thread.start()

    def submit(self, job: Job) -> None:
        with self._changed:
            self._waiting = job
            self._changed.notify()

    def stop(self) -> None:
        with self._changed:
            self._stopped = True
            self._changed.notify()

    def _run(self) -> None:
        while (job := self._next()) is not None:
            self._do(job)

    def _next(self) -> Job | None:
        with self._changed:
            self._changed.wait_for(lambda: self._stopped or self._waiting is not None)
            job, self._waiting = self._waiting, None
            return None if self._stopped else job

    def _do(self, job: Job) -> None:
        try:
            result = job.work(self._progress)
        except ReplacedError:
            return
        except Exception as error:
            self._deliver(partial(_fail, job, error))
        else:
            self._deliver(lambda: job.finish(result))
        finally:
            if self._reported:
                self._tell(self._key, None)
            self._reported = False

    def _progress(self, share: float) -> None:
        if self._stopped or self._waiting is not None:
            raise ReplacedError
        self._reported = True
        self._tell(self._key, share)


def _fail(job: Job, error: Exception) -> None:
    raise TwistarmError(f"{job.doing}: {str(error) or type(error).__name__}") from error
