"""xacro's expressions, examined before Python evaluates them.

An expression may compute. A dot reaches an item of a namespace or of loaded YAML, or a method of a text, a number or a
list; it never reaches another attribute, because attributes lead from any object to all of Python. There are no
builtins beyond those that xacro offers.
"""

from __future__ import annotations

import ast
import functools
import math
import operator
import warnings
from collections.abc import Callable, Iterator, Mapping, Sized
from types import CodeType
from typing import Any

from .confinement import Refused

REFUSED, TOO_LARGE = "xacro-expression-refused", "xacro-failed"

MAX_DEPTH = 100
"""Levels of the syntax tree. A sum has as many as terms, and Python's compiler recurses."""

MAX_BITS, MAX_LENGTH = 100_000, 10_000_000
"""Bits of a power, and length of a repeated list or text. Python computes larger ones without heeding Ctrl-C."""

MAX_FIELDS = 100
"""Fields of a text in `text % values`."""

MAX_COUNT = 10_000
"""Largest argument of factorial, comb and perm."""

MAX_RANGE = 1_000_000

DATA = (str, bool, int, float, complex, list, tuple, dict, set, frozenset, range)
"""Types of values whose methods only compute."""

OUT = ("format", "format_map", "sort")
"""Methods that reach attributes by themselves, or call a function without heeding Ctrl-C."""

_WORDS = {ast.NamedExpr: "an assignment (:=)", ast.Await: "await", ast.Yield: "yield", ast.YieldFrom: "yield"}


class _Guarded(ast.NodeTransformer):
    """Calls our functions for attributes, and for operators whose results may be huge."""

    OPERATORS = (ast.Pow, ast.LShift, ast.Mult, ast.Mod)

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        return _call("__attribute__", self.visit(node.value), ast.Constant(node.attr))

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        if not isinstance(node.op, self.OPERATORS):
            return node
        return _call("__operate__", ast.Constant(type(node.op).__name__), node.left, node.right)


def evaluate(expression: str, names: Any, namespace: Any) -> Any:
    """The value of an expression with these global names. `namespace` is the type of xacro's scopes.

    Raises Refused, or Python's error for a mistake in it.
    """

    def attribute(value: Any, name: str) -> Any:
        if isinstance(value, namespace):
            try:
                return value[name]
            except KeyError:
                raise NameError(f"name {name!r} is not defined") from None
        if isinstance(value, DATA) and not name.startswith("_") and name not in OUT:
            return getattr(value, name)  # a class of xacro makes items of a dictionary of its attributes
        what = f"the attribute .{name} of a {type(value).__name__} is not allowed"
        raise Refused(REFUSED, what, "join texts with + and str()" if name.startswith("format") else "")

    names.update(__builtins__={"__attribute__": attribute, "__operate__": operate})
    value = eval(_compiled(expression.strip()), names)
    if isinstance(value, namespace) or (callable(value) and not isinstance(value, type)):
        raise Refused(REFUSED, f"a {type(value).__name__} is no value", "call it, or name one of its items")
    return value


@functools.lru_cache(4096)
def _compiled(expression: str) -> CodeType:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about odd expressions, which nobody who reads the file can mend
        return compile(ast.fix_missing_locations(_Guarded().visit(_checked(expression))), "<expression>", "eval")


def operate(name: str, left: Any, right: Any) -> Any:
    """A power, a shift to the left, a product, or a text with values. Refused if the result would be huge."""
    if isinstance(left, int) and isinstance(right, int):
        bits = {
            "Pow": left.bit_length() * right if abs(left) > 1 else 0,
            "LShift": left.bit_length() + right,
            "Mult": left.bit_length() + right.bit_length(),
        }
        if bits.get(name, 0) > MAX_BITS:
            raise Refused(TOO_LARGE, f"a whole number of more than {MAX_BITS:,} bits", "use a float")
    elif name == "Mod" and isinstance(left, str) and left.count("%") > MAX_FIELDS:
        raise Refused(TOO_LARGE, f"a text with more than {MAX_FIELDS} fields", "make it shorter")
    elif name == "Mult":
        for value, times in ((left, right), (right, left)):
            if isinstance(value, Sized) and isinstance(times, int) and len(value) * times > MAX_LENGTH:
                raise Refused(TOO_LARGE, f"a list or text of more than {MAX_LENGTH:,} parts", "make it shorter")
    compute = {"Pow": operator.pow, "LShift": operator.lshift, "Mult": operator.mul, "Mod": operator.mod}
    return compute[name](left, right)


def safer(name: str, function: Any) -> Any:
    """A function that xacro offers, bounded, or without what leads out of expressions."""
    return _SAFER.get(name, function)


def _checked(expression: str) -> ast.Expression:
    """The syntax tree. Refused if a part is not allowed, or if it is too deep."""
    try:
        tree = ast.parse(expression, mode="eval")
    except (RecursionError, MemoryError):
        raise Refused(REFUSED, "an expression nested that deep", "split it into properties") from None
    level: list[ast.AST] = [tree]
    for _ in range(MAX_DEPTH):
        if not level:
            return tree
        for node in level:
            _check(node)
        level = [child for node in level for child in ast.iter_child_nodes(node)]
    raise Refused(REFUSED, "an expression nested that deep", "split it into properties")


def _check(node: ast.AST) -> None:
    if type(node) in _WORDS:
        raise Refused(REFUSED, f"{_WORDS[type(node)]} is not allowed", "use names, operators and calls")
    if isinstance(node, ast.Attribute | ast.Subscript) and not isinstance(node.ctx, ast.Load):
        raise Refused(REFUSED, "an assignment is not allowed", "expressions compute and change nothing")
    if isinstance(node, ast.comprehension) and node.is_async:
        raise Refused(REFUSED, "async is not allowed", "leave it out")
    for name in (getattr(node, field, None) for field in ("id", "attr", "arg")):
        if isinstance(name, str) and name.startswith("__"):
            raise Refused(REFUSED, f"the name {name} is not allowed", "use the names that xacro offers")


def _call(function: str, *arguments: Any) -> ast.Call:
    return ast.Call(ast.Name(function, ast.Load()), list(arguments), [])


def _range(*bounds: int) -> range:
    made = range(*bounds)
    if len(made) > MAX_RANGE:
        raise Refused(TOO_LARGE, f"a range of more than {MAX_RANGE:,} numbers", "use fewer")
    return made


def _counted(function: Callable[..., int]) -> Callable[..., int]:
    def bounded(*counts: int) -> int:
        if any(abs(count) > MAX_COUNT for count in counts):
            raise Refused(TOO_LARGE, f"a count beyond {MAX_COUNT:,} is not allowed", "use smaller numbers")
        return function(*counts)

    return bounded


def _map(function: Any, *values: Any) -> Iterator[Any]:
    return (function(*row) for row in zip(*values, strict=False))


def _filter(function: Any, values: Any) -> Iterator[Any]:
    return (value for value in values if (value if function is None else function(value)))


def _by_key(function: Any) -> Any:
    def keyed(*values: Any, key: Any = None, **options: Any) -> Any:
        return function(*values, key=None if key is None else lambda value: key(value), **options)

    return keyed


def _sum(values: Any, start: Any = 0) -> Any:
    parts = list(values)
    if all(isinstance(part, int | float) for part in parts):
        return sum(parts, start)
    for part in parts:  # of lists this takes long, and Python's own sum heeds no Ctrl-C
        start = start + part
    return start


def _product(values: Any, start: Any = 1) -> Any:
    return functools.reduce(functools.partial(operate, "Mult"), values, start)


def _type(value: Any) -> type:
    """The type of data. `type` itself makes classes, which call what they are given."""
    if not isinstance(value, (*DATA, type(None))):
        raise Refused(REFUSED, "a type of this value is not allowed", "compare numbers, texts and lists")
    return type(value)


# Python's own `map`, `filter` and keys call a function for each of very many values and heed no Ctrl-C between.
_SAFER: Mapping[str, Any] = {
    **{"range": _range, "type": _type, "map": _map, "filter": _filter, "sum": _sum, "prod": _product},
    **{function.__name__: _by_key(function) for function in (max, min, sorted)},
    **{name: _counted(getattr(math, name)) for name in ("factorial", "comb", "perm")},
    **dict.fromkeys(("vars", "hash", "slice")),
}
