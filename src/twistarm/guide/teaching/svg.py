"""A figure of matplotlib as SVG for a page, with the page's colours and unique names.

Panels in space get one scale and a floor. The page has the positions of their lines and letters, and turns them.
"""

from __future__ import annotations

import hashlib
import io
import re
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from ...support.checks import Array
from .figures import COLOURS, FAINT, GREY

MARGIN = 0.15  # Room for letters around what is drawn [inches].


def of(figure: Any) -> str:
    """The figure as one `<svg>` element, hidden from screen readers, which read its words."""
    document = io.StringIO()
    panels = [ax for ax in figure.axes if ax.name == "3d"]
    box = settle(panels) if panels else "tight"
    attributes = places(panels, box)
    figure.savefig(document, format="svg", bbox_inches=box, pad_inches=0.05, metadata={"Date": None})
    text = re.sub(r'id="(space-[\d-]+)"', lambda found: attributes[found[1]], document.getvalue())
    # A style element in it would be one of the whole page.
    text = re.sub(r"<(metadata|style).*?</\1>", "", text[text.index("<svg") :].strip(), flags=re.DOTALL)
    head, _, text = text.partition(">")
    # matplotlib writes points, and a page shows pixels: 96/72 of them.
    width, height = (float(re.search(rf' {side}="([\d.]+)pt"', head)[1]) for side in ("width", "height"))  # type: ignore[index]
    head = (
        f'<svg viewBox="0 0 {width:g} {height:g}" style="width:{width * 1.34:.0f}px" aria-hidden="true" '
        'focusable="false" stroke-linejoin="round" stroke-linecap="butt"'
    )
    # Names get the figure's own mark, because a page has several figures. What nothing refers to needs no name.
    mark = "f" + hashlib.sha256(text.encode()).hexdigest()[:8]
    text = text.replace('xlink:href="#', 'href="#')
    used = set(re.findall(r'(?:href="|url\()#([^")]+)', text))
    text = re.sub(r' id="([^"]+)"', lambda m: f' id="{mark}-{m[1]}"' if m[1] in used else "", text)
    text = re.sub(r'(href="|url\()#', rf"\g<1>#{mark}-", text)
    for name, colour in COLOURS.items():
        text = text.replace(colour, f"var(--{name},{colour})")
    return f"{head}>{text}"


def plot_motion(plot: Callable[..., object], ax: Any, places: Iterable[Any], *arguments: Any) -> None:
    """Draw something that moves. A page plays the motion; paper shows its end.

    Args:
        plot: Draws it, the same things at each place: `plot_frame`, `plot_point`, or a function of the lesson.
        ax: Axes in space.
        places: The places that `plot` takes after the axes. A page interpolates between them.
        arguments: What `plot` takes after the place.
    """
    moments: list[list[Any]] = []
    for place in places:
        before = set(ax.get_children())
        plot(ax, place, *arguments)
        moments.append([artist for artist in ax.get_children() if artist not in before])
    for same in zip(*moments, strict=True):
        same[-1].moments = [_lines(artist) for artist in same]
        for artist in same[:-1]:
            artist.remove()


def settle(panels: list[Any]) -> Any:
    """Give the panels of a figure one centre and one scale. All stays in sight when a page turns them.

    Returns the part of the figure to save [inches].
    """
    from matplotlib.transforms import Bbox

    points = _points(panels)
    for ax in (each for each in panels if each.floor):
        _draw_floor(ax, points.min(axis=0), points.max(axis=0))
    points = _points(panels)
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = float(np.linalg.norm(points - centre, axis=1).max()) or 1.0
    figure, boxes = panels[0].figure, []
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # it is laid out now
    for ax in panels:
        limits = zip(("xlim3d", "ylim3d", "zlim3d"), centre, strict=True)
        ax.set(**{name: (middle - radius, middle + radius) for name, middle in limits})
        ax.set_box_aspect((1, 1, 1))
        box = ax.get_window_extent()
        room = min(box.width, box.height) / 2 - MARGIN * figure.dpi
        ax.set_box_aspect((1, 1, 1), zoom=room / (radius * _seen(ax)[2]))
        words = [ax.title] * bool(ax.get_title()) + [item for item in [ax.get_legend()] if item]
        boxes += [box, *(item.get_window_extent() for item in words)]
        for artist in _placed(ax):  # there is no frame to cut them off
            artist.set_clip_on(False)
    return Bbox.union(boxes).transformed(figure.dpi_scale_trans.inverted()).padded(0.03)


def places(panels: list[Any], box: Any) -> dict[str, str]:
    """Name the panels and what they draw. Return, by name, attributes of the elements in the drawing of `box` [inches].

    The attributes give a page the direction of view [degrees] and the centre of the panel. Lines and letters have their
    positions around it, in units of the drawing.
    """
    attributes = {}
    for k, ax in enumerate(panels):
        centre, (x, y), scale = _seen(ax)
        unit = 72 / ax.figure.dpi
        ax.set_gid(f"space-{k}")
        across, down = x * unit - 72 * box.x0, 72 * box.y1 - y * unit
        attributes[f"space-{k}"] = f'data-eye="{ax.azim:g} {ax.elev:g}" data-centre="{across:.2f} {down:.2f}"'
        for j, artist in enumerate(_placed(ax)):
            artist.set_gid(f"space-{k}-{j}")
            moments = ([scale * unit * (line - centre) for line in moment] for moment in _moments(artist))
            at = ";".join("|".join(" ".join(f"{x:.1f}" for x in line.ravel()) for line in lines) for lines in moments)
            attributes[f"space-{k}-{j}"] = f'data-at="{at}"' + " data-letters" * hasattr(artist, "get_text")
    return attributes


def _placed(ax: Any) -> list[Any]:
    """The artists with a place in space: lines, collections of lines, and words."""
    from mpl_toolkits.mplot3d.art3d import Line3D, Line3DCollection, Text3D

    return [artist for artist in ax.get_children() if isinstance(artist, (Line3D, Line3DCollection, Text3D))]


def _lines(artist: Any) -> list[Array]:
    """The lines (k, 3) of an artist [m]; words are a line of one point."""
    if hasattr(artist, "get_text"):
        return [np.array([artist.get_position_3d()])]
    return [np.column_stack(artist.get_data_3d())] if hasattr(artist, "get_data_3d") else list(artist._segments3d)


def _moments(artist: Any) -> list[list[Array]]:
    return getattr(artist, "moments", None) or [_lines(artist)]


def _points(panels: list[Any]) -> Array:
    """All points drawn, at all moments (k, 3)."""
    artists = (artist for ax in panels for artist in _placed(ax))
    return np.vstack([line for artist in artists for moment in _moments(artist) for line in moment])


def _seen(ax: Any) -> tuple[Array, Array, float]:
    """The centre [m], its place on the figure, and the length of a metre there [dots]."""
    from mpl_toolkits.mplot3d.proj3d import proj_transform

    centre, turn = np.mean([ax.get_xlim3d(), ax.get_ylim3d(), ax.get_zlim3d()], axis=1), np.radians(ax.azim)
    ends = np.array([centre, centre + [-np.sin(turn), np.cos(turn), 0.0]])
    here, beside = ax.transData.transform(np.column_stack(proj_transform(*ends.T, ax.get_proj())[:2]))
    return centre, here, float(np.linalg.norm(beside - here))


def _draw_floor(ax: Any, low: Array, high: Array) -> None:
    """A floor below what is drawn, with lines at round lengths, and a scale for each axis [m]."""
    from matplotlib.ticker import MaxNLocator

    step = np.diff(MaxNLocator(5).tick_values(0.0, float((high - low).max()) or 1.0))[0]
    (x0, y0, z0), (x1, y1, z1) = low - [step / 4, step / 4, 0], high + [step / 4, step / 4, 0]
    xs, ys, zs = (step * np.arange(np.ceil(a / step), b / step + 1e-9) for a, b in ((x0, x1), (y0, y1), (z0, z1)))
    lines = [[(x, y0, z0), (x, y1, z0)] for x in (x0, *xs, x1)] + [[(x0, y, z0), (x1, y, z0)] for y in (y0, *ys, y1)]
    for line in [*lines, [(x0, y1, z0), (x0, y1, z1)]]:
        ax.plot(*np.array(line).T, color=FAINT, linestyle="-", linewidth=0.6, zorder=0)
    marks = [((x, y0 - step / 3, z0), "x", x, xs[-1]) for x in xs]
    marks += [((x1 + step / 3, y, z0), "y", y, ys[-1]) for y in ys]
    marks += [((x0, y1 + step / 3, z), "z", z, zs[-1]) for z in zs]
    for place, axis, value, last in marks:
        number = f"{round(value, 9) + 0.0:g}".replace("-", "−")
        words = f"{axis} {number} m" if value == last else number
        ax.text(*place, words, color=GREY, size=7, ha="center", va="center", zorder=0)
