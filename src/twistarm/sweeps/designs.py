"""`sweep`: measures of many designs of an arm, in a table, and the best compromises among them."""

from __future__ import annotations

import csv
import inspect
import io
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from ..arm.arm import Arm, require_arm
from ..arm.baking import digest_of
from ..arm.loading.load import load_arm
from ..support.checks import Array, require_mapping, require_names
from ..support.errors import InputError, TwistarmError, listed, shown
from ..support.files import write_whole
from .chunks import Arrays, Sweep

Measure = Callable[[Arm], Mapping[str, float]]
Make = Callable[..., Arm]

MOST_DESIGNS = 10**6


@dataclass(frozen=True)
class DesignTable:
    """Designs and their measures: `rows`, a mapping each; NaN where a design has no such measure.

    `parameters` and `measures` are the names of the columns. `errors` says by the row why there is no arm or measure.
    """

    parameters: tuple[str, ...]
    measures: tuple[str, ...]
    rows: tuple[Mapping[str, Any], ...]
    errors: Mapping[int, str]

    def __len__(self) -> int:
        return len(self.rows)

    def column(self, name: str) -> Array:
        """The values of a measure (N,), or of a parameter of numbers."""
        if name not in (*self.parameters, *self.measures):
            raise InputError(f"no column {shown(name)}; columns: {listed((*self.parameters, *self.measures))}")
        return np.array([row[name] for row in self.rows], dtype=np.float64)

    def pareto(self, *, most: Sequence[str] = (), least: Sequence[str] = ()) -> DesignTable:
        """The designs that no other design betters: at least as good in every wish, and better in one.

        A design with a NaN among the wishes is left out.

        Args:
            most: Columns of which more is better.
            least: Columns of which less is better.

        Raises:
            InputError: There is no wish, or no such column.
        """
        signs = [(name, 1.0) for name in require_names(most, "most")]
        signs += [(name, -1.0) for name in require_names(least, "least")]
        if not signs:
            raise InputError("pareto needs a wish: columns in most=[...] or least=[...]")
        wishes = np.column_stack([sign * self.column(name) for name, sign in signs])
        kept = [i for i in np.flatnonzero(np.isfinite(wishes).all(axis=1)) if not _bettered(wishes[i], wishes)]
        return DesignTable(self.parameters, self.measures, tuple(self.rows[i] for i in kept), {})

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """Write the table as CSV, a column for each parameter and measure, whole or not at all. Returns the path."""
        text = io.StringIO()
        writer = csv.DictWriter(text, [*self.parameters, *self.measures], lineterminator="\n")
        writer.writeheader()
        writer.writerows(self.rows)
        return write_whole(path, text.getvalue())


def _bettered(wish: Array, wishes: Array) -> bool:
    return bool(((wishes >= wish).all(axis=1) & (wishes > wish).any(axis=1)).any())


def sweep(
    arms: Mapping[str, Arm] | Make | str | os.PathLike[str],
    parameters: Mapping[str, Sequence[Any]] | None = None,
    measure: Measure | None = None,
    *,
    workers: int | None = 1,
    executor: Executor | None = None,
    folder: str | os.PathLike[str] | None = None,
    progress: Callable[[float], object] | None = None,
) -> DesignTable:
    """Measure every design: each combination of the parameters' values.

    Args:
        arms: {name: arm}; or a function from the parameters, as keywords, to an arm; or a xacro file, whose arguments
            the parameters are.
        parameters: {name: values}, such as {"height": numpy.linspace(0.2, 0.6, 5)}. None for {name: arm}.
        measure: A function from an arm to {name: number}.
        workers: Threads; None for one per processor. Functions in Python gain by an executor of processes alone.
        executor: Where to measure instead, as in `reach_map`. Functions must stand at the top of a module.
        folder: A folder for a file for each design, from which the same call resumes.
        progress: Called with the fraction done, or None.

    Returns:
        The `DesignTable`, in the order of the combinations. A TwistarmError of a design becomes its entry in `errors`.

    Raises:
        InputError: An argument cannot be used, a function failed, or the executor did.
    """
    if not callable(measure):
        raise InputError(f"measure must be a function from an arm to {{name: number}}; got {shown(measure)}")
    if isinstance(arms, Mapping):
        if parameters is not None or not arms:
            raise InputError("give arms as {name: arm}, at least one, or parameters for a function or a xacro file")
        axes: dict[str, list[Any]] = {"arm": list(require_mapping(arms, "arms", '{"short": arm}'))}
        identity = [digest_of(require_arm(arm)) for arm in arms.values()]
    else:
        if not callable(arms) and not isinstance(arms, (str, os.PathLike)):
            raise InputError(f"arms must be {{name: arm}}, a function that makes one, or a file; got {shown(arms)}")
        axes = _axes(parameters)
        identity = [_source(arms)]
    designs = [dict(zip(axes, values, strict=True)) for values in product(*axes.values())]
    if not 0 < len(designs) <= MOST_DESIGNS:
        raise InputError(f"parameters must make 1 to {MOST_DESIGNS:,} designs; got {len(designs):,}")
    work = Sweep(_measured, (arms, measure, designs), len(designs), 1, [*identity, _source(measure), repr(designs)])
    found: dict[int, Arrays] = {
        first: one for first, _, one in work.run(workers=workers, executor=executor, folder=folder, progress=progress)
    }
    return _table(tuple(axes), designs, [found[i] for i in range(len(designs))])


def _axes(parameters: Mapping[str, Sequence[Any]] | None) -> dict[str, list[Any]]:
    example = '{"height": [0.2, 0.3]}'
    given = require_mapping(parameters, "parameters", example)
    for name, values in given.items():
        if isinstance(values, str) or np.ndim(values) != 1:
            raise InputError(f"parameters[{name!r}] must be a sequence of values, as in {example}; got {shown(values)}")
    return {name: values.tolist() if isinstance(values, np.ndarray) else list(values) for name, values in given.items()}


def _source(made_by: Any) -> str:
    """What tells one function, or file, from another: its text."""
    if not callable(made_by):
        return str(os.fspath(made_by))
    try:
        return inspect.getsource(made_by)
    except (OSError, TypeError):
        return str(getattr(made_by, "__qualname__", type(made_by).__qualname__))


def _measured(data: tuple[Any, Measure, list[dict[str, Any]]], first: int, end: int) -> Arrays:
    """The measures of one design by name, or its error."""
    arms, measure, designs = data
    design, numbers, fault = designs[first], {}, ""
    try:
        if isinstance(arms, Mapping):
            arm = arms[design["arm"]]
        else:
            arm = arms(**design) if callable(arms) else load_arm(arms, xacro_args=design)
        numbers = {str(name): float(value) for name, value in measure(arm).items()}
    except TwistarmError as error:
        fault = str(error)
    except Exception as error:  # of a function that is not ours
        raise InputError(f"design {design}: {type(error).__name__}: {error}; mend the function") from error
    return {"names": np.array(list(numbers), str), "values": np.array(list(numbers.values())), "fault": np.array(fault)}


def _table(parameters: tuple[str, ...], designs: Sequence[Mapping[str, Any]], found: Sequence[Arrays]) -> DesignTable:
    each = [dict(zip(one["names"].tolist(), one["values"].tolist(), strict=True)) for one in found]
    measures = tuple(dict.fromkeys(name for numbers in each for name in numbers))
    rows = tuple({**d, **{name: n.get(name, np.nan) for name in measures}} for d, n in zip(designs, each, strict=True))
    errors = {i: str(one["fault"]) for i, one in enumerate(found) if one["fault"]}
    return DesignTable(parameters, measures, rows, errors)
