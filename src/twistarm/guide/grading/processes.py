"""Processes for a reader's code: a program by itself, or a copy of this process; ended with all that they started."""

from __future__ import annotations

import contextlib
import json
import os
import secrets
import signal
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

WORKER = Path(__file__).with_name("worker.py")

IN_SANDBOX = "TWISTARM_GUIDE_GRADING"
"""Set where a reader's file is graded: a `check` in it does nothing then."""


@dataclass(frozen=True)
class Process:
    """A process that runs: where its results and its output are read, and `poll`, its exit code once it has ended.

    `mark` begins every line of its results that the worker wrote: a secret, of this process alone.
    """

    pid: int
    mark: bytes
    results: int
    output: int
    poll: Callable[[], int | None]


@contextlib.contextmanager
def program(job: Mapping[str, Any], folder: Path) -> Iterator[Process]:
    """The worker, on a job, in the reader's folder."""
    mark = secrets.token_hex()
    results, their_results = os.pipe()
    output, their_output = os.pipe()
    environment = dict(os.environ) | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", IN_SANDBOX: "1"}
    with tempfile.TemporaryFile() as stdin:
        stdin.write(json.dumps({**job, "mark": mark}).encode())
        stdin.seek(0)
        try:
            started = subprocess.Popen(
                [sys.executable, "-I", "-B", "-X", "utf8", str(WORKER), str(their_results)],
                stdin=stdin,
                stdout=their_output,
                stderr=their_output,
                pass_fds=[their_results],
                cwd=folder,
                env=environment,
                start_new_session=True,
            )
        except OSError:
            os.close(results)
            os.close(output)
            raise
        finally:
            os.close(their_results)
            os.close(their_output)
    process = Process(started.pid, mark.encode(), results, output, started.poll)
    try:
        yield process
    finally:
        _end(process)
        started.wait()


@contextlib.contextmanager
def copy_of_this_process(function: Callable[..., Any], job: Mapping[str, Any], memory: int) -> Iterator[Process]:
    """A copy of this process that calls `function` on the instances of `job`, and does nothing else."""
    mark = secrets.token_hex()
    results, their_results = os.pipe()
    output, their_output = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of threads: the copy uses nothing that they hold
        pid = os.fork()
    if pid == 0:
        try:
            _in_the_copy(function, job, memory, mark, their_results, their_output)
        finally:
            os._exit(0)
    os.close(their_results)
    os.close(their_output)
    code: list[int] = []

    def poll() -> int | None:
        if not code:
            done, status = os.waitpid(pid, os.WNOHANG)
            code.extend([os.waitstatus_to_exitcode(status)] if done else [])
        return code[0] if code else None

    process = Process(pid, mark.encode(), results, output, poll)
    try:
        yield process
    finally:
        _end(process)
        if not code:
            os.waitpid(pid, 0)


def _in_the_copy(
    function: Callable[..., Any], job: Mapping[str, Any], memory: int, mark: str, results: int, output: int
) -> None:
    from . import worker

    os.setsid()
    nothing = os.open(os.devnull, os.O_RDONLY)
    for theirs, standard in ((nothing, 0), (output, 1), (output, 2)):
        os.dup2(theirs, standard)
    # Those of a notebook are its own, and lead back into it.
    sys.stdin = os.fdopen(0, closefd=False)
    sys.stdout = sys.stderr = os.fdopen(1, "w", closefd=False)
    os.environ[IN_SANDBOX] = "1"
    worker.limit(memory)
    for name, instances in job.items():
        worker.answer(name, function, instances, function.__code__.co_filename, worker.teller(results, mark))
    sys.stdout.flush()


def _end(process: Process) -> None:
    """End the process and its group, and close what was read."""
    with contextlib.suppress(OSError):
        os.killpg(process.pid, signal.SIGKILL)
    with contextlib.suppress(OSError):
        if process.poll() is None:
            os.kill(process.pid, signal.SIGKILL)
    os.close(process.results)
    os.close(process.output)
