"""Displays of objects: short lines at a prompt."""

from __future__ import annotations

import math
from dataclasses import fields
from enum import Enum
from typing import Any

import numpy as np

from .errors import quote

LONGEST_ROW = 8  # A longer row of numbers shows its shape alone.
ZERO = 1e-12  # Smaller numbers are the rounding of a zero.


class Brief:
    """A dataclass with a short repr: four digits, and shapes for large arrays."""

    def __repr__(self) -> str:
        named = {field.name: getattr(self, field.name) for field in fields(self) if field.repr}  # type: ignore[arg-type]
        return short_repr(type(self).__name__, named)


def short_repr(kind: str, named: dict[str, Any]) -> str:
    """`Position(p=[1, 0, 0.5])`: an object by its kind and what it holds."""
    return f"{kind}({', '.join(f'{name}={in_brief(value)}' for name, value in named.items())})"


def in_brief(value: Any) -> str:
    """A value in a few characters."""
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, (float, np.floating)):
        return _number(float(value), ZERO)
    if isinstance(value, np.ndarray):
        return _array(value) if value.ndim else in_brief(value.item())
    if isinstance(value, (list, tuple)):
        more = [f"… {len(value)} in all"] if len(value) > LONGEST_ROW else []
        texts = [entry if isinstance(entry, str) else in_brief(entry) for entry in value[:LONGEST_ROW]]
        return f"[{', '.join([*texts, *more])}]"
    return repr(value) if isinstance(value, Brief) else quote(value)


def _array(array: np.ndarray[Any, Any]) -> str:
    if array.shape == (4, 4):
        angle = math.degrees(math.acos(min(max((float(np.trace(array)) - 2.0) / 2.0, -1.0), 1.0)))
        return f"at {_array(array[:3, 3])} turned {angle:.4g}°"
    if array.ndim == 1 and len(array) <= LONGEST_ROW and array.dtype.kind in "iuf":
        # What is far below the four digits of the largest is the rounding of a zero too.
        zero = max(ZERO, 1e-6 * float(np.abs(array[np.isfinite(array)]).max(initial=0.0)))
        return f"[{', '.join(_number(value, zero) for value in array.tolist())}]"
    return f"array of shape {array.shape}"


def _number(value: float, zero: float) -> str:
    return "0" if abs(value) < zero else f"{value:.4g}"
