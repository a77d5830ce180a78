"""A picture of a calibration: the errors of its rows before and after, and over each joint."""

from __future__ import annotations

import numpy as np

from ..support.checks import require
from ..support.pictures import empty_figure, png_of
from .calibration import Calibration


def plot_of(calibration: Calibration) -> bytes:
    """A PNG: the share of rows below each error, then the errors over each joint, before (grey) and after.

    Raises MissingExtraError without matplotlib.
    """
    require(calibration, Calibration, "calibration", "as calibrate makes it")
    arm, theta = calibration.problem.geometry.arm, calibration.problem.log.theta
    figure = empty_figure("the plot", figsize=(10, 3 + 2.2 * ((arm.n + 1) // 2)))
    grid = figure.add_gridspec(1 + (arm.n + 1) // 2, 2)
    whole = figure.add_subplot(grid[0, :])
    panels = [figure.add_subplot(grid[1 + k // 2, k % 2]) for k in range(arm.n)]
    share = 100 * (np.arange(len(theta)) + 1) / len(theta)
    scale = np.where(np.array(arm.units) == "rad", 180 / np.pi, 1000.0)
    for errors, color, name in (
        (calibration.before, "0.7", "base and tool alone"),
        (calibration.after, "C0", "corrected"),
    ):
        whole.plot(1000 * np.sort(errors), share, color=color, label=name)
        for k, panel in enumerate(panels):
            panel.plot(scale[k] * theta[:, k], 1000 * errors, ".", color=color, markersize=3)
    whole.set(xlabel="error [mm]", ylabel="rows below it [%]", title=arm.name, xscale="log")
    whole.legend()
    for k, panel in enumerate(panels):
        unit = "°" if arm.units[k] == "rad" else "mm"
        panel.set(xlabel=f"{arm.joint_names[k]} [{unit}]", ylabel="error [mm]", yscale="log")
    return png_of(figure)
