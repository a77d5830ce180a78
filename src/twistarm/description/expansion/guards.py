"""Guards of checked expressions: every operator, attribute, method and call passes here and is counted."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterable, Sized
from dataclasses import dataclass
from datetime import date
from typing import Any

from .work import CHARACTERS_PER_UNIT, MAX_BITS, Refused, Work

REFUSED = "xacro-expression-refused"

_DATA = (str, int, float, type(None), list, tuple, dict, set, range, date)
"""A date stands in many a YAML file."""

_OF_TEXT = """
    capitalize count endswith find index isalnum isalpha isdigit islower isspace isupper join lower lstrip partition
    removeprefix removesuffix replace rsplit rstrip split startswith strip title upper
"""
_METHODS = {
    str: _OF_TEXT,
    list: "copy count index",
    tuple: "count index",
    dict: "copy get items keys values",
    float: "is_integer",
}
METHODS: dict[type, frozenset[str]] = {kind: frozenset(names.split()) for kind, names in _METHODS.items()}
"""The methods that an expression may call: none that changes its object, nor `format`, which reaches attributes."""

OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "Add": operator.add,
    "Sub": operator.sub,
    "Mult": operator.mul,
    "Div": operator.truediv,
    "FloorDiv": operator.floordiv,
    "Mod": operator.mod,
    "Pow": operator.pow,
    "LShift": operator.lshift,
    "RShift": operator.rshift,
    "BitOr": operator.or_,
    "BitAnd": operator.and_,
    "BitXor": operator.xor,
    "In": lambda left, right: left in right,
    "NotIn": lambda left, right: left not in right,
}

_FIELD = re.compile(r"%[-+ #0]*(\d*)(?:\.(\d*))?(.?)", re.DOTALL)
"""Width, precision and kind of a field in `text % values`; none is named, for %(name)s would multiply a value."""

MAX_FIELD = 999


@dataclass
class Guards:
    """`namespace`: the type whose dots mean items.

    What can be called is what the names offer and the types of data (`names`): no expression reaches another.
    """

    work: Work
    namespace: Any

    def operate(self, name: str, left: Any, right: Any) -> Any:
        """`left` operator `right`, refused where the result would be huge."""
        self.work.weigh(left)
        self.work.weigh(right)
        self._foresee(name, left, right)
        if isinstance(left, str):
            self.data(right)
        return self.work.weigh(OPERATORS[name](left, right))

    def _foresee(self, name: str, left: Any, right: Any) -> None:
        """Charge what an operator would make, before it does."""
        whole = isinstance(left, int) and isinstance(right, int)
        if name == "Mult":
            for value, times in ((left, right), (right, left)):
                if isinstance(value, Sized) and isinstance(times, int):
                    unit = CHARACTERS_PER_UNIT if isinstance(value, str) else 1
                    self.work.charge(len(value) * max(0, times) // unit)
        elif name == "Mod" and isinstance(left, str):
            self.work.charge_text(_widths(left))
        elif name in ("In", "NotIn") and isinstance(left, str) and isinstance(right, str):
            self.work.charge_text(len(left) * len(right))
        elif whole and _bits(name, left, right) > MAX_BITS:
            raise Refused("xacro-too-large", f"a whole number of more than {MAX_BITS} bits", "use a float")

    def attribute(self, value: Any, name: str) -> Any:
        """`value.name`: an item of a namespace or of a dictionary with dots; nothing else has attributes here."""
        if isinstance(value, self.namespace):
            try:
                return value[name]
            except KeyError:
                raise NameError(f"name {name!r} is not defined") from None
        if isinstance(value, dict) and type(value) is not dict:
            return value[name]
        what = f"the attribute .{name} of a {type(value).__name__} is not allowed"
        raise Refused(REFUSED, what, "only namespaces, loaded YAML and the usual methods have dots")

    def method(self, value: Any, name: str, /, *arguments: Any, **named: Any) -> Any:
        """`value.name(...)`: a method of the table, or a function in a namespace."""
        kind = next((kind for kind in METHODS if isinstance(value, kind)), None)
        if isinstance(value, self.namespace) or kind is None or name not in METHODS[kind]:
            return self.call(self._function(value, name), *arguments, **named)
        given = [*arguments, *named.values()]
        self.work.weigh([value, *given])
        self.data(given)
        if isinstance(value, str):
            self._foresee_text(value, given)
        result = getattr(value, name)(*arguments, **named)
        # Views of a dictionary combine to sets, whose members would be tuples.
        return self.work.weigh(list(result) if name in ("items", "keys", "values") else result)

    def _function(self, value: Any, name: str) -> Any:
        if isinstance(value, dict):
            return self.attribute(value, name)
        what = f"the method .{name}() of a {type(value).__name__} is not allowed"
        kind = next((kind for kind in METHODS if isinstance(value, kind)), None)
        remedy = f"allowed: {', '.join(sorted(METHODS[kind]))}" if kind else "compute with names and operators"
        raise Refused(REFUSED, what, "join texts with + and str()" if name.startswith("format") else remedy)

    def _foresee_text(self, text: str, given: Iterable[Any]) -> None:
        """Charge the pieces it may be cut into, and every argument sought, or put, at each character."""
        self.work.charge(len(text))
        self.work.charge_text(sum((len(text) + 1) * len(value) for value in given if isinstance(value, Sized)))

    def call(self, function: Any, /, *arguments: Any, **named: Any) -> Any:
        """`function(...)` with what it looks through paid for before."""
        if not callable(function):
            raise TypeError(f"{type(function).__name__!r} object is not callable")
        if "key" in named and function is not dict:
            raise Refused(REFUSED, "key= is not allowed", "sort or compare numbers and texts as they are")
        given = [*arguments, *named.values()]
        self.work.weigh(given)
        for argument in given:
            if isinstance(argument, Sized):
                self.work.charge(len(argument) * (len(argument).bit_length() if function is sorted else 1))
        for argument in arguments:
            _check_hashed(function, argument)
        if function in (str, repr):
            self.data(given)
        return self.work.weigh(function(*arguments, **named))

    def data(self, value: Any) -> Any:
        """The value, which may become text: numbers, texts, truth values, None, and what is made up of them.

        Refused otherwise: the text of a function or a type tells about the program, its place in memory too. To be
        weighed before, for shared parts are looked at each time.
        """
        stack = [value]
        while stack:
            part = stack.pop()
            if isinstance(part, self.namespace) or not isinstance(part, _DATA):
                kind = "namespace" if isinstance(part, self.namespace) else "function" if callable(part) else ""
                raise Refused(
                    REFUSED,
                    f"a {kind or type(part).__name__} is no value, nor text",
                    "call it, or name what stands in it",
                )
            if isinstance(part, dict):
                stack += [*dict.keys(part), *dict.values(part)]
            elif isinstance(part, (list, tuple, set)):
                stack += list.__iter__(part) if isinstance(part, list) else part
        return value

    def iterate(self, values: Any, cost: int) -> Any:
        """What a comprehension runs over, charged beforehand; `cost`: of one round."""
        self.work.weigh(values)
        if isinstance(values, Sized):
            self.work.charge(len(values) * cost)
        return values


def key(value: Any) -> Any:
    """A member of a set or a key: a text or a number. Of tuples and ranges any number can be made to share a hash."""
    if not isinstance(value, (str, int, float, type(None))):
        what = f"a {type(value).__name__} as a key or in a set is not allowed"
        raise Refused(REFUSED, what, "use texts and numbers")
    return value


def _check_hashed(function: Any, argument: Any) -> None:
    """Refused where a function would put something else into a set, or might into a dictionary."""
    if function is set and isinstance(argument, (list, tuple)):
        for member in argument:
            key(member)
    if isinstance(function, type) and issubclass(function, dict) and not isinstance(argument, dict):
        raise Refused(REFUSED, "a dict() of pairs is not allowed", "write {key: value for key, value in pairs}")


def _widths(template: str) -> int:
    """How many characters the fields of `template % values` ask for."""
    total = 0
    for width, precision, kind in _FIELD.findall(template):
        if not (kind == "%" or kind.isalpha()):
            raise Refused(
                REFUSED, f"a field of a text with {kind!a} is not allowed", "write fields such as %s and %.3f"
            )
        if max(len(width), len(precision)) > len(str(MAX_FIELD)):
            what = f"a field of a text wider than {MAX_FIELD} is not allowed"
            raise Refused(REFUSED, what, "write its width in digits")
        total += int(width or 0) + int(precision or 0)
    return total


def _bits(name: str, left: int, right: int) -> int:
    """About how many bits a power or a shift has."""
    if name == "Pow":
        return abs(left).bit_length() * right if abs(left) > 1 else 0
    return left.bit_length() + right if name == "LShift" and left else 0
