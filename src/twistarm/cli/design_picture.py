"""The picture of `designs`: their figures beside those of the first, and the outlines of what they reach."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..design import Design
from ..support.checks import Array
from ..support.pictures import empty_figure, png_of
from ..sweeps import reach_map

LAYERS = 24
"""Cubes of a map from the base to the farthest place."""


def picture_of(designs: Sequence[Design], figures: Mapping[str, str]) -> bytes:
    """A PNG of the figures {title: field of `Design`}, and of slices through y = 0 and through the middle of heights.

    A cube counts as in `reach_map`, in any orientation; without the compiled core, by random configurations.
    """
    figure = empty_figure("a picture", figsize=(15, 5))
    bars, side, top = figure.subplots(1, 3)
    values = np.array([[getattr(each, field) for field in figures.values()] for each in designs])
    known = np.isfinite(values) & (values[0] > 0.0) & (values[0] < np.inf)
    share = np.divide(100.0 * values, values[0], out=np.zeros(values.shape), where=known)
    voxel, at = max(each.farthest for each in designs) / LAYERS, np.arange(len(figures))
    for i, each in enumerate(designs):
        height = 0.8 / len(designs)
        bars.barh(at + i * height, share[i], height, color=f"C{i}", label=each.name)
        m = reach_map(each.arm, voxel, "position", method="fk" if each.arm._why_not_compiled else "ik")
        x, y, z = (m.grid.along(k) for k in range(3))
        level = z[m.counts.sum(axis=(0, 1), dtype=np.int64).argmax()]
        _outline(side, x, z, m.slice("y", float(np.clip(0.0, *y[[0, -1]]))), f"C{i}")
        _outline(top, x, y, m.slice("z", float(level)), f"C{i}")
    bars.set(yticks=at + 0.4 - 0.4 / len(designs), yticklabels=[*figures], xlabel=f"% of {designs[0].name}")
    bars.invert_yaxis()
    bars.legend()
    side.set(title="reach at y = 0", xlabel="x [m]", ylabel="z [m]", aspect="equal")
    top.set(title="reach at the height of most", xlabel="x [m]", ylabel="y [m]", aspect="equal")
    return png_of(figure)


def _outline(axes: Any, across: Array, up: Array, layer: Array, colour: str) -> None:
    """Draw the border of what is reached, also where that ends with the map."""
    step = across[1:2] - across[:1]
    u, v = (np.concatenate([along[:1] - step, along, along[-1:] + step]) for along in (across, up))
    axes.contour(u, v, np.pad(layer, 1).T, [0.5], colors=colour)
