"""A matplotlib figure as SVG for a page, with the page's colours and unique names."""

from __future__ import annotations

import hashlib
import io
import re
from typing import Any

import numpy as np

from .style import COLOURS


def of(figure: Any) -> str:
    """The figure as one `<svg>` element, hidden from screen readers, which read its words."""
    text = io.StringIO()
    figure.savefig(text, format="svg", bbox_inches=_drawn(figure), metadata={"Date": None})
    return as_element(text.getvalue())


def _drawn(figure: Any) -> Any:
    """The inked part of the figure's plane [inches]; axes in space leave or overstep room."""
    from matplotlib.transforms import Bbox

    beyond, fineness = 0.7, 50  # [inches] of the plane that are looked at around the figure; dots per inch
    width, height = figure.get_size_inches()
    plane = Bbox([[-beyond, -beyond], [width + beyond, height + beyond]])
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # it is laid out now
    for legend in figure.legends:  # it stands on the edge of the figure, and not of the plane that is looked at
        if legend.get_bbox_to_anchor() is figure.bbox:
            legend.set_bbox_to_anchor((0, 0, 1, 1), figure.transFigure)
    dots = io.BytesIO()
    figure.savefig(dots, format="raw", dpi=fineness, bbox_inches=plane)
    shape = tuple(round(side * fineness) for side in (plane.height, plane.width))
    ink = np.frombuffer(dots.getvalue(), np.uint8).reshape(*shape, 4)[..., 3]
    rows, columns = (np.flatnonzero(ink.any(axis=axis)) for axis in (1, 0))
    if not rows.size:
        return plane
    low, high = np.array([columns[0], shape[0] - 1 - rows[-1]]), np.array([columns[-1] + 1, shape[0] - rows[0]])
    return Bbox(np.array([low, high]) / fineness - beyond).padded(0.05)


def as_element(document: str) -> str:
    """An SVG document of matplotlib as an element of a page."""
    element = document[document.index("<svg") :].strip()
    element = re.sub(r"<metadata>.*?</metadata>", "", element, flags=re.DOTALL)
    # A style element in it would be one of the whole page.
    element = re.sub(r"<style.*?</style>", "", element, flags=re.DOTALL)
    head, _, rest = element.partition(">")
    width, height = (float(re.search(rf' {side}="([\d.]+)pt"', head)[1]) for side in ("width", "height"))  # type: ignore[index]
    head = (
        f'<svg viewBox="0 0 {width:g} {height:g}" style="width:{width * 1.34:.0f}px" aria-hidden="true" '
        'focusable="false" stroke-linejoin="round" stroke-linecap="butt"'
    )
    return f"{head}>{_coloured(_own_names(rest))}"


def _own_names(text: str) -> str:
    """Prefix the figure's names, because a page has several figures and unique names."""
    mark = "f" + hashlib.sha256(text.encode()).hexdigest()[:8]
    text = re.sub(r'xlink:href="#', 'href="#', text)
    # Groups that nothing refers to need no name.
    used = set(re.findall(r'(?:href="|url\()#([^")]+)', text))
    text = re.sub(r' id="([^"]+)"', lambda m: f' id="{mark}-{m[1]}"' if m[1] in used else "", text)
    return re.sub(r'(href="|url\()#', rf"\g<1>#{mark}-", text)


def _coloured(text: str) -> str:
    for name, colour in COLOURS.items():
        text = text.replace(colour, f"var(--{name},{colour})")
    return text
