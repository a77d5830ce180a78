"""The residuals of a calibration as needles from the predicted to the measured place, magnified."""

from __future__ import annotations

import numpy as np

from ...calibration import Calibration
from ...support.checks import Array
from ...support.errors import InputError
from ...theory.screws import inverse_of
from . import drawing
from .axes import arm_size

LENGTH, THICK = 0.15, 0.006
"""Drawn length of a large residual, and radius of a needle's foot, in sizes of the arm."""

LARGE = 0.95
"""The share of the residuals that are smaller than a large one: an outlier does not hide the others."""


def draw_residuals(found: Calibration, magnification: float | None) -> tuple[bytes, float, str]:
    """The needles as one packed object, the magnification, and both in words. InputError if no row has a position.

    A needle is a thin tetrahedron: blue for no residual, red for a large one.
    """
    log, inverse = found.problem.log, inverse_of(found.base)
    resting = np.array([found.places.get(name, np.full(3, np.nan)) for name in log.point]).reshape(-1, 3)
    measured = np.where(log.located[:, None], log.positions, resting)
    predicted, known = found.predict(log.theta), np.isfinite(measured).all(axis=1)
    if not known.any():
        raise InputError("no row of this log has a position or rests on a point: there is no residual to draw")
    start = predicted[known] @ inverse[:3, :3].T + inverse[:3, 3]
    way = (measured - predicted)[known] @ inverse[:3, :3].T
    size, scale = np.linalg.norm(way, axis=1), arm_size(found.arm)
    large = max(float(np.quantile(size, LARGE)), 1e-9)
    times = _round(LENGTH * scale / large) if magnification is None else magnification
    words = f"residuals {times:g} times as long, from predicted to measured: red is {1000 * large:.2g} mm and more"
    return _needles(start, times * way, THICK * scale, np.minimum(size / large, 1.0)), times, words


def _needles(start: Array, way: Array, radius: float, share: Array) -> bytes:
    from meshcat.geometry import Mesh, MeshBasicMaterial, TriangularMeshGeometry

    z = way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-12)
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z), axis=1)])
    foot = [start + radius * (np.cos(t) * x + np.sin(t) * np.cross(z, x)) for t in 2 * np.pi / 3 * np.arange(3)]
    corners = np.stack([*foot, start + way], axis=1).reshape(-1, 3)
    faces = 4 * np.arange(len(start))[:, None, None] + [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    colours = np.outer(1 - share, drawing.BLUE[:3]) + np.outer(share, drawing.RED[:3])
    geometry = TriangularMeshGeometry(corners, faces.reshape(-1, 3), np.repeat(colours, 4, axis=0))
    return drawing.packed_object(
        "/frames/residuals", Mesh(geometry, MeshBasicMaterial(vertexColors=True)).lower(), np.eye(4)
    )


def _round(number: float) -> float:
    """The largest of 1, 2, 5, 10, 20, … below a number."""
    power = 10.0 ** np.floor(np.log10(number))
    return float(power * max(step for step in (1, 2, 5) if step * power <= number))
