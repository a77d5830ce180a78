"""Messages as data: texts that keep the quantities and arguments in them, for readers with other words.

A `Text` is a string in the words of Python, with SI units: `joint 'elbow' at 0.5 rad; pass tip='wrist'`. Its values
stay with it, so that the command line can write `28.648°` and `--tip wrist` without a look at the sentence.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import EllipsisType
from typing import Any


@dataclass(frozen=True)
class Quantity:
    """A value with its unit, in SI: `0.5 rad`, `2 m/s²`. `digits` are those that help the reader."""

    value: float
    unit: str
    digits: int = 6

    def __str__(self) -> str:
        return f"{self.value:.{self.digits}g} {self.unit}"


@dataclass(frozen=True)
class Posture:
    """Joint values with the unit, rad or m, of each: `[0.1 rad, 0.2 m]`."""

    theta: tuple[float, ...]
    units: tuple[str, ...]

    def __str__(self) -> str:
        return f"[{', '.join(f'{value:.4g} {unit}' for value, unit in zip(self.theta, self.units, strict=True))}]"


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


def rendered(message: Any, write: Callable[[Value], str]) -> Any:
    """A `Text` with every quantity, posture and argument as `write` gives it; anything else stays."""
    if isinstance(message, Value):
        return write(message)
    if not isinstance(message, Text):
        return message
    return message.template.format(**{name: rendered(value, write) for name, value in message.values.items()})


def joined(separator: str, messages: Iterable[str | Value]) -> str:
    """Messages and values in one, as by `str.join`."""
    values = {f"m{i}": message for i, message in enumerate(messages)}
    return Text(separator.replace("{", "{{").replace("}", "}}").join(f"{{{name}}}" for name in values), **values)


def package_folder(held: str) -> str:
    """The argument for a package folder that holds `held`."""
    return Text("{option} (the folder that holds {held})", option=Argument("package_dirs", [...]), held=held)


def plural(count: int, noun: str, nouns: str = "") -> str:
    """`1 joint`, `2 joints`, `3 axes`."""
    return f"{count} {noun if count == 1 else nouns or noun + 's'}"


def _literal(value: Any) -> str:
    if isinstance(value, EllipsisType):
        return "..."
    if isinstance(value, Quantity):
        return f"{value.value:.{value.digits}g}"
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key!r}: {_literal(entry)}' for key, entry in value.items())}}}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return f"[{', '.join(map(_literal, value))}]"
    return repr(value)
