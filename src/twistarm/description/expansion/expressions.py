"""xacro's expressions: their syntax tree is checked against an allowed list, guarded, and evaluated by Python.

An expression may use what arms' descriptions need: numbers, texts, lists, arithmetic, comparisons, conditions, items,
comprehensions and calls. All else is refused. A guard takes the place of every dot, item and call. A dot names only an
item of a namespace or a dictionary, and only offered functions are called, so expressions reach neither Python's
objects nor files.
"""

from __future__ import annotations

import ast
import functools
from collections.abc import ItemsView, Iterator, KeysView, Mapping, Sequence, ValuesView
from datetime import date
from types import CodeType
from typing import Any

from .refused import Refused

REFUSED, TOO_LARGE = "xacro-expression-refused", "xacro-too-large"

MAX_LENGTH, MAX_DEPTH = 10_000, 100
"""Characters, and levels of the syntax tree. A sum has as many as terms. Python's parser recurses over longer ones."""

MAX_BITS = 10_000
"""Bits of a whole number. Arithmetic on such numbers is still instant."""

METHODS = {
    str: "capitalize count endswith find index isalnum isalpha isdigit islower isspace isupper join lower lstrip "
    "partition removeprefix removesuffix replace rsplit rstrip split startswith strip title upper",
    **{list: "copy count index", tuple: "count index", dict: "copy get items keys values", float: "is_integer"},
}
"""Methods that an expression may call. None changes its object. `format` is missing, as it reaches attributes."""

_ALLOWED = (
    *(ast.Constant, ast.Name, ast.Attribute, ast.Subscript, ast.Slice, ast.Call, ast.keyword, ast.IfExp),
    *(ast.BinOp, ast.operator, ast.UnaryOp, ast.unaryop, ast.Compare, ast.cmpop, ast.BoolOp, ast.boolop),
    *(ast.List, ast.Tuple, ast.Set, ast.Dict, ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp),
    *(ast.comprehension, ast.expr_context),
)

_WORDS = {
    **{"Lambda": "a lambda", "NamedExpr": "an assignment (:=)", "Starred": "unpacking with *"},
    **{"JoinedStr": "an f-string", "FormattedValue": "an f-string", "TemplateStr": "a t-string"},
}

_TOO_DEEP = REFUSED, "an expression nested that deep", "split it into properties"


class Expressions:
    """Evaluates expressions. Only the functions in `offered` can be called. `namespace` is xacro's type of one."""

    def __init__(self, namespace: type, *offered: Mapping[str, Any]) -> None:
        self._namespace = namespace
        self._offered = {id(value): value for names in offered for value in names.values() if callable(value)}
        guards = {"attribute": self._attribute, "item": self._item, "call": self._call, "operate": self._operate}
        guards["slice"] = lambda *bounds: slice(*self._data(bounds))
        self._guards: dict[str, Any] = {f"<{name}>": guard for name, guard in guards.items()} | {"__builtins__": {}}

    def evaluate(self, expression: str, names: Mapping[str, Any]) -> Any:
        """The value of `expression`. Raises Refused, or Python's error for a mistake in it."""
        try:
            return self._data(eval(_compiled(expression.strip()), _Names(self._guards, names)))
        except Refused as refused:
            refused.expression = refused.expression or expression
            raise

    def _data(self, value: Any) -> Any:
        """The value. Refused if it is not data: the text of a function or a type would reveal memory addresses."""
        stack = [value]
        while stack:
            part = stack.pop()
            if isinstance(part, int):
                _require_bits(part.bit_length())
            elif isinstance(part, dict) and not isinstance(part, self._namespace):
                stack += [*map(_key, part), *part.values()]
            elif isinstance(part, (list, tuple, range, set)):
                stack += map(_key, part) if isinstance(part, set) else part
            elif not isinstance(part, (str, float, date, type(None))):
                kind = "namespace" if isinstance(part, self._namespace) else "function" if callable(part) else ""
                what = f"a {kind or type(part).__name__} is no value, nor text"
                raise Refused(REFUSED, what, "call it, or name one of its items")
        return value

    def _attribute(self, value: Any, name: str) -> Any:
        """`value.name`."""
        if isinstance(value, dict):
            if name in value:
                return value[name]
            if isinstance(value, self._namespace):
                raise NameError(f"name {name!r} is not defined")
            raise AttributeError(f"The yaml dictionary has no key {name!r}")
        what = f"the attribute .{name} of a {type(value).__name__} is not allowed"
        allowed = _methods(value)
        remedy = f"allowed: {', '.join(allowed)}" if allowed else "only namespaces and dictionaries have dots"
        raise Refused(REFUSED, what, "join texts with + and str()" if name.startswith("format") else remedy)

    def _item(self, value: Any, at: Any) -> Any:
        """`value[at]`."""
        if not isinstance(at, slice):
            self._data(at)
        return self._attribute(value, at) if isinstance(value, dict) and isinstance(at, str) else value[at]

    def _call(self, owner: Any, name: str, /, *given: Any, **named: Any) -> Any:
        """`owner.name(...)`, or `owner(...)` where the name is empty."""
        own = bool(name) and name in _methods(owner) and not isinstance(owner, self._namespace)
        function = getattr(owner, name) if own else self._callable(self._attribute(owner, name) if name else owner)
        if "key" in named and function is not dict:
            raise Refused(REFUSED, "key= is not allowed", "sort or compare numbers and texts as they are")
        takes = function in (map, filter) and bool(given) and callable(given[0]) and bool(self._callable(given[0]))
        if function is not isinstance:
            self._data([*given[takes:], *named.values()])
        result = function(*given, **named)
        return list(result) if isinstance(result, (Iterator, KeysView, ValuesView, ItemsView)) else result

    def _callable(self, function: Any) -> Any:
        if id(function) not in self._offered:
            raise TypeError(f"{type(function).__name__!r} object is not callable")
        return function

    def _operate(self, kind: str, left: Any, right: Any) -> Any:
        """`left % right`, which may write the text of `right`, or a power or a shift, which may be huge."""
        if kind == "Mod":
            return left % self._data(right)
        if isinstance(left, int) and isinstance(right, int) and abs(left) > 1:
            _require_bits(left.bit_length() * right if kind == "Pow" else left.bit_length() + right)
        return left**right if kind == "Pow" else left << right


class _Names(dict[str, Any]):
    """The guards, and the names of an expression."""

    def __init__(self, guards: Mapping[str, Any], names: Mapping[str, Any]) -> None:
        super().__init__(guards)
        self._names = names

    def __missing__(self, name: str) -> Any:
        return self._names[name]


@functools.lru_cache(5000)
def _compiled(expression: str) -> CodeType:
    """The code. Refused if a part is not allowed, or if it is too deep."""
    if len(expression) > MAX_LENGTH:
        raise Refused(REFUSED, f"an expression of more than {MAX_LENGTH} characters", "split it into properties")
    try:
        tree = ast.parse(expression, mode="eval")
    except (RecursionError, MemoryError):
        raise Refused(*_TOO_DEEP) from None
    tree.body = _guarded(tree.body)
    return compile(ast.fix_missing_locations(tree), "<expression>", "eval")


def _guarded(node: Any, depth: int = 0) -> Any:
    """The checked tree, with guards where Python would reach into objects."""
    _check(node)
    if depth >= MAX_DEPTH:
        raise Refused(*_TOO_DEEP)
    if isinstance(node, ast.Call):
        of, name = (node.func.value, node.func.attr) if isinstance(node.func, ast.Attribute) else (node.func, "")
        node = _guard("call", of, ast.Constant(name), *node.args, named=node.keywords)
    for field, value in ast.iter_fields(node):
        parts = value if isinstance(value, list) else [value]
        changed = [_guarded(part, depth + 1) if isinstance(part, ast.AST) else part for part in parts]
        setattr(node, field, changed if isinstance(value, list) else changed[0])
    match node:
        case ast.Attribute():
            return _guard("attribute", node.value, ast.Constant(node.attr))
        case ast.Slice():
            return _guard("slice", *(part or ast.Constant(None) for part in (node.lower, node.upper, node.step)))
        case ast.Subscript():
            return _guard("item", node.value, node.slice)
        case ast.BinOp(op=ast.Mod() | ast.Pow() | ast.LShift()):
            return _guard("operate", ast.Constant(type(node.op).__name__), node.left, node.right)
        case ast.GeneratorExp():  # it would run later, and hold a frame
            return ast.ListComp(node.elt, node.generators)
    return node


def _guard(name: str, *given: ast.expr, named: Sequence[ast.keyword] = ()) -> ast.Call:
    """The call of a guard, by a name that no expression can write."""
    return ast.Call(ast.Name(f"<{name}>", ast.Load()), list(given), list(named))


def _check(node: ast.AST) -> None:
    if not isinstance(node, _ALLOWED):
        kind = type(node).__name__
        raise Refused(REFUSED, f"{_WORDS.get(kind, kind)} is not allowed", "use names, operators and calls")
    if isinstance(node, ast.Constant) and not isinstance(node.value, (str, int, float, type(None))):
        raise Refused(REFUSED, f"{node.value!r:.40} is not allowed", "use numbers and texts")
    if (isinstance(node, ast.keyword) and node.arg is None) or (isinstance(node, ast.Dict) and None in node.keys):
        raise Refused(REFUSED, "unpacking with ** is not allowed", "write each entry")
    if isinstance(node, (ast.Attribute, ast.Subscript)) and not isinstance(node.ctx, ast.Load):
        raise Refused(REFUSED, "an assignment is not allowed", "expressions compute and change nothing")
    if isinstance(node, ast.comprehension) and node.is_async:
        raise Refused(REFUSED, "async is not allowed", "leave it out")


def _key(value: Any) -> Any:
    """A key or a member of a set."""
    if isinstance(value, tuple):
        raise Refused(REFUSED, "a tuple as a key or in a set is not allowed", "use texts and numbers")
    return value


def _methods(value: Any) -> list[str]:
    return next((names.split() for kind, names in METHODS.items() if isinstance(value, kind)), [])


def _require_bits(bits: int) -> None:
    if bits > MAX_BITS:
        raise Refused(TOO_LARGE, f"a whole number of more than {MAX_BITS} bits", "use a float")
