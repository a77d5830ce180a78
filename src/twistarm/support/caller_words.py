"""The caller's words: how messages name arguments and give angles, to a program or to a person at a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any


class Placeholder(str):
    """A value that only the caller knows, as it is described to them; empty: any."""


ANY = Placeholder()


class CallerWords:
    """The words of a Python program: arguments as a call has them, angles in radians."""

    takes_radians = True

    def name(self, argument: str) -> str:
        """An argument alone: `tip=`."""
        return f"{argument}="

    def argument(self, argument: str, value: Any) -> str:
        """An argument with its value, or with placeholders in it: `tip='wrist'`, `env=[NAME]`."""
        return f"{argument}={_literal(value)}"

    def expression(self, python: str) -> str:
        """Where else an answer is found, said in Python: `arm.frame_names`."""
        return python

    def quantity(self, value: float, unit: str) -> str:
        """A value with its unit."""
        return f"{value:.6g} {unit}"

    def posture(self, theta: Sequence[float], units: Sequence[str]) -> str:
        """Joint values, as they would be given back."""
        return f"[{', '.join(f'{value:.4g}' for value in theta)}]"


_words = CallerWords()


@contextmanager
def speaking(words: CallerWords) -> Iterator[None]:
    """Within, messages are made in these words, in every thread: there is one caller."""
    global _words
    before, _words = _words, words
    try:
        yield
    finally:
        _words = before


def name_of(name: str) -> str:
    """An argument alone, in the caller's words."""
    return _words.name(name)


def argument(name: str, value: Any = ANY) -> str:
    """An argument with its value, in the caller's words."""
    return _words.argument(name, value)


def package_folder(held: str) -> str:
    """The argument that names a folder in which packages are looked for, one that holds `held`."""
    return argument("package_dirs", [Placeholder(f"folder that holds {held}")])


def expression(python: str) -> str:
    """Where else an answer is found, in the caller's words."""
    return _words.expression(python)


def quantity(value: float, unit: str) -> str:
    """A value with its unit, in the caller's words."""
    return _words.quantity(value, unit)


def posture(theta: Sequence[float], units: Sequence[str]) -> str:
    """Joint values in the caller's words, as they would be given back."""
    return _words.posture(theta, units)


def takes_radians() -> bool:
    """Whether the caller gives angles in radians."""
    return _words.takes_radians


def _literal(value: Any) -> str:
    if isinstance(value, Placeholder):
        return str(value)
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key!r}: {_literal(each)}' for key, each in value.items())}}}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return f"[{', '.join(map(_literal, value))}]"
    return repr(value)
