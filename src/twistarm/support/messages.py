"""Messages as data: texts that keep the quantities and arguments in them, for readers with other words.

A `Text` is a string in the words of Python, with SI units: `joint 'elbow' at 0.5 rad; pass tip='wrist'`. Its values
stay with it. So the command line writes `28.648°` and `--tip wrist` without a look at the sentence.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any


@dataclass(frozen=True)
class Quantity:
    """A value with its unit, in SI: `0.5 rad`, `2 m/s²`. `digits` are those that help the reader."""

    value: float
    unit: str
    digits: int = 6

    def __str__(self) -> str:
        return f"{self.value:.{self.digits}g} {self.unit}"

    def in_degrees(self) -> str:
        """`28.648°`, `2 m/s²`. Of a turn five digits, as no joint is known better."""
        if self.unit[:3] != "rad":
            return str(self)
        return f"{math.degrees(self.value):.{min(self.digits, 5)}g}°{self.unit[3:]}"


@dataclass(frozen=True)
class Posture:
    """Joint values with the unit, rad or m, of each: `[0.1 rad, 0.2 m]`."""

    theta: tuple[float, ...]
    units: tuple[str, ...]

    def __str__(self) -> str:
        return f"[{', '.join(map(str, self.quantities()))}]"

    def in_degrees(self) -> str:
        """`[5.73°, 0.2 m]`."""
        return f"[{', '.join(value.in_degrees() for value in self.quantities())}]"

    def quantities(self) -> list[Quantity]:
        """The value of each joint."""
        return [Quantity(value, unit, 4) for value, unit in zip(self.theta, self.units, strict=True)]


@dataclass(frozen=True)
class Argument:
    """An argument of a call: `tip='wrist'`, `env_vars=['HOME']`.

    The value is a text, a list of texts, a mapping, True or a `Quantity`. It is an ellipsis, `tip=...`, where only the
    caller knows it, and None, `tip=`, where the argument itself is meant.
    """

    name: str
    value: Any = ...

    def __str__(self) -> str:
        return f"{self.name}={'' if self.value is None else _literal(self.value)}"


Value = Quantity | Posture | Argument


@dataclass(frozen=True)
class Remedies:
    """What a reader may do, each remedy a phrase: `another goal, or a larger tol=...`.

    A renderer leaves out remedies with arguments that its reader cannot set.
    """

    phrases: tuple[str, ...]

    def __str__(self) -> str:
        return either(self.phrases)


class Text(str):
    """A message: a template with named values, as in `str.format`. It is the string that Python shows.

    A value may be a `Quantity`, a `Posture`, an `Argument`, another Text, or anything else. Names from a file belong
    into values, never into the template.
    """

    template: str
    values: Mapping[str, Any]

    def __new__(cls, template: str, /, **values: Any) -> Text:
        """The string with every value in its Python form."""
        text = super().__new__(cls, template.format(**values))
        text.template, text.values = template, values
        return text

    def __reduce__(self) -> tuple[Callable[[], Text], tuple[()]]:
        return partial(Text, self.template, **self.values), ()


def rendered(message: Any, write: Callable[[Value], str], settable: Callable[[str], bool] = lambda name: True) -> Any:
    """A `Text` with every quantity, posture and argument as `write` gives it; anything else stays.

    Remedies with arguments that are not `settable` are left out.
    """
    if isinstance(message, Value):
        return write(message)
    if isinstance(message, Remedies):
        phrases = [phrase for phrase in message.phrases if all(map(settable, _arguments(phrase)))]
        return either([rendered(phrase, write, settable) for phrase in phrases])
    if not isinstance(message, Text):
        return message
    values = {name: rendered(value, write, settable) for name, value in message.values.items()}
    return message.template.format(**values)


def _arguments(message: Any) -> Iterator[str]:
    """The names of the arguments in a message."""
    if isinstance(message, Argument):
        yield message.name
    elif isinstance(message, Text):
        for value in message.values.values():
            yield from _arguments(value)


def either(phrases: Sequence[str]) -> str:
    """`a`, `a or b`, `a, b, or c`."""
    if len(phrases) < 3:
        return " or ".join(phrases)
    return f"{', '.join(phrases[:-1])}, or {phrases[-1]}"


def joined(separator: str, messages: Iterable[str | Value]) -> str:
    """Messages and values in one, as by `str.join`."""
    values = {f"m{i}": message for i, message in enumerate(messages)}
    return Text(separator.replace("{", "{{").replace("}", "}}").join(f"{{{name}}}" for name in values), **values)


def package_folder(held: str) -> str:
    """The argument for a package folder that holds `held`."""
    return Text("{option} (the folder that holds {held})", option=Argument("package_dirs", [...]), held=held)


def first_of(words: Sequence[str], count: int) -> str:
    """`a, b and 3 more`: the first words, and the number of the others."""
    more = f" and {len(words) - count} more" if len(words) > count else ""
    return ", ".join(words[:count]) + more


def plural(count: int, noun: str, nouns: str = "") -> str:
    """`1 joint`, `2 joints`, `3 axes`."""
    return f"{count} {noun if count == 1 else nouns or noun + 's'}"


def _literal(value: Any) -> str:
    if value is ...:
        return "..."
    if isinstance(value, Quantity):
        return f"{value.value:.{value.digits}g}"
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key!r}: {_literal(entry)}' for key, entry in value.items())}}}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return f"[{', '.join(map(_literal, value))}]"
    return repr(value)
