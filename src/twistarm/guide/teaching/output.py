"""The outputs of a lesson, one function for each kind. They go to a page, a notebook, or standard output."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from inspect import cleandoc
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm
from ...planning.trajectory import Trajectory
from ...support.errors import InputError, listed
from . import html

SLIDERS: dict[str, dict[str, Any]] = {
    "frame": {"order": "ZYZ", "alpha": 30, "beta": 50, "gamma": 20},
    "axis_angle": {"axis": (1, 1, 1), "angle": 120},
    "twist": {"axis": (0, 0, 1), "point": (0.5, 0, 0), "pitch": 0.1, "angle": 90},
    "joint": {"type": "cylindrical"},
    "two_link": {"l1": 0.4, "l2": 0.3, "theta1": 30, "theta2": 60, "inverse": True},
    "spline": {"kind": "cubic", "start": 0, "end": 90, "duration": 2, "velocity_start": 0, "velocity_end": 0},
    "ellipsoid": {"l1": 0.4, "l2": 0.3, "theta1": 30, "theta2": 60},
}
"""The sliders by name, and the numbers with which each begins: angles in degrees, lengths in metres, time in s."""


ROUNDING = 1e-9  # Smaller entries in a table of coordinates are rounding and shown as 0.


@dataclass(frozen=True)
class Shown:
    """An output of a lesson, as text for a terminal and as HTML.

    `html(folder)` writes its files into the folder, or embeds them without one.
    """

    plain: str
    html: Callable[[Path | None], str]


Outlet = Callable[[Shown], None]
_INSTALLED: list[Outlet] = []  # The last one takes what is shown.


@contextmanager
def installed(outlet: Outlet) -> Iterator[None]:
    """Meanwhile, what lessons show goes to `outlet`."""
    _INSTALLED.append(outlet)
    try:
        yield
    finally:
        _INSTALLED.remove(outlet)


def show(plain: str, as_html: Callable[[Path | None], str]) -> None:
    """Show it where the lesson runs."""
    ipython = sys.modules.get("IPython")
    shell = ipython and ipython.get_ipython()
    if _INSTALLED:
        _INSTALLED[-1](Shown(plain, as_html))
    elif shell is not None and hasattr(shell, "kernel"):  # a notebook; a terminal's IPython has no kernel
        from IPython.display import HTML, display

        display(HTML(as_html(None)))  # type: ignore[no-untyped-call]
    else:
        sys.stdout.write(plain.rstrip() + "\n")


def say(markdown: str) -> None:
    """Show text of the lesson, markdown with formulae between dollars.

    Indented text of several lines is taken as if it began at the margin.
    """
    words = cleandoc(markdown)
    show(words, lambda _: html.text(words))


def table(head: Sequence[str], rows: Sequence[Sequence[object]], caption: str = "") -> None:
    """Show a table.

    Cells are markdown; other objects than floats are shown as text.

    A float has four digits. A smaller one has its first digit and a power of ten. Rounding errors are 0. To show
    rounding errors, use `rough`.

    Args:
        head: Titles of the columns.
        rows: As many cells in each row.
        caption: What the table says, in a sentence.
    """
    lines = [[_cell(cell) for cell in row] for row in rows]
    if any(len(line) != len(head) for line in lines):
        raise InputError(f"each row of a table has as many cells as its head, {len(head)}")
    widths = [max(map(len, column)) for column in zip(head, *lines, strict=True)]
    text = ["  ".join(map(str.rjust, line, widths)) for line in (head, *lines)]
    show("\n".join([caption, *text] if caption else text), lambda _: html.table(head, lines, caption))


def figure(fig: Any, alt: str, caption: str = "") -> None:
    """Show a figure of matplotlib.

    Args:
        fig: The figure, as `axes2` and `axes3` make them.
        alt: What the figure shows, in words, for readers who do not see it.
        caption: What the figure says, markdown.
    """
    if not alt.strip():
        raise InputError("a figure needs alt, its words for a reader who does not see it")
    show(f"[figure] {alt}", lambda _: html.figure(fig, alt, caption))


def scene(
    arm: Arm,
    theta: ArrayLike | None = None,
    trajectory: Trajectory | None = None,
    caption: str = "",
    quantity: str = "screws",
) -> None:
    """Show a saved page of the view. The reader moves the arm by its tool, links and joints.

    Args:
        arm: The arm.
        theta: Where it stands, (n,) [rad, m]; ready where not given.
        trajectory: A motion that the page plays.
        caption: What there is to see or do, markdown.
        quantity: What is shown as it moves: "joints", "screws", "ellipsoid", "singular" or "configurations". Ellipsoid
            is that of manipulability, singular the lost direction, configurations all with the tool in its pose.
    """
    if quantity not in html.SCENES:
        raise InputError(f"a scene shows {listed(html.SCENES)}; got {quantity!r}")
    x = np.asarray(arm.ready if theta is None else theta, float)
    alt = f"{arm.name}, an arm of {arm.n} joints, to be turned and moved"
    show(f"[scene] {alt}", lambda folder: html.scene(arm, x, trajectory, caption, quantity, alt, folder))


def slider(name: str, question: str, answer: str, **numbers: Any) -> None:
    """Show a slider with a question that it answers.

    Args:
        name: A name of `SLIDERS`.
        question: What the reader is to find out by moving it, markdown.
        answer: The answer, markdown; it stands behind a fold.
        numbers: Where it begins; angles in degrees, as the page shows them, lengths in metres.
    """
    if name not in SLIDERS:
        raise InputError(f"there is no slider {name!r}; there are {listed(SLIDERS)}")
    if unknown := set(numbers) - set(SLIDERS[name]):
        raise InputError(f"the slider {name!r} takes {listed(SLIDERS[name])}; got {listed(sorted(unknown))}")
    all_numbers = {**SLIDERS[name], **numbers}
    show(f"Question: {question}\nAnswer: {answer}", lambda _: html.slider(name, question, answer, all_numbers))


def predict(question: str, answer: str) -> None:
    """Ask the reader a question before the lesson answers it. Question and folded answer are markdown."""
    show(f"Question: {question}\nAnswer: {answer}", lambda _: html.prediction(question, answer))


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


def _cell(value: object) -> str:
    if not isinstance(value, (float, np.floating)):
        return str(value)
    number = float(value)
    if ROUNDING < abs(number) < 0.5e-4:
        return f"${rough(number)}$"
    return f"{number + 0.0:.4f}".replace("-0.0000", "0.0000").replace("-", "−")
