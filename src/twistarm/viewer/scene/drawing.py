"""Objects for Meshcat as messages (primitives, arrows, triads, triangles), and the names of the scene's nodes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any
from urllib.parse import quote

import numpy as np

from ...support.checks import Array, pose_of
from ...support.errors import missing_extra


def link_path(name: str) -> str:
    """The node of a link. Slashes in names are escaped, because Meshcat splits paths there."""
    return f"/arm/link:{quote(name, safe='')}"


def drawn_path(name: str) -> str:
    """The node of what a program draws by this name."""
    return f"/drawn/name:{quote(name, safe='')}"


def screw_path(i: int) -> str:
    """The node of moving joint i's screw."""
    return f"/screws/screw:{i}"


def rod_path(i: int) -> str:
    """The node of what moves with joint i, where there are no links."""
    return f"/arm/rod:{i}"


Colour = tuple[float, float, float, float]

RED: Colour = (0.86, 0.22, 0.22, 1.0)
GREEN: Colour = (0.20, 0.65, 0.28, 1.0)
BLUE: Colour = (0.16, 0.42, 0.90, 1.0)
STICK: Colour = (0.45, 0.50, 0.58, 1.0)

GHOST = 0.4  # Opacity of a hidden arrow.
# Turns three.js's cylinder (along y) into URDF's (along z).
Y_TO_Z = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
# Half the height of the page's view at distance 1, by which three.js divides the size of a point.
FIELD = math.tan(math.radians(16.0))


def require_meshcat() -> None:
    """Raise the error that names the missing extra where Meshcat is not installed."""
    try:
        import meshcat  # noqa: F401
    except ImportError as error:
        raise missing_extra("the viewer", "meshcat", "view") from error


def set_object(path: str, geometry: Any, colour: Colour, matrix: Array, **material: Any) -> bytes:
    """The packed message for a Meshcat geometry at `path`, with the pose `matrix` (4, 4) in its node."""
    from meshcat.geometry import Mesh, MeshLambertMaterial

    lowered = Mesh(geometry, MeshLambertMaterial(color=_rgb(colour), opacity=colour[3], **material)).lower()
    return packed_object(path, lowered, matrix)


def removed(path: str) -> bytes:
    """The packed message that takes away what is drawn at `path` and below."""
    return _packed({"type": "delete", "path": path})


def below(root: str, message: bytes) -> bytes:
    """The packed message with its node below the node `root`."""
    import umsgpack

    content = umsgpack.unpackb(message)
    return _packed({**content, "path": root + content["path"]})


def transform(path: str, matrix: Array) -> bytes:
    """The packed message that puts the node `path` at the pose `matrix` (4, 4)."""
    return _packed({"type": "set_transform", "path": path, "matrix": columns(matrix)})


def at(point: Array) -> Array:
    """The pose (4, 4) at a point (3,), not turned."""
    return pose_of(np.eye(3), point)


def columns(matrix: Array) -> list[float]:
    """The sixteen numbers of a (4, 4) matrix column by column, as three.js wants them."""
    numbers: list[float] = matrix.T.ravel().tolist()
    return numbers


def box(path: str, size: Sequence[float], colour: Colour, matrix: Array) -> bytes:
    """A box (x, y, z) [m] around the origin."""
    from meshcat.geometry import Box

    return set_object(path, Box([float(edge) for edge in size]), colour, matrix)


def sphere(path: str, radius: float, colour: Colour, matrix: Array) -> bytes:
    """A sphere [m] around the origin."""
    from meshcat.geometry import Sphere

    return set_object(path, Sphere(float(radius)), colour, matrix)


def cylinder(
    path: str, radius: float, length: float, colour: Colour, matrix: Array, top: float | None = None, **material: Any
) -> bytes:
    """A cylinder [m] along z around the origin. With `top`, the upper radius, it is a cone."""
    from meshcat.geometry import Cylinder

    upper = radius if top is None else top
    shape = Cylinder(float(length), radiusTop=float(upper), radiusBottom=float(radius))
    return set_object(path, shape, colour, matrix @ Y_TO_Z, **material)


def triangles(path: str, vertices: Array, normals: Array, faces: Any, colour: Colour, matrix: Array) -> bytes:
    """Triangles with vertices (N, 3), unit normals (N, 3) and faces (F, 3) of indices."""
    from meshcat.geometry import Mesh, MeshLambertMaterial, TriangularMeshGeometry, pack_numpy_array

    material = MeshLambertMaterial(color=_rgb(colour), opacity=colour[3])
    lowered = Mesh(TriangularMeshGeometry(vertices, faces), material).lower()
    attributes = lowered["geometries"][0]["data"]["attributes"]
    attributes["normal"] = pack_numpy_array(np.asarray(normals, dtype=np.float32).T)
    return packed_object(path, lowered, matrix)


def points(path: str, places: Array, colours: Array, size: float) -> bytes:
    """Points (N, 3) in colours (N, 3), as squares of `size` [m] that face the camera."""
    from meshcat.geometry import PointCloud

    return packed_object(path, PointCloud(places.T, colours.T, size=size / FIELD).lower(), np.eye(4))


def tube(path: str, line: Array, radius: float, colour: Colour) -> bytes:
    """Prisms of six sides along the segments of a line through points (N, 3). Repeated points count once."""
    line = line[np.any(np.diff(line, axis=0, prepend=np.nan), axis=1)]
    way = np.diff(line, axis=0)
    z = way / np.linalg.norm(way, axis=1, keepdims=True)
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z), axis=1)])
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    turn = np.pi / 3.0 * np.arange(6)[:, None, None]
    around = (np.cos(turn) * x + np.sin(turn) * np.cross(z, x)).reshape(-1, 3)
    start, end = (np.tile(points, (6, 1)) + radius * around for points in (line[:-1], line[1:]))
    first = np.arange(len(around))
    second, far = np.roll(first, -len(way)), len(around)
    faces = np.vstack([np.stack([first, second, second + far], 1), np.stack([first, second + far, first + far], 1)])
    return triangles(path, np.vstack([start, end]), np.vstack([around, around]), faces, colour, np.eye(4))


def rod(path: str, start: Array, end: Array, radius: float, colour: Colour, **material: Any) -> bytes:
    """A thin cylinder from `start` (3,) to `end` (3,)."""
    return cylinder(path, radius, float(np.linalg.norm(end - start)), colour, _along(start, end, 0.5), **material)


def arrow(path: str, start: Array, end: Array, radius: float, colour: Colour) -> list[bytes]:
    """An arrow from `start` to `end` [m], visible through other objects."""
    head = 6.0 * radius
    neck, tip = _along(start, end, 1.0, -head)[:3, 3], _along(start, end, 1.0, -0.5 * head)
    objects: list[bytes] = []
    for layer, tint, material in _visible_through(colour):
        objects.append(rod(f"{path}/{layer}-shaft", start, neck, radius, tint, **material))
        objects.append(cylinder(f"{path}/{layer}-head", 2.6 * radius, head, tint, tip, top=0.0, **material))
    return objects


def _visible_through(colour: Colour) -> list[tuple[str, Colour, dict[str, Any]]]:
    """The two layers of an object that is visible through others: name, colour, material."""
    red, green, blue, _ = colour
    glow = {"emissive": _rgb((0.25 * red, 0.25 * green, 0.25 * blue, 1.0))}
    return [
        ("solid", (red, green, blue, 1.0), glow),
        ("ghost", (red, green, blue, GHOST), {**glow, "depthTest": False}),
    ]


def triad(path: str, length: float) -> list[bytes]:
    """A frame: x red, y green, z blue, each an arrow of `length` [m]."""
    named = zip("xyz", length * np.eye(3), (RED, GREEN, BLUE), strict=True)
    arrows = [arrow(f"{path}/{name}", np.zeros(3), end, 0.025 * length, colour) for name, end, colour in named]
    return [part for parts in arrows for part in parts]


def axes(path: str, length: float) -> list[bytes]:
    """A frame as three thin rods without heads, hidden by objects in front."""
    named = zip("xyz", length * np.eye(3), (RED, GREEN, BLUE), strict=True)
    return [
        rod(f"{path}/{name}/{layer}", np.zeros(3), end, 0.02 * length, tint, **material)
        for name, end, colour in named
        for layer, tint, material in _visible_through(colour)
    ]


def _along(start: Array, end: Array, fraction: float, shift: float = 0.0) -> Array:
    """A pose at `fraction` of the way plus `shift` [m], with z from `start` to `end`."""
    z = (end - start) / np.linalg.norm(end - start)
    across = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.cross(across, z)
    x /= np.linalg.norm(x)
    return pose_of(np.column_stack([x, np.cross(z, x), z]), start + fraction * (end - start) + shift * z)


def _rgb(colour: Colour) -> int:
    red, green, blue = (min(255, max(0, math.floor(256 * part))) for part in colour[:3])
    return (red << 16) + (green << 8) + blue


def packed_object(path: str, lowered: dict[str, Any], matrix: Array) -> bytes:
    """The packed message for a lowered Meshcat object at `path`, with the pose `matrix` (4, 4) in its node."""
    lowered["object"]["matrix"] = columns(matrix)
    return _packed({"type": "set_object", "path": path, "object": lowered})


def _packed(message: dict[str, Any]) -> bytes:
    import umsgpack

    data: bytes = umsgpack.packb(message)
    return data
