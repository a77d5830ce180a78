"""The style of the figures: its colours with those for dark pages, and matplotlib's settings."""

from __future__ import annotations

from typing import Any

INK, GREY, FAINT = "#1b1f24", "#5b6470", "#c9ced6"
BLUE, ORANGE, GREEN, PINK, SKY, AMBER = "#0072b2", "#b54a00", "#00795a", "#a0447a", "#2f86b7", "#835700"
"""The colours of Okabe & Ito, the light ones darkened until they stand out from white by 3 to 1 and more."""

COLOURS = {"ink": INK, "grey": GREY, "faint": FAINT, "blue": BLUE, "orange": ORANGE, "green": GREEN, "pink": PINK,
           "sky": SKY, "amber": AMBER}  # fmt: skip
"""Each by the name of its variable in the page's style sheet, which has another value for dark pages."""

DASHES: dict[str, Any] = {"x": "-", "y": (0, (5, 1.5)), "z": (0, (1.2, 1.2))}
"""Lines of the three axes: told apart without colour too."""

AXES = {"x": ORANGE, "y": GREEN, "z": BLUE}

_SETTINGS: dict[str, Any] = {
    "font.size": 9.5,
    "axes.titlesize": 9.5,
    "axes.labelsize": 9.5,
    "legend.fontsize": 9,
    "legend.frameon": False,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": GREY,
    "axes.facecolor": "none",
    "figure.facecolor": "none",
    "savefig.facecolor": "none",
    "xtick.color": GREY,
    "ytick.color": GREY,
    "grid.color": FAINT,
    "grid.linewidth": 0.6,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 1.8,
    "mathtext.fontset": "dejavusans",
    "svg.fonttype": "path",
    "svg.hashsalt": "twistarm",
}


def use() -> None:
    """Set this style for matplotlib for good, because matplotlib reads much of it only when it draws."""
    import matplotlib
    from cycler import cycler

    cycle = cycler(color=[BLUE, ORANGE, GREEN, PINK, SKY, AMBER]) + cycler(
        linestyle=["-", (0, (5, 1.5)), (0, (1.2, 1.2)), (0, (5, 1.5, 1.2, 1.5)), (0, (8, 2)), (0, (2, 2))]
    )
    chosen: Any = {**_SETTINGS, "axes.prop_cycle": cycle}
    matplotlib.rcParams.update(chosen)
