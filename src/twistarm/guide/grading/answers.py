"""Answers as the grader compares them: their form, a shape or the forms of their parts, and their numbers in a row."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...support.checks import Array
from ...support.errors import one_line

Form = Any
"""The shape of a number, () , or of an array; a tuple ("parts", form, …) of several; a text for what is neither."""

UNDEFINED = ("ValueError", "ZeroDivisionError", "FloatingPointError", "OverflowError")
"""Errors of functions such as math.acos where NumPy's give NaN or infinity: the same slip shows as either."""


@dataclass(frozen=True)
class Answer:
    """One answer: its value (a number, an array, a list of values, None), its form and its numbers.

    `error` is what was raised in its place, as the worker tells it; `changed` are the arguments that were changed.
    """

    value: Any = None
    error: Mapping[str, Any] | None = None
    changed: tuple[int, ...] = ()
    strange: str = ""

    @property
    def form(self) -> Form:
        """A shape, forms of parts, or a text."""
        if self.error is not None:
            return "error"
        return self.strange or form_of(self.value)

    @property
    def numbers(self) -> Array:
        """Every number of it, in a row."""
        return flat(self.value)

    @property
    def undefined(self) -> bool:
        """Whether it is no number, or an error that says so."""
        if self.error is not None:
            return self.error["type"] in UNDEFINED
        return not self.strange and not bool(np.isfinite(self.numbers).all())


def plain(value: Any) -> Any:
    """A value with every list or tuple of equal parts made an array, as deep as it goes."""
    if isinstance(value, (list, tuple)):
        parts = [plain(each) for each in value]
        if parts and all(not isinstance(each, list) and each is not None for each in parts):
            shapes = {np.shape(each) for each in parts}
            if len(shapes) == 1:
                return np.array(parts, float)
        return parts
    if isinstance(value, np.ndarray):
        return np.asarray(value, float)
    return None if value is None else float(value)


def form_of(value: Any) -> Form:
    """The form of a value that is plain."""
    if value is None:
        return "None"
    if isinstance(value, list):
        return ("parts", *(form_of(each) for each in value))
    return np.shape(value)


def flat(value: Any) -> Array:
    """The numbers of a value that is plain."""
    if value is None:
        return np.zeros(0)
    if isinstance(value, list):
        return np.concatenate([flat(each) for each in value]) if value else np.zeros(0)
    return np.ravel(np.asarray(value, float))


def in_words(form: Form) -> str:
    """A form as a sentence has it."""
    if isinstance(form, str):
        return "nothing (None)" if form == "None" else form
    if form and form[0] == "parts":
        return f"{len(form) - 1} values ({', '.join(map(in_words, form[1:]))})"
    return "one number" if form == () else f"an array of shape {tuple(form)}"


def of_worker(told: Any) -> Answer:
    """The answer that the worker encoded; something strange where it is none."""
    if not isinstance(told, Mapping):
        return Answer(strange="what cannot be read")
    changed = tuple(told.get("changed", ()))
    if "error" in told:
        return Answer(error=told["error"], changed=changed)
    try:
        return Answer(plain(_decoded(told)), changed=changed)
    except (TypeError, ValueError, KeyError) as error:
        return Answer(strange=one_line(str(error), 100), changed=changed)


def of_function(function: Any, arguments: tuple[Any, ...]) -> Answer:
    """The answer of a function of our own; its errors are answers too."""
    given = tuple(each.copy() if isinstance(each, np.ndarray) else each for each in arguments)
    try:
        with np.errstate(all="ignore"):
            return Answer(plain(function(*given)))
    except Exception as error:  # a wrong function may raise anything
        return Answer(error={"type": type(error).__name__, "text": str(error), "line": 0})


def _decoded(told: Mapping[str, Any]) -> Any:
    if "none" in told:
        return None
    if "number" in told:
        return float(told["number"])
    if "array" in told:
        return np.array(told["array"], float).reshape(told["shape"])
    if "items" in told:
        return [_decoded(each) for each in told["items"]]
    if "large" in told:
        raise ValueError(f"a very large array of shape {tuple(told['large'])}")
    raise ValueError(f"a value of type {told['other']}")
