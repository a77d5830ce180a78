"""`sweep`: measures of many designs of an arm, in a table, and the best compromises among them."""

from __future__ import annotations

import inspect
import os
import tokenize
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass
from itertools import product
from math import prod
from typing import Any

import numpy as np

from ..arm.arm import Arm, require_arm
from ..arm.baking import text_of
from ..arm.loading.load import load_arm
from ..support.checks import Array, Progress, require_mapping, require_names
from ..support.errors import InputError, TwistarmError, listed, quote
from .chunks import Arrays, Sweep

Arms = Mapping[str, Arm] | Callable[..., Arm] | str | os.PathLike[str]
Measure = Callable[[Arm], Mapping[str, float]]

MOST_DESIGNS = 10**6


@dataclass(frozen=True, eq=False)
class DesignTable:
    """Designs with their parameters and measures: `rows`, a mapping each.

    A measure that a design lacks is NaN. Without an arm or measures, `error` in its row says why.
    """

    rows: tuple[Mapping[str, Any], ...]

    def column(self, name: str) -> Array:
        """The values (N,) of a measure, or of a parameter of numbers. InputError for another name."""
        if not isinstance(name, str) or any(name not in row for row in self.rows):
            raise InputError(f"no column {quote(name)}; columns: {listed(self.rows[0])}")
        return np.array([row[name] for row in self.rows], dtype=np.float64)

    def pareto(self, *, most: Sequence[str] = (), least: Sequence[str] = ()) -> DesignTable:
        """The designs that no other betters, by being as good in each wish and better in one.

        A design with NaN in a wish is left out.

        Args:
            most: Columns where more is better.
            least: Columns where less is better.

        Raises:
            InputError: There is no wish, or no such column.
        """
        wishes = [self.column(name) for name in require_names(most, "most")]
        wishes += [-self.column(name) for name in require_names(least, "least")]
        if not wishes:
            raise InputError("pareto needs columns in most=[...] or least=[...]")
        W = np.column_stack(wishes)
        kept = [not ((w <= W).all(axis=1) & (w < W).any(axis=1)).any() and not np.isnan(w).any() for w in W]
        return DesignTable(tuple(row for row, keep in zip(self.rows, kept, strict=True) if keep))


def sweep(
    arms: Arms,
    parameters: Mapping[str, Sequence[Any]] | None,
    measure: Measure,
    *,
    workers: int | None = 1,
    executor: Executor | None = None,
    folder: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> DesignTable:
    """Measure every design: each combination of the parameters' values.

    Args:
        arms: A function from the parameters, as keywords, to an arm; a xacro file with them as arguments; or
            {name: arm}.
        parameters: {name: values}, such as {"height": numpy.linspace(0.2, 0.6, 5)}. None for {name: arm}.
        measure: A function from an arm to {name: number}.
        workers: Threads. None for one per processor. A measure in Python alone gains only by processes.
        executor: Where to measure instead, as in `reach_map`. The functions must be at the top of a module.
        folder: A folder for a file per design, from which the same call resumes.
        progress: Called with the fraction done, or None.

    Returns:
        The `DesignTable`, in the order of the combinations. A TwistarmError of a design becomes its `error`.

    Raises:
        InputError: An argument cannot be used, a function failed, or the executor did.
    """
    if not callable(measure):
        raise InputError(f"measure must be a function from an arm to {{name: number}}; got {quote(measure)}")
    named = isinstance(arms, Mapping)
    if named == (parameters is not None) or not (named or callable(arms) or isinstance(arms, (str, os.PathLike))):
        raise InputError("give {name: arm} alone, or parameters with a function that makes an arm, or a xacro file")
    given = {} if named else require_mapping(parameters, "parameters", '{"height": [0.2, 0.3]}')
    axes: dict[str, list[Any]] = {"arm": list(arms)} if isinstance(arms, Mapping) else {}
    for name, values in given.items():
        if isinstance(values, str) or np.ndim(values) != 1:
            raise InputError(f"parameters[{name!r}] must be a sequence of values; got {quote(values)}")
        axes[name] = values.tolist() if isinstance(values, np.ndarray) else list(values)
    if not 0 < (count := prod(map(len, axes.values()))) <= MOST_DESIGNS:
        raise InputError(f"parameters must make 1 to {MOST_DESIGNS:,} designs; got {count:,}")
    designs = [dict(zip(axes, values, strict=True)) for values in product(*axes.values())]
    work = Sweep(_measured, (arms, measure, designs), count, 1, [_identity(arms), _identity(measure), repr(designs)])
    found = dict(work.run(workers=workers, executor=executor, folder=folder, progress=progress))
    chunks = [found[i] for i in range(count)]
    names = dict.fromkeys(name for chunk in chunks for name in chunk["names"].tolist())
    rows = []
    for design, chunk in zip(designs, chunks, strict=True):
        measures = dict(zip(chunk["names"].tolist(), chunk["values"].tolist(), strict=True))
        error = {"error": str(chunk["error"])} if chunk["error"] else {}
        rows.append(design | dict.fromkeys(names, np.nan) | measures | error)
    return DesignTable(tuple(rows))


def _identity(source: Any) -> Any:
    """What identifies arms, a file or a function, for JSON: a function by its text."""
    if isinstance(source, Mapping):
        return [text_of(require_arm(arm)) for arm in source.values()]
    # TokenError: the file that a function names is not always the Python that it was compiled from.
    with suppress(OSError, TypeError, SyntaxError, tokenize.TokenError):
        return inspect.getsource(source)
    return str(getattr(source, "__qualname__", source))


def _measured(data: tuple[Arms, Measure, list[dict[str, Any]]], first: int, _end: int) -> Arrays:
    """The measures of one design by name, or its error."""
    arms, measure, designs = data
    design = designs[first]
    numbers: dict[str, float] = {}
    error = ""
    try:
        if isinstance(arms, Mapping):
            arm = arms[design["arm"]]
        else:
            arm = arms(**design) if callable(arms) else load_arm(arms, xacro_args=design)
        numbers = {str(name): float(value) for name, value in measure(arm).items()}
    except TwistarmError as fault:
        error = str(fault)
    except Exception as fault:  # of a function that is not ours
        raise InputError(f"design {design}: {type(fault).__name__}: {fault}; mend the function") from fault
    return {"names": np.array(list(numbers), str), "values": np.array(list(numbers.values())), "error": np.array(error)}
