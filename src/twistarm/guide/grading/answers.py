"""Answers in the grader's form: a shape or the parts' forms, and all numbers in a row."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from traceback import walk_tb
from typing import Any

import numpy as np

from ...support.checks import Array

# The shape of a number, () , or of an array; a tuple ("parts", form, …) of several; a text for what is neither.
Form = Any
# Errors of functions such as math.acos. NumPy gives NaN or infinity instead, so the same slip shows as either.
UNDEFINED = ("ValueError", "ZeroDivisionError", "FloatingPointError", "OverflowError")
LARGEST = 10_000  # The most numbers of an answer. A larger one is described by its shape.


@dataclass(frozen=True)
class Failure:
    """An error of a function or a file: type, text, and the last line of the reader's file.

    `module` is the module that could not be imported. `signature` is that of a function with the wrong arguments.
    """

    kind: str
    text: str = ""
    line: int = 0
    module: str = ""
    signature: str = ""

    @classmethod
    def of(cls, error: BaseException, file: str, function: Any = None, given: int = 0) -> Failure:
        """The failure that an error means. `file` is the name that the reader's code was compiled under."""
        lines = [line for frame, line in walk_tb(error.__traceback__) if frame.f_code.co_filename == file]
        module = error.name or "" if isinstance(error, ModuleNotFoundError) else ""
        signature = ""
        if function is not None and isinstance(error, TypeError):
            try:
                inspect.signature(function).bind(*[None] * given)
            except TypeError:
                signature = str(inspect.signature(function))[:200]
            except ValueError:  # a class of C has none
                pass
        return cls(type(error).__name__, str(error)[:300], lines[-1] if lines else 0, module, signature)


@dataclass(frozen=True)
class ReturnValue:
    """One answer: its value (a number, an array, a list, None), its form and its numbers.

    `error` is the error instead of a value. `changed` are the arguments that the function changed. `strange` describes
    a result that is no value.
    """

    value: Any = None
    error: Failure | None = None
    changed: tuple[int, ...] = ()
    strange: str = ""

    @property
    def form(self) -> Form:
        """A shape, forms of parts, or a text."""
        return "error" if self.error is not None else self.strange or form_of(self.value)

    @property
    def numbers(self) -> Array:
        """Every number of it, in a row."""
        return flat(self.value)

    @property
    def undefined(self) -> bool:
        """Whether it is no number, or an error that says so."""
        if self.error is not None:
            return self.error.kind in UNDEFINED
        return not self.strange and not bool(np.isfinite(self.numbers).all())


def of_function(function: Callable[..., Any], arguments: tuple[Any, ...], file: str = "") -> ReturnValue:
    """The answer of a function. An error is an answer too, with its line in `file`, the reader's file."""
    given = [argument.copy() if isinstance(argument, np.ndarray) else argument for argument in arguments]
    value, error, strange = None, None, ""
    try:
        with np.errstate(all="ignore"):
            value = function(*given)
    except BaseException as raised:  # a reader's function may raise anything
        if not file and not isinstance(raised, Exception):
            raise
        error = Failure.of(raised, file, function, len(given))
    try:
        value = plain(value)
    except TypeError as what:
        value, strange = None, str(what)
    changed = tuple(i for i, (now, before) in enumerate(zip(given, arguments, strict=True)) if not _same(now, before))
    return ReturnValue(value, error, changed, strange)


def _same(first: Any, second: Any) -> bool:
    return bool(np.array_equal(first, second, equal_nan=isinstance(first, np.ndarray)))


def plain(value: Any, depth: int = 0) -> Any:
    """A value with each list or tuple of equal parts made an array. TypeError for anything that has no numbers."""
    if value is None:
        return None
    if isinstance(value, (int, float, np.integer, np.floating, np.bool_)):
        try:
            return float(value)
        except OverflowError:
            return float("inf")
    if isinstance(value, np.ndarray):
        if value.dtype.kind not in "biuf":
            raise TypeError(f"a value of type array of {value.dtype}")
        return np.array(_bounded(value, value.shape), float)
    # A list may contain itself, and no answer is nested more deeply.
    if isinstance(value, (list, tuple)) and depth < 5:
        parts = [plain(part, depth + 1) for part in _bounded(value, (len(value),))]
        alike = parts and not any(part is None or isinstance(part, list) for part in parts)
        return np.array(parts, float) if alike and len(set(map(np.shape, parts))) == 1 else parts
    raise TypeError(f"a value of type {type(value).__name__}")


def _bounded(value: Any, shape: tuple[int, ...]) -> Any:
    if np.prod(shape) > LARGEST:
        raise TypeError(f"a very large array of shape {shape}")
    return value


def form_of(value: Any) -> Form:
    """The form of a value that is plain."""
    if value is None:
        return "None"
    return ("parts", *map(form_of, value)) if isinstance(value, list) else np.shape(value)


def flat(value: Any) -> Array:
    """The numbers of a value that is plain."""
    if value is None:
        return np.zeros(0)
    if isinstance(value, list):
        return np.concatenate([np.zeros(0), *map(flat, value)])
    return np.ravel(np.asarray(value, float))


def in_words(form: Form) -> str:
    """A form as a sentence has it."""
    if isinstance(form, str):
        return "nothing (None)" if form == "None" else form
    if form and form[0] == "parts":
        return f"{len(form) - 1} values ({', '.join(map(in_words, form[1:]))})"
    return "one number" if form == () else f"an array of shape {tuple(form)}"
