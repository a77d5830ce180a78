"""Drawings for paper and for pages without JavaScript: the start of a scene or a slider."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm
from ...support.checks import Array
from ...theory import joints, poe, rotations, screws
from .figures import BLUE, GREY, INK, ORANGE, arm_points, axes2, axes3, plot_arm, plot_frame, plot_point, plot_screw

Numbers = Mapping[str, Any]


def arm(arm: Arm, theta: Array) -> Any:
    """The arm as a skeleton with the screws that its joints have there."""
    fig, ax = axes3(width=4.4, height=4.0)
    plot_arm(ax, arm, theta)
    moved = poe.spatial_jacobian(arm.screws, arm.coupling.A @ theta)
    for xi, point in zip(moved.T, arm_points(arm, theta)[1:-1], strict=True):
        plot_screw(ax, xi, length=0.35 * arm.reach, near=point)
    return fig


def slider(name: str, n: Numbers) -> tuple[Any, str]:
    """The first picture of a slider, and its text alternative."""
    draw, words = SLIDERS[name]
    return draw(n), words.format(**n)


def _frame(n: Numbers) -> Any:
    return _moved(rotations.from_euler(n["order"], np.radians([n["alpha"], n["beta"], n["gamma"]])))


def _axis_angle(n: Numbers) -> Any:
    axis = np.asarray(n["axis"], float) / np.linalg.norm(n["axis"])
    return _moved(rotations.exp(axis, np.radians(n["angle"])), [np.append(np.zeros(3), axis)])


def _twist(n: Numbers) -> Any:
    axis = np.asarray(n["axis"], float) / np.linalg.norm(n["axis"])
    xi = joints.helical(axis, n["point"], n["pitch"])[:, 0]
    path = screws.exp(xi, np.radians(n["angle"]) * np.linspace(0, 1, 60))
    return _moved(path[-1], [xi], path[:, :3, 3])


def _joint(n: Numbers) -> Any:
    z, x, o = (0, 0, 1), (1, 0, 0), (0, 0, 0)
    twists = {
        "revolute": joints.revolute(z, o),
        "prismatic": joints.prismatic(z),
        "helical": joints.helical(z, o, 0.15),
        "cylindrical": joints.cylindrical(z, o),
        "planar": joints.planar(z, o, x),
        "spherical": joints.spherical(o),
    }[n["type"]]
    return _moved(np.eye(4), twists.T)


def _moved(g: Array, twists: Iterable[Array] = (), path: ArrayLike = ((0, 0, 0),)) -> Any:
    """Frame T at g, seen from frame S, with the axes of twists (k, 6) and a path (m, 3)."""
    fig, ax = axes3(box=False)
    plot_frame(ax, np.eye(4), "S", alpha=0.45)
    plot_frame(ax, g, "T")
    for xi in twists:
        plot_screw(ax, xi, 2.6)
    ax.plot(*np.transpose(path), color=GREY)
    return fig


def _ellipsoid(n: Numbers) -> Any:
    fig, elbow, tool = _links(n)
    J = np.array([[-tool[1], -(tool - elbow)[1]], [tool[0], (tool - elbow)[0]]])
    turn = np.linspace(0, 2 * np.pi, 200)
    fig.axes[0].plot(*(tool[:, None] + 0.4 * J @ [np.cos(turn), np.sin(turn)]), color=ORANGE, linestyle="-")
    return fig


def _links(n: Numbers) -> tuple[Any, Array, Array]:
    fig, ax = axes2(width=3.9, height=3.6, xlabel="x [m]", ylabel="y [m]", equal=True)
    first, both = np.radians([n["theta1"], n["theta1"] + n["theta2"]])
    elbow = n["l1"] * np.array([np.cos(first), np.sin(first)])
    tool: Array = elbow + n["l2"] * np.array([np.cos(both), np.sin(both)])
    ax.plot(*np.array([[0, 0], elbow, tool]).T, color=INK, linewidth=4, linestyle="-", solid_capstyle="round")
    for point, name in (([0, 0], ""), (elbow, ""), (tool, "tool")):
        plot_point(ax, point, name, BLUE)
    return fig, elbow, tool


def _spline(n: Numbers) -> Any:
    T, q0, q1, v0, v1 = (float(n[key]) for key in ("duration", "start", "end", "velocity_start", "velocity_end"))
    values = np.array([q0, v0, 0.0, q1, v1, 0.0]).reshape(2, 3)[:, : 3 if n["kind"] == "quintic" else 2]
    basis = [np.poly1d(row) for row in np.eye(values.size)]
    rows = np.array([[monomial.deriv(k)(t) for monomial in basis] for t in (0, T) for k in range(values.shape[1])])
    p = np.poly1d(np.linalg.solve(rows, values.ravel()))
    t = np.linspace(0, T, 200)
    fig, (left, right) = axes2(2, height=2.7, xlabel="t [s]")
    left.plot(t, p(t))
    left.set_ylabel("angle [°]")
    right.plot(t, p.deriv()(t), label="velocity [°/s]")
    right.plot(t, p.deriv(2)(t), label="acceleration [°/s²]")
    right.legend()
    return fig


_TURNED = "A frame T turned against a frame S by "
_TWO_LINKS = "A two-link arm with links of {l1:g} m and {l2:g} m, its joints at {theta1:g}° and {theta2:g}°"

SLIDERS: dict[str, tuple[Callable[[Numbers], Any], str]] = {
    "frame": (_frame, _TURNED + "the {order} Euler angles {alpha:g}°, {beta:g}°, {gamma:g}°"),
    "axis_angle": (_axis_angle, _TURNED + "{angle:g}° about one axis, which is drawn"),
    "twist": (_twist, "A frame carried along a screw of pitch {pitch:g} m/rad by {angle:g}°"),
    "joint": (_joint, "A {type} joint: the axis of each of its freedoms"),
    "two_link": (lambda n: _links(n)[0], _TWO_LINKS),
    "spline": (_spline, "A {kind} from {start:g}° to {end:g}° in {duration:g} s, and its derivatives over time"),
    "ellipsoid": (_ellipsoid, f"{_TWO_LINKS}, and the velocities of its tool at joint rates of norm one, an ellipse"),
}
"""How the first picture of each slider is drawn, and its text alternative."""
