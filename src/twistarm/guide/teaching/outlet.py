"""The outlet of a lesson: where what it shows goes, to a page, into a notebook or, as text, to standard output."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol


class Shown(Protocol):
    """Something that a lesson shows."""

    def plain(self) -> str:
        """As text for a terminal."""
        ...

    def data(self, folder: Path | None) -> dict[str, Any]:
        """As what `html_of` takes, plain JSON with its `kind`; files that belong to it are written into `folder`,
        or stand in the data where there is none.
        """
        ...


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


def show(shown: Shown) -> None:
    """Show it where the lesson runs."""
    outlet = _INSTALLED[-1] if _INSTALLED else _in_notebook if _notebook() else _as_text
    outlet(shown)


def _notebook() -> bool:
    ipython = sys.modules.get("IPython")
    shell = ipython and ipython.get_ipython()
    return shell is not None and hasattr(shell, "kernel")


def _in_notebook(shown: Shown) -> None:
    from IPython.display import HTML, display

    from .html import html_of

    display(HTML(html_of(shown.data(None))))  # type: ignore[no-untyped-call]


def _as_text(shown: Shown) -> None:
    sys.stdout.write(shown.plain().rstrip() + "\n")
