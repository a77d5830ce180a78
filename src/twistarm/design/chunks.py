"""A count of items in chunks. Each is a pure function, on any executor, with a file, so that a sweep resumes."""

from __future__ import annotations

import hashlib
import io
import json
import os
from collections.abc import Callable, Generator, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from contextlib import closing, nullcontext, suppress
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import twistarm

from ..support.checks import Progress, as_whole, reporting, require_method
from ..support.errors import QUOTED, InputError, TwistarmError, one_line
from ..support.files import as_path, open_regular, write_whole

Arrays = Mapping[str, NDArray[Any]]

AHEAD = 256  # Chunks given to an executor at a time. More would keep their arguments in memory for nothing.

MOST_WORKERS = 1024


@dataclass(frozen=True, eq=False, repr=False)
class Sweep:
    """`count` items in chunks of `size`, each computed by `work(data, first, end)`.

    `work` is a pure function at the top of a module and returns arrays by name. So the chunks have the same bits in any
    order, on any number of workers. `data` is an arm and settings, as bytes where an executor copies them. `identity`
    is all that the answers depend on, for JSON. It separates the files of one sweep from those of another.
    """

    work: Callable[[Any, int, int], Arrays]
    data: Any
    count: int
    size: int
    identity: Any

    def run(
        self,
        *,
        workers: int | None = 1,
        executor: Executor | None = None,
        folder: str | os.PathLike[str] | None = None,
        progress: Progress | None = None,
    ) -> Iterator[tuple[int, Arrays]]:
        """Yield each chunk once: its first item and its arrays, in the order in which they are done.

        Args:
            workers: Threads. None for one per processor. They share the work of the compiled core and of NumPy.
            executor: Where to compute instead: a ProcessPoolExecutor, dask's `client.get_executor()`, an
                MPIPoolExecutor, or anything with their `submit`.
            folder: A folder for a file per chunk, made if it is missing. The chunks that it has are read.
            progress: Called with the fraction done after each chunk, or None.

        Raises:
            InputError: An argument cannot be used, or the executor failed. The message says how to resume.
        """
        report_progress = reporting(progress)
        threads = as_whole(os.cpu_count() if workers is None else workers, "workers", 1, MOST_WORKERS)
        if executor is not None:
            require_method(executor, "executor", "submit")
        kept = None if folder is None else as_path(folder)
        with suppress(OSError, ValueError):  # writing says what is wrong
            os.makedirs(kept or ".", exist_ok=True)
        total, done, left = -(-self.count // self.size), 0, []
        for first in range(0, self.count, self.size):
            found = None if kept is None else _read(self._file(kept, first))
            if found is None:
                left.append(first)
                continue
            done += 1
            yield first, found
            report_progress(done / total)
        own = nullcontext(executor) if executor is not None else ThreadPoolExecutor(threads)
        with own as pool, closing(self._results(pool, left)) as results:
            while done < total:
                try:
                    first, arrays = next(results)
                except TwistarmError:
                    raise
                except Exception as error:  # an executor may raise anything
                    why = one_line(f"{type(error).__name__}: {error}".removesuffix(": "), 2 * QUOTED)
                    go_on = "give a folder to resume from" if kept is None else f"the same call goes on in {kept}"
                    left_off = f"{done} of {total} chunks are done; {go_on}"
                    raise InputError(f"the executor failed ({why}); {left_off}") from error
                if kept is not None:
                    file = io.BytesIO()
                    np.savez_compressed(file, **arrays)  # type: ignore[arg-type]
                    write_whole(self._file(kept, first), file.getvalue())
                done += 1
                yield first, arrays
                report_progress(done / total)

    def _results(self, pool: Executor, left: list[int]) -> Generator[tuple[int, Arrays], None, None]:
        """The chunks that begin at these items, as they are done."""
        rest, waiting = iter(left), dict[Future[Arrays], int]()
        try:
            while True:
                for first in islice(rest, AHEAD - len(waiting)):
                    end = min(first + self.size, self.count)
                    waiting[pool.submit(self.work, self.data, first, end)] = first
                if not waiting:
                    return
                finished = wait(waiting, return_when=FIRST_COMPLETED).done
                # What is done comes before a failure, which ends the sweep: the first of several, by the items.
                failed = {future: future.cancelled() or future.exception() is not None for future in finished}
                for future in sorted(finished, key=lambda done: (failed[done], waiting[done])):
                    yield waiting.pop(future), future.result()
        finally:
            for future in waiting:
                future.cancel()

    def _file(self, folder: Path, first: int) -> Path:
        asked = [self.work.__qualname__, self.count, self.size, twistarm.__version__, self.identity]
        digest = hashlib.sha256(json.dumps(asked, sort_keys=True).encode()).hexdigest()[:16]
        return folder / f"{digest}-{first:012d}.npz"


def _read(path: Path) -> Arrays | None:
    """The arrays of a chunk's file; None without a whole one, so that the chunk is computed again."""
    # A damaged file raises errors of any kind, of zipfile, zlib or NumPy.
    with suppress(Exception), open_regular(path) as file, np.load(file, allow_pickle=False) as arrays:
        return dict(arrays)
    return None
