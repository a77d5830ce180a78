"""The names of xacro's expressions, with bounded versions of costly functions."""

from __future__ import annotations

import ast
import builtins
import functools
import math
import re
from collections.abc import Callable, Iterable
from typing import Any

from .expressions import REFUSED, TOO_LARGE, Expressions
from .work import Refused

_PLAIN = "abs all any bool dict divmod float int isinstance len list max min ord range repr set sorted str tuple"
"""Builtins that xacro offers. `vars`, `slice`, `hash` and `complex` are not among them."""

DIRECT = ["list", "dict", "map", "len", "str", "float", "int", "bool", "min", "max", "round", "sorted", "range"]
"""Names that need no `python.` before them."""

MAX_COUNT = 1000
"""Largest argument of factorial, comb and perm, and most decimals of round."""


def python_names(expressions: Expressions) -> dict[str, Any]:
    """The namespace `python`."""

    def mapped(function: Any, *values: Iterable[Any]) -> list[Any]:
        return [expressions.call(function, *row) for row in zip(*expressions.weigh(values), strict=False)]

    def filtered(function: Any, values: Iterable[Any]) -> list[Any]:
        kept = expressions.weigh(values)
        return [value for value in kept if (value if function is None else expressions.call(function, value))]

    names = {name: getattr(builtins, name) for name in _PLAIN.split()} | {
        "map": mapped,
        "filter": filtered,
        "sum": lambda values, start=0: functools.reduce(functools.partial(expressions.operate, ast.Add), values, start),
        "zip": lambda *values: list(zip(*values, strict=False)),
        "enumerate": lambda values, start=0: list(enumerate(values, start)),
        "reversed": lambda values: list(reversed(values)),
        "round": lambda number, ndigits=None: round(number, _count(ndigits)),
        "type": lambda value: type(value),
    }
    return expressions.offer(names, takers=[mapped, filtered])


def math_names(expressions: Expressions) -> dict[str, Any]:
    """The namespace `math`."""
    names = {name: value for name, value in vars(math).items() if not name.startswith("_")}

    def product(values: Iterable[Any], start: Any = 1) -> Any:
        return functools.reduce(functools.partial(expressions.operate, ast.Mult), values, start)

    def least_common_multiple(*values: int) -> Any:
        return functools.reduce(lambda a, b: expressions.weigh(math.lcm(a, b)), values, 1)

    counted = {name: _counted(names[name]) for name in ("factorial", "comb", "perm")}
    return expressions.offer(names | counted | {"prod": product, "lcm": least_common_multiple})


def tokenize(text: str, sep: str = ",; ", skip_empty: bool = True) -> list[str]:
    """xacro's function. `sep` lists characters. Characters that would make it a pattern are refused."""
    if set("]\\^") & set(sep) or "-" in sep[1:-1]:
        what = f"the separators {sep[:40]!a} are not allowed"
        raise Refused(REFUSED, what, "list characters; none of ] \\ ^, - last")
    words = re.split(f"[{re.escape(sep)}]", text)
    return [word for word in words if word] if skip_empty else words


def _counted(function: Callable[..., int]) -> Callable[..., int]:
    return lambda *counts: function(*map(_count, counts))


def _count(count: Any) -> Any:
    if isinstance(count, int) and abs(count) > MAX_COUNT:
        raise Refused(TOO_LARGE, f"a count beyond {MAX_COUNT} is not allowed", "use smaller numbers")
    return count
