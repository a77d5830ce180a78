"""Drawings for paper and for pages without JavaScript: the start of a scene or a slider."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from ...theory import joints, poe, rotations, screws
from .figures import arm_points, axes2, axes3, fit, plot_arm, plot_frame, plot_point, plot_screw, plot_vector
from .style import BLUE, GREY, INK, ORANGE

Numbers = Mapping[str, Any]


def arm(arm: Arm, theta: Array) -> Any:
    """The arm as a skeleton with the screws that its joints have there."""
    fig, ax = axes3(width=4.4, height=4.0)
    plot_arm(ax, arm, theta)
    moved = poe.spatial_jacobian(arm.screws, arm.coupling.A @ theta)
    for xi, point in zip(moved.T, arm_points(arm, theta)[1:-1], strict=True):
        plot_screw(ax, xi, length=0.35 * arm.reach, near=point)
    fit(ax)
    return fig


def _frame(n: Numbers) -> tuple[Any, str]:
    angles = [n["alpha"], n["beta"], n["gamma"]]
    R = rotations.from_euler(n["order"], np.radians(angles))
    degrees = ", ".join(f"{angle:g}°" for angle in angles)
    return _rotated(R), f"A frame B turned against a frame A by the {n['order']} Euler angles {degrees}"


def _axis_angle(n: Numbers) -> tuple[Any, str]:
    axis = np.asarray(n["axis"], float) / np.linalg.norm(n["axis"])
    fig = _rotated(rotations.exp(axis, np.radians(n["angle"])))
    plot_screw(fig.axes[0], np.append(np.zeros(3), axis), length=2.6, name=r"$\omega$")
    return fig, f"A frame B turned against a frame A by {n['angle']:g}° about one axis, which is drawn"


def _twist(n: Numbers) -> tuple[Any, str]:
    axis = np.asarray(n["axis"], float) / np.linalg.norm(n["axis"])
    xi = joints.helical(axis, n["point"], n["pitch"])[:, 0]
    fig, ax = axes3()
    angles = np.radians(n["angle"]) * np.linspace(0, 1, 60)
    path = screws.exp(xi, angles)[:, :3, 3]
    plot_frame(ax, np.eye(4), "A", 0.5, alpha=0.45)
    plot_frame(ax, screws.exp(xi, angles[-1]), "B", 0.5)
    plot_screw(ax, xi, 1.8, r"$\xi$")
    ax.plot(*path.T, color=GREY)
    fit(ax, [*path, *np.eye(3), -0.4 * np.eye(3)[2]])
    return fig, f"A frame carried along a screw of pitch {n['pitch']:g} m/rad by {n['angle']:g}°"


def _joint(n: Numbers) -> tuple[Any, str]:
    z, x, o = (0, 0, 1), (1, 0, 0), (0, 0, 0)
    twists = {
        "revolute": joints.revolute(z, o),
        "prismatic": joints.prismatic(z),
        "helical": joints.helical(z, o, 0.15),
        "cylindrical": joints.cylindrical(z, o),
        "planar": joints.planar(z, o, x),
        "spherical": joints.spherical(o),
    }[n["type"]]
    fig, ax = axes3(box=False)
    plot_frame(ax, np.eye(4), "", 0.6, alpha=0.5)
    for k, xi in enumerate(twists.T, start=1):
        plot_screw(ax, xi, 1.6, rf"$\xi_{k}$")
    fit(ax, [[-0.8] * 3, [0.8] * 3])
    count = twists.shape[1]
    return fig, f"A {n['type']} joint: the axis of each of its {count} freedom{'s' * (count > 1)}"


def _two_link(n: Numbers) -> tuple[Any, str]:
    fig, ax = axes2(width=3.9, height=3.6, xlabel="x [m]", ylabel="y [m]", equal=True)
    _links(ax, n)
    words = f"A two-link arm with links of {n['l1']:g} m and {n['l2']:g} m"
    return fig, f"{words}, its joints at {n['theta1']:g}° and {n['theta2']:g}°"


def _ellipsoid(n: Numbers) -> tuple[Any, str]:
    fig, ax = axes2(width=3.9, height=3.6, xlabel="x [m]", ylabel="y [m]", equal=True)
    elbow, tool = _links(ax, n)
    J = np.array([[-tool[1], -(tool - elbow)[1]], [tool[0], (tool - elbow)[0]]])
    turn = np.linspace(0, 2 * np.pi, 200)
    ax.plot(*(tool[:, None] + 0.4 * J @ [np.cos(turn), np.sin(turn)]), color=ORANGE, linestyle="-")
    return fig, "A two-link arm, and about its tool the ellipse of the velocities that joint rates of norm one reach"


def _spline(n: Numbers) -> tuple[Any, str]:
    T, q0, q1, v0, v1 = (float(n[key]) for key in ("duration", "start", "end", "velocity_start", "velocity_end"))
    t = np.linspace(0, T, 200)
    ends = [(0.0, q0, v0), (T, q1, v1)]
    derivatives = range(3 if n["kind"] == "quintic" else 2)
    basis = [np.poly1d(row) for row in np.eye(2 * len(derivatives))]
    rows = np.array([[each.deriv(k)(at) for each in basis] for at, _, _ in ends for k in derivatives])
    p = np.poly1d(np.linalg.solve(rows, np.array([[q, v, 0.0][k] for _, q, v in ends for k in derivatives])))
    fig, (left, right) = axes2(2, height=2.7, xlabel="t [s]")
    left.plot(t, p(t))
    left.set_ylabel("angle [°]")
    right.plot(t, p.deriv()(t), label="velocity [°/s]")
    right.plot(t, p.deriv(2)(t), label="acceleration [°/s²]")
    right.legend()
    return fig, f"A {n['kind']} from {q0:g}° to {q1:g}° in {T:g} s: its angle, velocity and acceleration over time"


def _rotated(R: Array) -> Any:
    fig, ax = axes3(box=False)
    plot_frame(ax, np.eye(3), "A", alpha=0.45)
    plot_frame(ax, R, "B", 1.0)
    fit(ax, [[-0.9] * 3, [0.9] * 3])
    return fig


def _links(ax: Any, n: Numbers) -> tuple[Array, Array]:
    first, both = np.radians(n["theta1"]), np.radians(n["theta1"] + n["theta2"])
    elbow = n["l1"] * np.array([np.cos(first), np.sin(first)])
    tool: Array = elbow + n["l2"] * np.array([np.cos(both), np.sin(both)])
    ax.plot(*np.array([[0, 0], elbow, tool]).T, color=INK, linewidth=4, linestyle="-", solid_capstyle="round")
    for point, name in (([0, 0], ""), (elbow, ""), (tool, "tool")):
        plot_point(ax, point, name, BLUE)
    plot_vector(ax, [0, 0], [n["l1"] / 3, 0], "", GREY)
    return elbow, tool


SLIDERS: dict[str, Callable[[Numbers], tuple[Any, str]]] = {
    "frame": _frame,
    "axis_angle": _axis_angle,
    "twist": _twist,
    "joint": _joint,
    "two_link": _two_link,
    "spline": _spline,
    "ellipsoid": _ellipsoid,
}
"""The first picture of each slider, and its text alternative."""
