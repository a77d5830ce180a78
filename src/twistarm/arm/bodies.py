"""Bodies: the shapes of links and obstacles in Pinocchio's collision library."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..description.meshes import extreme_points, read_mesh
from ..description.tree import Description, Geometry, Link, Pair, sorted_pair
from ..support.checks import Array, pose_of
from ..support.errors import InputError, TwistarmError
from ..theory.joints import plane_axes
from .cloud import Cloud
from .solid import Solid

# Radius of a link's capsule: in reaches of the arm, and at most in lengths of the link.
THICK, STOUT = 0.025, 0.3
# A mesh that is flatter than this part of its length gets this thickness, because a hull needs a volume.
FLAT = 1e-6
# Qhull needs 4 s for 10,000 corners of one flat face, and 0.04 s once it has joggled them by 1e-8 of their size.
MANY_CORNERS = 4000
# The most triangles of one exact mesh, and of one whose hull is made. A finer mesh is simplified.
MOST_TRIANGLES, MOST_OF_A_HULL = 200_000, 50_000


class Triangles(NamedTuple):
    """A mesh by its numbers: points (N, 3) [m], and the three points of each of its faces (F, 3)."""

    points: Array
    faces: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Body:
    """A shape of the collision library, with its pose (4, 4) in the frame of the link `carrier`.

    `name` is the link's or the obstacle's. `kind` says how the shape was made. An obstacle has the numbers of its size
    [m]. A mesh has its file or triangles, a cloud its file or points (N, 3).
    """

    name: str
    carrier: str
    shape: Any
    pose: Array
    kind: str
    obstacle: bool = False
    size: tuple[float, ...] = ()
    mesh: Path | Triangles | Array | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.shape, Cloud):
            self.shape.computeLocalAABB()  # GJK starts from its centre, and its radius bounds the speeds

    @property
    def tiles(self) -> tuple[Body, ...]:
        """The bodies that are checked: one for each tile of a cloud, otherwise this one."""
        cloud = isinstance(self.shape, Cloud)
        return tuple(replace(self, shape=tile) for tile in self.shape.tiles) if cloud else (self,)

    @property
    def solid(self) -> Solid | None:
        """The triangles that are kept of a mesh. None for a convex shape."""
        return getattr(self.shape, "solid", None)

    @property
    def samples(self) -> Array:
        """A point (k, 3) of each connected part, in the frame of the shape; none of a plane."""
        if self.solid is not None:
            return self.solid.samples
        if self.kind == "points":
            return np.array(self.shape.toBoxes())[:, :3]
        if hasattr(self.shape, "points"):
            return np.array(self.shape.points()[:1])
        return np.zeros((0 if self.kind == "plane" else 1, 3))


class Shapes:
    """Makes shapes of the collision library, and each mesh file's once.

    A mesh becomes its convex hull. With `exact` it stays as it is. With `rough` it becomes the hull of its outermost
    points, which takes no other library. Formats other than STL then count as unreadable.
    """

    def __init__(self, coal: Any, *, exact: bool = False, rough: bool = False) -> None:
        self._coal, self._exact, self._rough = coal, exact, rough
        self._read: dict[tuple[Path, tuple[float, ...]], Any] = {}
        self.unreadable: dict[str, list[str]] = {}  # why a mesh is left out, and of which links

    def of_links(self, description: Description, reach: float) -> Iterator[Body]:
        """The bodies of all links: collision shapes, else visuals, else capsules to the joints that a link carries."""
        for link in description.links.values():
            bodies = [*self._of(link, link.collisions, "collision shape")]
            bodies = bodies or [*self._of(link, link.visuals, "visual")]
            yield from bodies or self._capsules(description, link, reach)

    def primitive(self, kind: str, size: tuple[float, ...]) -> Any:
        """A box (x, y, z), sphere (r,), cylinder or capsule (r, length), all [m]."""
        coal = self._coal
        return {"box": coal.Box, "cylinder": coal.Cylinder, "sphere": coal.Sphere, "capsule": coal.Capsule}[kind](*size)

    def half_space(self) -> Any:
        """Everything below the plane z = 0."""
        return self._coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)

    def mesh(self, path: Path, scale: tuple[float, ...]) -> Any:
        """The convex hull of a mesh file, or its triangles if shapes are exact. UnreadableMeshError for no mesh."""
        if (path, scale) not in self._read:
            if self._rough:
                shape = self._hull(extreme_points(path) * scale)
            else:
                mesh = read_mesh(path).solid(MOST_TRIANGLES if self._exact else MOST_OF_A_HULL)
                shape = self.solid(Triangles(*mesh), scale)
            self._read[path, scale] = shape
        return self._read[path, scale]

    def solid(self, mesh: Triangles, scale: tuple[float, ...]) -> Any:
        """The convex hull of triangles, or these themselves if shapes are exact."""
        points = mesh.points * scale
        if not self._exact:
            with suppress(RuntimeError):  # a corner of the hull has over 255 neighbours, as the tip of a fine cone
                return self._hull(points)
        return self._triangles(points, mesh.faces)

    def cloud(self, points: Array, voxel: float) -> Cloud:
        """The voxels of side `voxel` [m] that points (N, 3) occupy."""
        return Cloud(self._coal, points, voxel)

    def _of(self, link: Link, shapes: tuple[Geometry, ...], kind: str) -> Iterator[Body]:
        for geometry in shapes:
            if geometry.shape != "mesh":
                if min(geometry.size) > 0.0:
                    shape = self.primitive(geometry.shape, geometry.size)
                    yield Body(link.name, link.name, shape, geometry.origin, kind)
                continue
            try:
                if geometry.mesh is None:
                    raise InputError("a mesh file was not found")
                shape = self.mesh(geometry.mesh, geometry.size)
            except TwistarmError as error:
                names = self.unreadable.setdefault(str(error), [])
                if link.name not in names:
                    names.append(link.name)
                continue
            how = f"hull of a {kind}'s mesh" if isinstance(shape, self._coal.Convex) else f"{kind}'s mesh"
            yield Body(link.name, link.name, shape, geometry.origin, how)

    def _capsules(self, description: Description, link: Link, reach: float) -> Iterator[Body]:
        carried = [joint.origin[:3, 3] for joint in description.joints.values() if joint.parent == link.name]
        for end in carried:
            length = float(np.linalg.norm(end))
            if length > 1e-3 * reach:  # a shorter one is an offset, and too thin to see
                radius = min(THICK * reach, STOUT * length)
                shape = self.primitive("capsule", (radius, max(length - 2.0 * radius, 1e-3 * length)))
                yield Body(link.name, link.name, shape, along(end), "capsule")

    def _hull(self, points: Array) -> Any:
        """The hull, without points inside its flat faces unless these have too many corners for that."""

        def made(how: str) -> Any:
            corners = self._coal.StdVec_Vec3s()
            corners.extend(list(points))
            return self._coal.Convex.convexHull(corners, True, how)

        points = _with_volume(points)
        if len(points) > MANY_CORNERS:
            rough = made("QJ")
            points = np.array(rough.points())
            if len(points) > MANY_CORNERS:
                return rough
        return made("Qt")

    def _triangles(self, points: Array, faces: NDArray[np.int64]) -> Any:
        coal = self._coal
        model = coal.BVHModelOBBRSS()
        model.beginModel(len(faces), len(points))
        model.addVertices(points)
        model.addTriangles(faces)
        model.endModel()
        model.solid = Solid(points, faces)  # it goes where the shape goes
        return model


def _with_volume(points: Array) -> Array:
    """The distinct points. A flat mesh, or a line, is given a thickness."""
    points = np.unique(points, axis=0)
    centre = points.mean(axis=0)
    _, spread, axes = np.linalg.svd(points - centre, full_matrices=False)
    if len(points) < 3 or not spread[0] > 0.0:
        raise InputError("a mesh is a point, or a line of two points: it has no faces")
    for axis in axes[spread <= FLAT * spread[0]]:
        normal = axis * FLAT * np.abs(points - centre).max()
        points = np.concatenate([points - normal, points + normal])
    return points


def along(end: Array) -> Array:
    """The pose (4, 4) halfway to `end` (3,) with its z axis along it."""
    return pose_of(plane_axes(end), 0.5 * end)


def outline(shape: Any) -> dict[str, Any]:
    """The kind of a shape with its size [m], points (N, 3) and triangles (F, 3) where it has some, for drawing."""
    kind = type(shape).__name__.lower()
    if kind == "cloud":
        return {"kind": "points", "size": [shape.voxel], "points": shape.centres}
    if kind == "box":
        return {"kind": kind, "size": (2.0 * shape.halfSide).tolist()}
    if kind == "sphere":
        return {"kind": kind, "size": [shape.radius]}
    if kind in ("cylinder", "capsule"):
        return {"kind": kind, "size": [shape.radius, 2.0 * shape.halfLength]}
    if kind == "halfspace":
        return {"kind": "plane", "size": []}
    if kind == "convex":
        points, faces = shape.points(), [shape.polygons(i) for i in range(shape.num_polygons)]
    else:
        points, faces = shape.vertices(), [shape.tri_indices(i) for i in range(shape.num_tris)]
    corners = np.array([[face[0], face[1], face[2]] for face in faces])
    return {"kind": "mesh", "size": [], "points": points, "faces": corners}


def in_words(bodies: tuple[Body, ...]) -> Mapping[str, list[str]]:
    """The links by the kind of their shapes."""
    kinds: dict[str, list[str]] = {}
    for body in bodies:
        names = kinds.setdefault(body.kind, [])
        if body.name not in names:
            names.append(body.name)
    return kinds


def adjacent_pairs(description: Description, bodies: Iterable[Body]) -> set[Pair]:
    """Pairs of links with shapes that one joint connects, or a path through links without shapes."""
    near: dict[str, set[str]] = {name: set() for name in description.links}
    for joint in description.joints.values():
        near[joint.parent].add(joint.child)
        near[joint.child].add(joint.parent)
    shaped = {body.name for body in bodies} & near.keys()
    pairs = set()
    for start in shaped:
        seen, waiting = {start}, [start]
        while waiting:
            for name in near[waiting.pop()] - seen:
                seen.add(name)
                if name in shaped:
                    pairs.add(sorted_pair(start, name))
                else:
                    waiting.append(name)
    return pairs
