"""Success against the median time of cold targets, with a whisker to the 99th percentile, one panel per arm."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .figures import SingleCalls
from .peers import PEERS

MARKERS = "osD^v<>p"
"""One per peer: several may lie on the same spot."""

LOWEST = 95.0
"""Success [%] that the axis reaches down to at least: so a thousandth looks like one."""


def plot(rows: list[SingleCalls], path: Path) -> None:
    arms = list(dict.fromkeys(row.arm for row in rows))
    rows = [row for row in rows if row.kind == "cold" and np.isfinite(row.median)]
    figure = Figure(figsize=(4 * len(arms), 4.2), layout="constrained")
    panels = figure.subplots(1, len(arms), sharey=True, squeeze=False)[0]
    for panel, arm in zip(panels, arms, strict=True):
        for row in (row for row in rows if row.arm == arm):
            _draw(panel, row)
        panel.set(title=arm, xscale="log", xlabel="one call: median, whisker to p99 [µs]")
        panel.grid(alpha=0.3)
    lowest = min((100 * row.strict for row in rows), default=LOWEST)
    panels[0].set(ylabel="cold targets met to 1e-6 m and rad [%]", ylim=(min(LOWEST, lowest - 1), 100.5))
    shown = {label: line for panel in panels for line, label in zip(*panel.get_legend_handles_labels(), strict=True)}
    peers = [peer for peer in PEERS if peer in shown]
    figure.legend([shown[peer] for peer in peers], peers, loc="outside lower center", ncols=len(PEERS), frameon=False)
    figure.savefig(path, dpi=150)


def _draw(panel: Axes, row: SingleCalls) -> None:
    place, success = PEERS.index(row.peer), 100 * row.strict
    # The longer a whisker, the deeper it lies: none hides another's end.
    depth = 1 + 1 / (1 + row.p99)
    panel.plot([row.median, row.p99], 2 * [success], "-|", color=f"C{place}", ms=9, markevery=[1], zorder=depth)
    panel.plot([row.median], [success], MARKERS[place], color=f"C{place}", mfc="white", mew=2, zorder=3, label=row.peer)
