"""A picture of a panel's report: where the rover parks, and which tasks the arm does."""

from __future__ import annotations

import numpy as np

from ..support.pictures import empty_figure, png_of
from .parking import PanelReport

DONE, MISSED = "#0072b2", "#d55e00"
"""Colours that most people tell apart (Okabe & Ito)."""


def panel_picture(report: PanelReport) -> bytes:
    """A PNG: the parking poses from above with their numbers of tasks, and the panel from the front.

    Raises MissingExtraError without matplotlib.
    """
    figure, panel = empty_figure("a picture of a panel", figsize=(11, 5)), report.panel
    top, front = figure.subplots(1, 2, width_ratios=(2, 3))
    if len(report.places):
        x, y, _, count = report.places[report.places[:, 3].argsort(kind="stable")].T
        dots = top.scatter(x, y, c=count, s=12, marker="s", vmin=0, vmax=len(panel.tasks), cmap="Greys")
        figure.colorbar(dots, ax=top, label="tasks within reach, at the best yaw")
    (x, y), (ahead, aside) = report.base[:2, 3], 0.25 * report.base[:2, 0]
    top.quiver(x, y, ahead, aside, angles="xy", scale_units="xy", scale=1.0, color=DONE, zorder=3)
    top.plot(x, y, "o", color=DONE, label="the arm's base")
    width, height = (1.0, 1.0) if panel.size is None else panel.size[:2]
    wall = panel.pose[:2, 3] + 0.5 * width * np.outer([-1.0, 1.0], panel.pose[:2, 0])
    top.plot(*wall.T, color="black", lw=3, label="the panel")
    top.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title="from above")
    if panel.size is not None:
        across, up = 0.5 * width * np.array([-1, 1, 1, -1, -1]), 0.5 * height * np.array([-1, -1, 1, 1, -1])
        front.plot(across, up, color="black", lw=1)
    for result in report.results:
        place, colour = result.task.place[:2], DONE if result.code == "done" else MISSED
        front.plot(*place, "o" if colour == DONE else "X", color=colour)
        same = [one.task.name for one in report.results if np.allclose(one.task.place[:2], place)]
        if result.task.name == same[0]:
            how = {"textcoords": "offset points", "rotation": 35, "fontsize": 8, "parse_math": False}
            front.annotate(", ".join(same), place, xytext=(3, 3), color=colour, **how)
    front.set(xlabel="x of the panel [m]", ylabel="y of the panel [m]", aspect="equal", title="from the front")
    figure.suptitle(f"{report.arm.name}: {len(report.done)} of {len(panel.tasks)} tasks", parse_math=False)
    top.margins(0.1)
    front.margins(0.1)
    top.legend(loc="upper left", fontsize=8)
    return png_of(figure, dpi=120)
