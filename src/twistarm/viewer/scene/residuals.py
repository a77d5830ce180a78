"""The residuals of a calibration as needles from the predicted to the measured place, magnified."""

import numpy as np

from ...calibration import Calibration
from ...support.errors import InputError
from ...theory.screws import inverse_of
from . import drawing
from .axes import arm_size


def draw_residuals(found: Calibration) -> tuple[bytes, str]:
    """The needles, thin tetrahedra in one packed object, and their magnification in words.

    Red are the largest 5 %, blue is none. Raises InputError if no row has a place.
    """
    from meshcat.geometry import Mesh, MeshBasicMaterial, TriangularMeshGeometry

    log, back, scale = found.problem.log, inverse_of(found.base)[:3], arm_size(found.arm)
    resting = np.array([found.places.get(name, np.full(3, np.nan)) for name in log.point])
    measured = np.where(log.located[:, None], log.position, resting)
    known = np.isfinite(measured).all(axis=1)
    if not known.any():
        raise InputError("no row of this log has a position or rests on a point: there is no residual to draw")
    start, end = (p[known] @ back[:, :3].T + back[:, 3] for p in (found.predict(log.theta), measured))
    size = np.linalg.norm(end - start, axis=1, keepdims=True)
    large = max(float(np.quantile(size, 0.95)), 1e-9)
    times = float(f"{0.15 * scale / large:.1g}")
    z = (end - start) / np.maximum(size, 1e-12)
    x = 0.006 * scale * np.cross(z, np.eye(3)[np.argmin(np.abs(z), axis=1)])
    foot = [start + np.cos(t) * x + np.sin(t) * np.cross(z, x) for t in 2 * np.pi / 3 * np.arange(3)]
    corners = np.stack([*foot, start + times * (end - start)], axis=1).reshape(-1, 3)
    faces = 4 * np.arange(len(start))[:, None, None] + [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    colours = drawing.BLUE[:3] + np.minimum(size / large, 1.0) * np.subtract(drawing.RED, drawing.BLUE)[:3]
    geometry = TriangularMeshGeometry(corners, faces.reshape(-1, 3), np.repeat(colours, 4, axis=0))
    lowered = Mesh(geometry, MeshBasicMaterial(vertexColors=True)).lower()
    words = f"residuals {times:g} times as long, from predicted to measured; red: {1000 * large:.2g} mm and more"
    return drawing.packed_object("/frames/residuals", lowered, np.eye(4)), words
