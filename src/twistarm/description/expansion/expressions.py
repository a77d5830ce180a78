"""xacro's expressions, evaluated by a walk over their syntax tree that allows only the nodes in this file.

An expression may use what arms' descriptions need: numbers, texts, lists, arithmetic, comparisons, conditions, items,
comprehensions and calls. Each kind of node has a method here. Tables list the operators and the methods of values. All
else is refused. A dot names only an item of a namespace or a dictionary, so expressions cannot reach Python's objects.
The work counts each step, and each value by its size.
"""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Iterator, Mapping, Sequence, Sized
from datetime import date
from typing import Any

from .work import CHARACTERS_PER_UNIT, Refused, Work

REFUSED, TOO_LARGE = "xacro-expression-refused", "xacro-failed"

MAX_LENGTH = 10_000
"""Longest expression. Python's parser recurses over longer ones."""

MAX_DEPTH = 100
"""Levels of the syntax tree. A sum has as many as terms."""

MAX_BITS = 10_000
"""Bits of a whole number. Arithmetic on such numbers is still instant."""

MAX_KEY_BITS = 60
"""Bits of a whole number as a key. Longer ones may share their hash, which makes sets slow."""

EVALUATION_COST = 10

SCOPES_PER_UNIT = 4
"""The search for a name goes through the scope of each enclosing macro."""

OPERATORS: dict[type[ast.AST], Callable[..., Any]] = {
    **{ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv},
    **{ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.Pow: operator.pow},
    **{ast.LShift: operator.lshift, ast.RShift: operator.rshift},
    **{ast.BitOr: operator.or_, ast.BitAnd: operator.and_, ast.BitXor: operator.xor},
    **{ast.UAdd: operator.pos, ast.USub: operator.neg, ast.Invert: operator.invert, ast.Not: operator.not_},
    **{ast.Eq: operator.eq, ast.NotEq: operator.ne, ast.Is: operator.is_, ast.IsNot: operator.is_not},
    **{ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge},
    **{ast.In: lambda part, whole: part in whole, ast.NotIn: lambda part, whole: part not in whole},
}

_OF_TEXT = """
    capitalize count endswith find index isalnum isalpha isdigit islower isspace isupper join lower lstrip partition
    removeprefix removesuffix replace rsplit rstrip split startswith strip title upper
"""
METHODS: dict[type, list[str]] = {
    str: _OF_TEXT.split(),
    list: ["copy", "count", "index"],
    tuple: ["count", "index"],
    dict: ["copy", "get", "items", "keys", "values"],
    float: ["is_integer"],
}
"""Methods that an expression may call. None changes its object. `format` is missing, as it reaches attributes."""

_FIELD = re.compile(r"%[-+ #0]*\d{0,3}(?:\.\d{0,3})?[a-zA-Z%]")
"""A narrow field of `text % values` without a name, because %(name)s would multiply a value."""

_WORDS = {
    **{"Lambda": "a lambda", "NamedExpr": "an assignment (:=)", "MatMult": "the operator @"},
    **{"JoinedStr": "an f-string", "FormattedValue": "an f-string", "TemplateStr": "a t-string"},
    **{"Starred": "unpacking with *"},
}


class Expressions:
    """Evaluates expressions with counted work. `namespace` is the type of xacro's namespaces.

    Only functions that were offered can be called.
    """

    def __init__(self, work: Work, namespace: type) -> None:
        self._work, self._namespace = work, namespace
        self._trees: dict[str, ast.expr] = {}
        self._offered: dict[int, Any] = {}
        self._takers: list[Any] = [isinstance]

    def offer(self, names: dict[str, Any], takers: Sequence[Any] = ()) -> dict[str, Any]:
        """Allow the functions in `names`, and return `names`. `takers` may get functions as arguments."""
        self._offered |= {id(value): value for value in names.values() if callable(value)}
        self._takers += takers
        return names

    def evaluate(self, expression: str, names: Mapping[str, Any]) -> Any:
        """The value of `expression`. Raises Refused, or Python's error for a mistake in it."""
        tree = self._trees.get(expression)
        if tree is None:
            self._work.charge(len(expression))
            tree = self._trees[expression] = checked(expression.strip())
        self._work.charge(EVALUATION_COST)
        return self.weigh(self._value(tree, names))

    def weigh(self, value: Any) -> Any:
        """Charge a value's size, with shared parts each time they occur, and return it.

        Refused for a value that is not data. The text of a function or a type would reveal memory addresses.
        """
        size, stack = 0, [value]
        while stack and size <= self._work.left:
            part = stack.pop()
            size += 1
            if isinstance(part, str):
                size += len(part) // CHARACTERS_PER_UNIT
            elif isinstance(part, int):
                _require_bits(part.bit_length())
            elif isinstance(part, (list, tuple, set)):
                stack.extend(part)
            elif isinstance(part, dict) and not isinstance(part, self._namespace):
                stack += [*part, *part.values()]
            elif isinstance(part, range):
                size += len(part)
            elif not isinstance(part, (float, date, type(None))):
                kind = "namespace" if isinstance(part, self._namespace) else "function" if callable(part) else ""
                what = f"a {kind or type(part).__name__} is no value, nor text"
                raise Refused(REFUSED, what, "call it, or name one of its items")
        self._work.charge(size)
        return value

    def call(self, function: Any, /, *given: Any, **named: Any) -> Any:
        """The value of `function(...)`, if the function was offered."""
        if id(function) not in self._offered:
            raise TypeError(f"{type(function).__name__!r} object is not callable")
        if "key" in named and function is not dict:
            raise Refused(REFUSED, "key= is not allowed", "sort or compare numbers and texts as they are")
        if function not in self._takers:
            self.weigh([*given, *named.values()])
        if function is dict and given and not isinstance(given[0], dict):
            raise Refused(REFUSED, "a dict() of pairs is not allowed", "write {key: value for key, value in pairs}")
        if function is set:
            given = tuple([key(member) for member in members] for members in given)
        result = function(*given, **named)
        return result if callable(result) else self.weigh(result)

    def operate(self, kind: type[ast.AST], left: Any, right: Any) -> Any:
        """The value of `left` operator `right`. Refused if the result would be huge."""
        self.weigh(left)
        self.weigh(right)
        if kind is ast.Mult:
            for value, times in ((left, right), (right, left)):
                if isinstance(value, Sized) and isinstance(times, int):
                    unit = CHARACTERS_PER_UNIT if isinstance(value, str) else 1
                    self._work.charge(len(value) * max(0, times) // unit)
        elif kind is ast.Mod and isinstance(left, str):
            if "%" in _FIELD.sub("", left):
                what = "a field that is named, or wider than 999, is not allowed"
                raise Refused(REFUSED, what, "write fields such as %s and %.3f")
            self._work.charge_text(1000 * left.count("%"))
        elif kind in (ast.Pow, ast.LShift) and isinstance(left, int) and isinstance(right, int):
            small = abs(left) <= (1 if kind is ast.Pow else 0)
            _require_bits(0 if small else left.bit_length() * right if kind is ast.Pow else left.bit_length() + right)
        return self.weigh(OPERATORS[kind](left, right))

    def _value(self, node: ast.AST, names: Mapping[str, Any]) -> Any:
        self._work.charge(1)
        return _VALUES[type(node)](self, node, names)

    def _name(self, node: ast.Name, names: Mapping[str, Any]) -> Any:
        self._work.charge(getattr(names, "depth", 0) // SCOPES_PER_UNIT)
        try:
            return names[node.id]
        except KeyError:
            raise NameError(f"name {node.id!r} is not defined") from None

    def _item(self, value: Any, name: str) -> Any:
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

    def _subscript(self, node: ast.Subscript, names: Mapping[str, Any]) -> Any:
        value = self._value(node.value, names)
        if isinstance(node.slice, ast.Slice):
            bounds = (node.slice.lower, node.slice.upper, node.slice.step)
            return self.weigh(value[slice(*(bound and self._value(bound, names) for bound in bounds))])
        at = self.weigh(self._value(node.slice, names))
        if isinstance(value, dict) and isinstance(at, str):
            return self._item(value, at)
        return value[at]

    def _call(self, node: ast.Call, names: Mapping[str, Any]) -> Any:
        name = node.func.attr if isinstance(node.func, ast.Attribute) else ""
        owner = self._value(node.func.value if isinstance(node.func, ast.Attribute) else node.func, names)
        own = name in _methods(owner) and not isinstance(owner, self._namespace)
        function = getattr(owner, name) if own else self._item(owner, name) if name else owner
        given = [self._value(argument, names) for argument in node.args]
        named = {str(argument.arg): self._value(argument.value, names) for argument in node.keywords}
        if not own:
            return self.call(function, *given, **named)
        self.weigh([owner, *given, *named.values()])
        if isinstance(owner, str):  # every argument may be sought, or put, at each character
            sizes = sum(len(value) for value in [*given, *named.values()] if isinstance(value, Sized))
            self._work.charge_text((len(owner) + 1) * (sizes + CHARACTERS_PER_UNIT))
        result = function(*given, **named)
        return self.weigh(list(result) if name in ("items", "keys", "values") else result)

    def _compare(self, node: ast.Compare, names: Mapping[str, Any]) -> bool:
        left = self._value(node.left, names)
        for kind, part in zip(node.ops, node.comparators, strict=True):
            right = self._value(part, names)
            for value in (left, right):
                if not callable(value):  # a type may be compared
                    self.weigh(value)
            if not OPERATORS[type(kind)](left, right):
                return False
            left = right
        return True

    def _both(self, node: ast.BoolOp, names: Mapping[str, Any]) -> Any:
        wanted = isinstance(node.op, ast.Or)
        for part in node.values[:-1]:
            value = self._value(part, names)
            if bool(value) is wanted:
                return value
        return self._value(node.values[-1], names)

    def _rounds(self, generators: Sequence[ast.comprehension], names: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
        """The names in each round of a comprehension."""
        if not generators:
            yield names
            return
        for value in self._value(generators[0].iter, names):
            inner = _Scope(_bound(generators[0].target, value), names)
            if all(self._value(test, inner) for test in generators[0].ifs):
                yield from self._rounds(generators[1:], inner)

    def _listed(self, node: Any, names: Mapping[str, Any]) -> list[Any]:
        return [self._value(node.elt, inner) for inner in self._rounds(node.generators, names)]

    def _dictionary(self, node: ast.DictComp, names: Mapping[str, Any]) -> dict[Any, Any]:
        rounds = self._rounds(node.generators, names)
        return {key(self._value(node.key, inner)): self._value(node.value, inner) for inner in rounds}

    def _pairs(self, node: ast.Dict, names: Mapping[str, Any]) -> dict[Any, Any]:
        pairs = zip(node.keys, node.values, strict=True)
        return {key(self._value(one, names)): self._value(other, names) for one, other in pairs if one is not None}

    def _members(self, node: Any, names: Mapping[str, Any]) -> list[Any]:
        return [self._value(member, names) for member in node.elts]


_VALUES: dict[type[ast.AST], Callable[[Expressions, Any, Mapping[str, Any]], Any]] = {
    ast.Constant: lambda self, node, names: node.value,
    ast.Name: Expressions._name,
    ast.Attribute: lambda self, node, names: self._item(self._value(node.value, names), node.attr),
    ast.Subscript: Expressions._subscript,
    ast.Call: Expressions._call,
    ast.BinOp: lambda self, node, names: self.operate(
        type(node.op), self._value(node.left, names), self._value(node.right, names)
    ),
    ast.UnaryOp: lambda self, node, names: OPERATORS[type(node.op)](self._value(node.operand, names)),
    ast.Compare: Expressions._compare,
    ast.BoolOp: Expressions._both,
    ast.IfExp: lambda self, node, names: self._value(
        node.body if self._value(node.test, names) else node.orelse, names
    ),
    ast.List: Expressions._members,
    ast.Tuple: lambda self, node, names: tuple(self._members(node, names)),
    ast.Set: lambda self, node, names: set(map(key, self._members(node, names))),
    ast.Dict: Expressions._pairs,
    ast.ListComp: Expressions._listed,
    ast.GeneratorExp: Expressions._listed,  # which would run later, and hold a frame
    ast.SetComp: lambda self, node, names: set(map(key, self._listed(node, names))),
    ast.DictComp: Expressions._dictionary,
}

_ALLOWED = (*_VALUES, *OPERATORS, ast.And, ast.Or, ast.Load, ast.Store, ast.Slice, ast.keyword, ast.comprehension)


class _Scope(dict[str, Any]):
    """The names of a comprehension, and those around it."""

    def __init__(self, names: dict[str, Any], around: Mapping[str, Any]) -> None:
        super().__init__(names)
        self.depth = getattr(around, "depth", 0)
        self._around = around

    def __missing__(self, name: str) -> Any:
        return self._around[name]


def checked(expression: str) -> ast.expr:
    """The syntax tree. Refused if a part is not allowed, or if it is too deep."""
    if len(expression) > MAX_LENGTH:
        raise Refused(REFUSED, f"an expression of more than {MAX_LENGTH} characters", "split it into properties")
    try:
        tree = ast.parse(expression, mode="eval").body
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
    kind = type(node).__name__
    if type(node) not in _ALLOWED:
        raise Refused(REFUSED, f"{_WORDS.get(kind, kind)} is not allowed", "use names, operators and calls")
    if isinstance(node, ast.Constant) and not isinstance(node.value, (str, int, float, type(None))):
        raise Refused(REFUSED, f"{node.value!r:.40} is not allowed", "use numbers and texts")
    if (isinstance(node, ast.keyword) and node.arg is None) or (isinstance(node, ast.Dict) and None in node.keys):
        raise Refused(REFUSED, "unpacking with ** is not allowed", "write each entry")
    if isinstance(node, ast.Subscript) and any(
        isinstance(part, ast.Slice) for part in ast.iter_child_nodes(node.slice)
    ):
        raise Refused(REFUSED, "a slice of several dimensions is not allowed", "slice once")
    if isinstance(node, ast.comprehension) and node.is_async:
        raise Refused(REFUSED, "async is not allowed", "leave it out")


def key(value: Any) -> Any:
    """A key or a member of a set, which must be a text or a number. Others can be made to share a hash."""
    if not isinstance(value, (str, int, float, type(None))):
        what = f"a {type(value).__name__} as a key or in a set is not allowed"
        raise Refused(REFUSED, what, "use texts and numbers")
    if isinstance(value, int) and value.bit_length() > MAX_KEY_BITS:
        raise Refused(TOO_LARGE, f"a whole number of more than {MAX_KEY_BITS} bits as a key", "use a text")
    return value


def _bound(target: ast.expr, value: Any) -> dict[str, Any]:
    """The names that a round of a comprehension binds to a value or its parts."""
    if isinstance(target, ast.Name):
        return {target.id: value}
    if not isinstance(target, (ast.Tuple, ast.List)):
        raise Refused(REFUSED, "an assignment is not allowed", "expressions compute and change nothing")
    pairs = zip(target.elts, value, strict=True)
    return {name: part for one, other in pairs for name, part in _bound(one, other).items()}


def _methods(value: Any) -> list[str]:
    return next((names for kind, names in METHODS.items() if isinstance(value, kind)), [])


def _require_bits(bits: int) -> None:
    if bits > MAX_BITS:
        raise Refused(TOO_LARGE, f"a whole number of more than {MAX_BITS} bits", "use a float")
