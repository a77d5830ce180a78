"""The names that xacro's expressions may use: those of xacro, with what could run away or reach out replaced."""

from __future__ import annotations

import builtins
import functools
import math
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from .guards import REFUSED, Guards
from .work import Refused
from .yaml_data import dotted

_PLAIN = """
    abs all any bool dict divmod float int isinstance len list max min ord range repr set sorted str tuple
"""
"""Builtins that xacro offers and that are harmless as `Guards.call` runs them. `vars` and `slice` are not among them:
the first reaches into types, the second copies uncounted."""

_DIRECT = "list dict map len str float int bool min max round sorted range"
"""Those that also stand without `python.` before them."""

MAX_COUNT = 1000
"""Largest argument of factorial, comb and perm, and most decimals of round."""


def python_names(guards: Guards) -> dict[str, Any]:
    """The namespace `python`."""
    plain = {name: getattr(builtins, name) for name in _PLAIN.split()}

    def mapped(function: Any, *values: Iterable[Any]) -> list[Any]:
        return [guards.call(function, *row) for row in zip(*values, strict=False)]

    def filtered(function: Any, values: Iterable[Any]) -> list[Any]:
        return [value for value in values if (value if function is None else guards.call(function, value))]

    def summed(values: Iterable[Any], start: Any = 0) -> Any:
        return functools.reduce(functools.partial(guards.operate, "Add"), values, start)

    return plain | {
        "map": mapped,
        "filter": filtered,
        "sum": summed,
        "zip": lambda *values: list(zip(*values, strict=False)),
        "enumerate": lambda values, start=0: list(enumerate(values, start)),
        "reversed": lambda values: list(reversed(values)),
        "round": _rounded,
        "type": lambda value: type(guards.data(value)),  # of a function's type, and a type's, more could be made
    }


def math_names(guards: Guards) -> dict[str, Any]:
    """The namespace `math`."""
    names = {name: value for name, value in vars(math).items() if not name.startswith("_")}

    def product(values: Iterable[Any], start: Any = 1) -> Any:
        return functools.reduce(functools.partial(guards.operate, "Mult"), values, start)

    def least_common_multiple(*values: int) -> Any:
        return functools.reduce(lambda a, b: guards.work.weigh(math.lcm(a, b)), values, 1)

    counted = {name: _counted(names[name]) for name in ("factorial", "comb", "perm")}
    return names | counted | {"prod": product, "lcm": least_common_multiple}


def direct_names(python: Mapping[str, Any]) -> dict[str, Any]:
    """What stands without a namespace."""
    return {name: python[name] for name in _DIRECT.split()}


def tokenize(text: str, sep: str = ",; ", skip_empty: bool = True) -> list[str]:
    """xacro's own; `sep` lists characters, and those that would make a pattern of it are refused."""
    if set("]\\^") & set(sep) or "-" in sep[1:-1]:
        raise Refused(
            REFUSED, f"the separators {sep[:40]!a} are not allowed", "list characters; none of ] \\ ^, - last"
        )
    words = re.split(f"[{re.escape(sep)}]", text)
    return [word for word in words if word] if skip_empty else words


def dotify(value: Any) -> Any:
    """xacro's own; what is not a dictionary yet would have to be made one."""
    if not isinstance(value, dict):
        raise Refused(REFUSED, "dotify() of anything but a dictionary is not allowed", "write {'key': value}")
    return dotted(value)


def _counted(function: Callable[..., int]) -> Callable[..., int]:
    def limited(*counts: int) -> int:
        _check_count(*counts)
        return function(*counts)

    return limited


def _rounded(number: Any, ndigits: int | None = None) -> Any:
    _check_count(ndigits or 0)
    return round(number, ndigits)


def _check_count(*counts: int) -> None:
    if any(isinstance(count, int) and abs(count) > MAX_COUNT for count in counts):
        raise Refused("xacro-too-large", f"a count beyond {MAX_COUNT} is not allowed", "use smaller numbers")
