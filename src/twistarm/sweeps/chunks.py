"""A count of items in chunks: each a pure function, on any executor, a file each, so that a sweep resumes."""

from __future__ import annotations

import hashlib
import io
import json
import os
import zipfile
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import __version__
from ..support.checks import as_whole, require_callback, require_method
from ..support.errors import SHOWN, InputError, TwistarmError, one_line
from ..support.files import as_path, read_bounded, write_whole

Arrays = Mapping[str, NDArray[Any]]
Chunk = tuple[int, int, Arrays]
"""First item, end, and what was computed for them."""

AHEAD = 256
"""Chunks given to an executor at a time. More would keep their arguments in memory for nothing."""

MOST_WORKERS = 1024

MAX_BYTES = 2**30
"""Of a file of one chunk."""


@dataclass(frozen=True)
class Sweep:
    """`count` items in chunks of `size`, each computed by `work(data, first, end)`.

    `work` is a pure function at the top of a module, which returns arrays by name. So the chunks have the same bits in
    any order and on any number of workers. `data` is what every chunk needs: an arm and settings, as bytes where
    executors copy them. `identity` is what the answers depend on, for JSON. It tells the files of this sweep from those
    of others.
    """

    work: Callable[[Any, int, int], Arrays]
    data: Any = field(repr=False)
    count: int
    size: int
    identity: Any = field(repr=False)

    def run(
        self,
        *,
        workers: int | None = 1,
        executor: Executor | None = None,
        folder: str | os.PathLike[str] | None = None,
        progress: Callable[[float], object] | None = None,
    ) -> Iterator[Chunk]:
        """Compute every chunk, and yield each once, in the order in which they are done.

        Args:
            workers: Threads; None for one per processor. They share work of the compiled core and of NumPy.
            executor: Where to compute instead: a ProcessPoolExecutor, dask's `client.get_executor()`, an
                MPIPoolExecutor, or anything with their `submit`.
            folder: A folder for a file for each chunk, made if it is missing. Chunks that are there already are read.
            progress: Called with the fraction done after each chunk, or None.

        Raises:
            InputError: An argument cannot be used, or the executor failed. The message says how to resume.
        """
        require_callback(progress, "progress", "(fraction)")
        threads = as_whole(os.cpu_count() if workers is None else workers, "workers", 1, MOST_WORKERS)
        if executor is not None:
            require_method(executor, "executor", "submit")
        return self._chunks(threads, executor, None if folder is None else _made(folder), progress or (lambda _: None))

    def _chunks(
        self, threads: int, executor: Executor | None, folder: Path | None, progress: Callable[[float], object]
    ) -> Iterator[Chunk]:
        starts, left, done = range(0, self.count, self.size), [], 0
        for first in starts:
            kept = None if folder is None else _read(self._file(folder, first))
            if kept is None:
                left.append(first)
                continue
            done += 1
            yield first, self._end(first), kept
            progress(done / len(starts))
        left.reverse()
        with ThreadPoolExecutor(threads) if executor is None else nullcontext(executor) as pool:
            ahead = 2 * threads if executor is None else AHEAD
            waiting: dict[Future[Arrays], int] = {}
            try:
                while left or waiting:
                    try:
                        while left and len(waiting) < ahead:
                            waiting[pool.submit(self.work, self.data, left[-1], self._end(left[-1]))] = left.pop()
                        finished = wait(waiting, return_when=FIRST_COMPLETED).done
                    except Exception as error:
                        raise _failed(error, done, len(starts), folder) from error
                    for future in sorted(finished, key=_fails):  # what is done is kept before a failure is told
                        first = waiting.pop(future)
                        try:
                            arrays = future.result()
                        except TwistarmError:
                            raise
                        except Exception as error:
                            raise _failed(error, done, len(starts), folder) from error
                        if folder is not None:
                            write_whole(self._file(folder, first), _packed(arrays))
                        done += 1
                        yield first, self._end(first), arrays
                        progress(done / len(starts))
            finally:
                for future in waiting:
                    future.cancel()

    def _end(self, first: int) -> int:
        return min(first + self.size, self.count)

    def _file(self, folder: Path, first: int) -> Path:
        asked = [self.work.__qualname__, self.count, self.size, __version__, self.identity]
        digest = hashlib.sha256(json.dumps(asked, sort_keys=True).encode()).hexdigest()[:16]
        return folder / f"{digest}-{first:012d}.npz"


def _fails(future: Future[Arrays]) -> bool:
    return future.cancelled() or future.exception() is not None


def _failed(error: Exception, done: int, count: int, folder: Path | None) -> InputError:
    why = one_line(f"{type(error).__name__}: {error}".removesuffix(": "), 2 * SHOWN)
    resume = "with a folder the same call would go on there" if folder is None else f"the same call goes on in {folder}"
    return InputError(f"the executor failed ({why}) after {done} of {count} chunks; {resume}")


def _made(folder: str | os.PathLike[str]) -> Path:
    path = as_path(folder)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot keep chunks in {path}: {error.strerror}; give a folder") from error
    return path


def _packed(arrays: Arrays) -> bytes:
    file = io.BytesIO()
    np.savez_compressed(file, **arrays)  # type: ignore[arg-type]
    return file.getvalue()


def _read(path: Path) -> Arrays | None:
    """The arrays of a chunk's file; None if there is no whole one, so that the chunk is computed again."""
    try:
        with np.load(io.BytesIO(read_bounded(path, MAX_BYTES)), allow_pickle=False) as file:
            return dict(file)
    except (OSError, ValueError, EOFError, zipfile.BadZipFile):
        return None
