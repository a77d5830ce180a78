"""Numbers as formulae."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...support.errors import InputError


def tex(value: ArrayLike, digits: int = 3) -> str:
    """A number, a vector (in a line) or a matrix in TeX, to put between dollars.

    Args:
        value: A number, a vector (n,) or a matrix (m, n).
        digits: After the point; an infinite number is ∞.

    Returns:
        TeX.
    """
    array = np.asarray(value, float)
    if array.ndim > 2:
        raise InputError(f"tex takes a number, a vector or a matrix; got shape {array.shape}")
    if array.ndim == 0:
        return _number(float(array), digits)
    if array.ndim == 1:
        return f"({', '.join(_number(float(x), digits) for x in array)})"
    lines = r" \\ ".join(" & ".join(_number(float(x), digits) for x in row) for row in array)
    return rf"\begin{{bmatrix}} {lines} \end{{bmatrix}}"


def _number(value: float, digits: int) -> str:
    if np.isinf(value):
        return r"\infty" if value > 0 else r"-\infty"
    return f"{round(value, digits) + 0.0:.{digits}f}"


def rough(value: float | np.floating[Any]) -> str:
    r"""A size in TeX by its first digit and power of ten: `2 \cdot 10^{-16}`, for rounding errors.

    Below 1e-20 it is 0.
    """
    if -1e-20 < value < 1e-20 or not np.isfinite(value):
        return _number(float(value), 0)
    digit, _, power = f"{value:.0e}".partition("e")
    return rf"{digit} \cdot 10^{{{int(power)}}}"
