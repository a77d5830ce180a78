"""Pictures by matplotlib, which the extra `guide` installs."""

from __future__ import annotations

import io
from typing import Any

from .errors import missing_extra


def empty_figure(what: str, **how: Any) -> Any:
    """An empty matplotlib Figure. MissingExtraError, which names `what`, without matplotlib."""
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise missing_extra(what, "matplotlib", "guide") from error
    return Figure(**{"layout": "constrained"} | how)


def png_of(figure: Any, **how: Any) -> bytes:
    """The figure as a PNG."""
    file = io.BytesIO()
    figure.savefig(file, format="png", **how)
    return file.getvalue()
