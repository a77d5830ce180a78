"""Figures of the lessons: axes in one style, frames, vectors, screws and arms."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm
from ...support.checks import Array
from ...theory.screws import to_screw

INK, GREY, FAINT = "#1b1f24", "#5b6470", "#c9ced6"
BLUE, ORANGE, GREEN, PINK, SKY, AMBER = "#0072b2", "#b54a00", "#00795a", "#a0447a", "#2f86b7", "#835700"
"""The colours of Okabe & Ito, the light ones darkened until they stand out from white by 3 to 1 and more."""

COLOURS = {"ink": INK, "grey": GREY, "faint": FAINT, "blue": BLUE, "orange": ORANGE, "green": GREEN, "pink": PINK,
           "sky": SKY, "amber": AMBER}  # fmt: skip
"""Each by the name of its variable in the page's style sheet, which has another value for dark pages."""

# Lines of the three axes: told apart without colour too.
DASHES: dict[str, Any] = {"x": "-", "y": (0, (5, 1.5)), "z": (0, (1.2, 1.2))}

AXES = {"x": ORANGE, "y": GREEN, "z": BLUE}

_SETTINGS: dict[str, Any] = {
    "font.size": 9.5, "axes.titlesize": 9.5, "axes.labelsize": 9.5, "legend.fontsize": 9, "legend.frameon": False,
    "text.color": INK, "axes.labelcolor": INK, "axes.edgecolor": GREY, "xtick.color": GREY, "ytick.color": GREY,
    "axes.facecolor": "none", "figure.facecolor": "none", "savefig.facecolor": "none",
    "axes.grid": True, "grid.color": FAINT, "grid.linewidth": 0.6, "axes.axisbelow": True,
    "axes.spines.top": False, "axes.spines.right": False, "lines.linewidth": 1.8,
    "mathtext.fontset": "dejavusans", "svg.fonttype": "path", "svg.hashsalt": "twistarm",
}  # fmt: skip


def axes2(
    columns: int = 1,
    width: float = 5.6,
    height: float = 3.2,
    *,
    xlabel: str = "",
    ylabel: str = "",
    equal: bool = False,
) -> tuple[Any, Any]:
    """A figure with plane axes, as (figure, axes); several columns give a list of axes.

    Args:
        columns: Axes side by side.
        width: Of the figure [inches]; the text of a page is 6.6 wide.
        height: Of the figure [inches].
        xlabel: What the abscissa is, with its unit.
        ylabel: What the ordinate is, with its unit.
        equal: Whether a length is the same along both axes; their limits grow for it. If you set limits, set
            `aspect="equal"` too: then the axes shrink.
    """
    fig = _figure(width, height)
    axes = fig.subplots(1, columns)
    for ax in np.atleast_1d(axes):
        ax.set(xlabel=xlabel, ylabel=ylabel)
        if equal:
            ax.set_aspect("equal", adjustable="datalim")
    return fig, axes


def axes3(
    columns: int = 1, width: float = 4.6, height: float = 3.8, *, elev: float = 22, azim: float = -55, box: bool = True
) -> tuple[Any, Any]:
    """A figure with axes in space, as (figure, axes). Several columns give a list of axes.

    The figure is as large as what is drawn, and lengths are equal in each direction and panel. A page lets the reader
    turn it.

    Args:
        columns: Axes side by side.
        width: Of the figure [inches], as its height.
        height: Of the figure.
        elev: Height of the eye [degrees].
        azim: Direction of the eye about z [degrees].
        box: Whether a floor with a scale is drawn.
    """
    fig = _figure(width, height)
    axes = fig.subplots(1, columns, subplot_kw={"projection": "3d", "computed_zorder": False, "proj_type": "ortho"})
    for ax in np.atleast_1d(axes):
        ax.view_init(elev=elev, azim=azim)
        ax.set_axis_off()
        ax.floor = box
    return fig, axes


def _figure(width: float, height: float) -> Any:
    """A figure [inches] in this style. The style stays set, because matplotlib reads much of it only when it draws."""
    import matplotlib
    from cycler import cycler
    from matplotlib.figure import Figure

    cycle = cycler(color=[BLUE, ORANGE, GREEN, PINK, SKY, AMBER]) + cycler(
        linestyle=["-", (0, (5, 1.5)), (0, (1.2, 1.2)), (0, (5, 1.5, 1.2, 1.5)), (0, (8, 2)), (0, (2, 2))]
    )
    chosen: Any = {**_SETTINGS, "axes.prop_cycle": cycle}
    matplotlib.rcParams.update(chosen)
    return Figure(figsize=(width, height), layout="constrained")


def plot_frame(ax: Any, g: ArrayLike, name: str | None = "", length: float = 1.0, alpha: float = 1.0) -> None:
    """Draw a frame: x solid and vermilion, y dashed and green, z dotted and blue.

    Args:
        ax: Axes in space.
        g: Its pose (4, 4), or a rotation (3, 3) at the origin.
        name: Its letter, set beside each axis; None leaves the axes without letters.
        length: Of the axes.
        alpha: 1 for one that is meant, less for one that was.
    """
    pose = np.eye(4)
    given = np.asarray(g, float)
    pose[: len(given), : len(given)] = given
    origin = pose[:3, 3]
    for k, axis in enumerate("xyz"):
        end = origin + length * pose[:3, k]
        line = np.array([origin, end]).T
        ax.plot(*line, color=AXES[axis], linestyle=DASHES[axis], alpha=alpha, linewidth=2.0)
        if name is not None:
            words = f"${axis}_{{{name}}}$" if name else f"${axis}$"
            place = origin + 1.13 * (end - origin)
            ax.text(*place, words, color=AXES[axis], alpha=alpha, ha="center", va="center")
    ax.plot(*origin[:, None], "o", color=INK, markersize=3, alpha=alpha)


def plot_vector(ax: Any, start: ArrayLike, vector: ArrayLike, name: str = "", colour: str = INK) -> None:
    """Draw an arrow in the plane or in space.

    Args:
        ax: The axes.
        start: Where it begins, (2,) or (3,).
        vector: From there to its tip.
        name: Set beside its tip; formulae between dollars.
        colour: One of the guide's colours.
    """
    a, d = np.asarray(start, float), np.asarray(vector, float)
    if len(a) == 3:
        ax.plot(*_arrow(a, d, 0.12).T, color=colour, linestyle="-", linewidth=2.0)
    else:
        arrow = {"arrowstyle": "-|>", "shrinkA": 0, "shrinkB": 0, "mutation_scale": 11}
        ax.annotate("", a + d, a, arrowprops={**arrow, "color": colour, "linewidth": 2.0})
        ax.update_datalim(np.array([a, a + d]))
        ax.autoscale_view()
    if name:
        ax.text(*(a + 1.1 * d), name, color=colour, ha="center", va="center")


def plot_point(ax: Any, point: ArrayLike, name: str = "", colour: str = INK, marker: str = "o") -> None:
    """Draw a point in the plane or in space, with its name beside it."""
    p = np.asarray(point, float)
    ax.plot(*p[:, None], marker, color=colour, markersize=5, linestyle="none")
    if name:
        ax.text(*p, f"  {name}", color=colour, va="center")


def plot_screw(
    ax: Any, xi: ArrayLike, length: float = 1.0, name: str = "", colour: str = PINK, near: ArrayLike = (0.0, 0.0, 0.0)
) -> None:
    """Draw the axis of a twist (v, w): a line with an arrow around it, or an arrow along v (w = 0).

    Args:
        ax: Axes in space.
        xi: The twist (6,).
        length: Of what is drawn of the axis.
        name: Set at its end.
        colour: One of the guide's colours.
        near: A point near the drawn piece of the axis: the joint. An arrow of w = 0 is there.
    """
    screw = to_screw(xi)
    axis, middle = screw.axis, np.asarray(near, float)
    point = middle if np.isinf(screw.pitch) else screw.point + axis * float((middle - screw.point) @ axis)
    if np.isinf(screw.pitch):
        arrow = _arrow(point - length / 2 * axis, length * axis, 0.15)
        ax.plot(*arrow.T, color=colour, linestyle="-", linewidth=2.0)
    else:
        line = np.array([point - length / 2 * axis, point + length / 2 * axis])
        ax.plot(*line.T, color=colour, linestyle=(0, (7, 2, 1.5, 2)), linewidth=1.6)
        sense = _sense(point + 0.35 * length * axis, axis, 0.12 * length)
        ax.plot(*sense.T, color=colour, linestyle="-", linewidth=1.6)
    if name:
        ax.text(*(point + 0.56 * length * axis), name, color=colour, ha="center", va="center")


def plot_arm(
    ax: Any, arm: Arm, theta: ArrayLike | None = None, colour: str = INK, alpha: float = 1.0, tool: bool = True
) -> None:
    """Draw an arm as a skeleton: joints (circles turn, squares slide), links, the tool's frame.

    Args:
        ax: Axes in space.
        arm: The arm.
        theta: Where it stands, (n,) [rad, m]; ready where not given.
        colour: One of the guide's colours.
        alpha: 1 for one that is meant, less for one that was.
        tool: Whether the tool's frame is drawn.
    """
    x = arm.ready if theta is None else np.asarray(theta, float)
    points = arm_points(arm, x)
    round_ends = {"solid_capstyle": "round", "solid_joinstyle": "round"}
    ax.plot(*points.T, color=colour, linestyle="-", linewidth=3.5, alpha=0.75 * alpha, **round_ends)
    turning = np.linalg.norm(arm.screws[3:], axis=0) > 0.5
    for point, turns in zip(points[1:-1], turning, strict=True):
        ax.plot(*point[:, None], "o" if turns else "s", color=colour, markersize=6, markerfacecolor=SKY, alpha=alpha)
    ax.plot(*points[:1].T, "^", color=colour, markersize=7, alpha=alpha)
    if tool:
        plot_frame(ax, arm.fk(x), "t", length=0.16 * arm.reach, alpha=alpha)


def arm_points(arm: Arm, theta: ArrayLike) -> Array:
    """The arm as a line (m + 2, 3): base, one point per moving joint, tool.

    A joint's point is the origin of its link. Without a description it is the point of the axis nearest to the one
    before.
    """
    from ...viewer.scene.arm_drawing import anchors

    x = np.asarray(theta, float)
    return np.array([np.zeros(3), *anchors(arm, x), arm.fk(x)[:3, 3]])


def _arrow(start: Array, vector: Array, share: float) -> Array:
    """An arrow with a head of three barbs (k, 3), as long as `share` of it."""
    across = np.linalg.svd(vector[None])[2][1:]
    tip, barbs = start + vector, []
    for turn in 2 * np.pi * np.arange(3) / 3:
        aside = np.array([np.cos(turn), np.sin(turn)]) @ across * np.linalg.norm(vector)
        barbs += [tip, tip + share * (0.4 * aside - vector)]
    return np.array([start, *barbs, tip])


def _sense(centre: Array, axis: Array, radius: float) -> Array:
    """Three quarters of a turn about an axis (k, 3), with an arrow head at its end."""
    u = np.cross(axis, [1.0, 0, 0] if abs(axis[0]) < 0.8 else [0, 1.0, 0])
    u /= np.linalg.norm(u)
    v = np.cross(axis, u)
    t = np.linspace(0, 1.5 * np.pi, 40)
    arc: Array = centre + radius * (np.cos(t)[:, None] * u + np.sin(t)[:, None] * v)
    end, ahead = arc[-1], np.cross(axis, arc[-1] - centre)
    head = [end - 0.5 * ahead + s * 0.3 * (end - centre) for s in (1, -1)]
    return np.array([*arc, head[0], end, head[1]])
