"""The outlet of a lesson: a page, a notebook, or text on standard output."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Shown:
    """An output of a lesson, as text for a terminal and as HTML.

    `html(folder)` writes its files into the folder, or embeds them without one.
    """

    plain: str
    html: Callable[[Path | None], str]


Outlet = Callable[[Shown], None]

_INSTALLED: list[Outlet] = []


@contextmanager
def installed(outlet: Outlet) -> Iterator[None]:
    """Meanwhile, what lessons show goes to `outlet`."""
    _INSTALLED.append(outlet)
    try:
        yield
    finally:
        _INSTALLED.remove(outlet)


def show(plain: str, html: Callable[[Path | None], str]) -> None:
    """Show it where the lesson runs."""
    outlet = _INSTALLED[-1] if _INSTALLED else _in_notebook if _notebook() else _as_text
    outlet(Shown(plain, html))


def _notebook() -> bool:
    ipython = sys.modules.get("IPython")
    shell = ipython and ipython.get_ipython()
    return shell is not None and hasattr(shell, "kernel")


def _in_notebook(shown: Shown) -> None:
    from IPython.display import HTML, display

    display(HTML(shown.html(None)))  # type: ignore[no-untyped-call]


def _as_text(shown: Shown) -> None:
    sys.stdout.write(shown.plain.rstrip() + "\n")
