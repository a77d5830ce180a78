"""A matplotlib figure as SVG for a page, with the page's colours and unique names."""

from __future__ import annotations

import hashlib
import io
import re
from typing import Any

from . import space
from .style import COLOURS


def of(figure: Any) -> str:
    """The figure as one `<svg>` element, hidden from screen readers, which read its words."""
    text = io.StringIO()
    panels = [ax for ax in figure.axes if ax.name == "3d"]
    box = space.settle(panels) if panels else "tight"
    attributes = space.places(panels, box)
    figure.savefig(text, format="svg", bbox_inches=box, pad_inches=0.05, metadata={"Date": None})
    return as_element(re.sub(r'id="(space-[\d-]+)"', lambda found: attributes[found[1]], text.getvalue()))


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
