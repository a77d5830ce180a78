"""Obstacles beside an arm's robot: boxes, meshes, planes, and objects that links hold."""

from __future__ import annotations

import os
import time
from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arm.arm import Arm, require_arm
from ..arm.bodies import Body, Shapes, Triangles
from ..arm.pinocchio_model import import_pinocchio
from ..description.tree import Pair, sorted_pair
from ..support.checks import Array, Given, Row, as_flag, as_number, as_pose, as_positive, as_vector, require_names
from ..support.errors import InputError, listed, quote, unknown_name
from ..support.files import as_path
from ..support.units import TURN
from .cloud_files import as_points

Mesh = Path | Triangles | Array | None  # Of an obstacle: a file, triangles, or points (N, 3).
DOUBLE = np.dtype(np.float64)
PLAIN = (2.0 * TURN) ** 2  # Angles that look like degrees are beyond two turns. NaN is no less.

# How many numbers the size of an obstacle has.
NUMBERS = {"box": 3, "sphere": 1, "cylinder": 2, "capsule": 2, "plane": 0, "mesh": 3, "points": 1}
LARGEST = 100.0  # The largest size of an obstacle [m]; a larger one is in millimetres, or a plane.
# The most obstacles. The time to make a checker grows with the cube of their number: 2,000 take 1 s.
MOST_OBSTACLES = 2000
VOXEL = 0.02  # Side of the voxels of a cloud [m], the noise of a depth camera at 2 m.
# Points so near [m] to the arm's shapes, as its camera saw them, are the arm's own.
OWN = 0.02


class Obstacles:
    """The obstacles of a scene, by name, and the objects that links of its arm hold."""

    def __init__(self, arm: Arm, exact: bool) -> None:
        description = require_arm(arm).description
        if description is None:
            raise InputError(f"{arm.name} has no description, so no shapes: load it from its URDF or xacro file")
        self.arm = arm
        self._shape = (arm.n,)
        self._description, self._model = description, arm.pinocchio
        self.exact = as_flag(exact, "exact")
        self._links: tuple[Body, ...] = ()
        self._obstacles: dict[str, Body] = {}
        self._touching: dict[str, frozenset[str]] = {}
        self._allowed_too: dict[Pair, str] = {}
        self._known_obstacles: set[str] = set()
        self._cache: dict[str, Any] = {}  # the checker and the sweep of the present bodies

    @property
    def obstacles(self) -> Mapping[str, Body]:
        """The obstacles and attached objects by name."""
        return dict(self._obstacles)

    def add_box(self, name: str, size: Row, pose: Given | None = None) -> None:
        """Add a box of `size` (3,) [m], its centre at `pose` (4, 4) or at a position (3,) in the base frame.

        Args:
            name: A name that no link and no obstacle has.
            size: The sides along x, y, z [m].
            pose: Pose (4, 4) or position (3,) in the base frame. By default its origin.
        """
        self._add(name, "box", as_vector(size, "size"), pose)

    def add_sphere(self, name: str, radius: float, pose: Given | None = None) -> None:
        """Add a sphere [m] with its centre at `pose` (4, 4) or at a position (3,).

        Args:
            name: A name that no link and no obstacle has.
            radius: Its radius [m].
            pose: Pose (4, 4) or position (3,) in the base frame. By default its origin.
        """
        self._add(name, "sphere", [radius], pose)

    def add_cylinder(self, name: str, radius: float, length: float, pose: Given | None = None) -> None:
        """Add a cylinder [m] along the z axis of `pose` (4, 4), its centre at the origin of `pose`.

        Args:
            name: A name that no link and no obstacle has.
            radius: Its radius [m].
            length: Its length [m].
            pose: Pose (4, 4) or position (3,) in the base frame. By default its origin.
        """
        self._add(name, "cylinder", [radius, length], pose)

    def add_capsule(self, name: str, radius: float, length: float, pose: Given | None = None) -> None:
        """Add a capsule [m] along the z axis of `pose` (4, 4). `length` is the distance of its two centres.

        Args:
            name: A name that no link and no obstacle has.
            radius: Its radius [m].
            length: The distance of its two centres [m].
            pose: Pose (4, 4) or position (3,) in the base frame. By default its origin.
        """
        self._add(name, "capsule", [radius, length], pose)

    def add_plane(self, name: str = "ground", pose: Given | None = None) -> None:
        """Add everything below the plane z = 0 of `pose` (4, 4). By default the plane of the base.

        Args:
            name: A name that no link and no obstacle has.
            pose: Pose (4, 4) or position (3,) in the base frame.
        """
        self._add(name, "plane", [], pose)

    def add_mesh(
        self, name: str, path: str | os.PathLike[str], pose: Given | None = None, *, scale: float | Row = 1.0
    ) -> None:
        """Add a mesh file (STL, DAE, OBJ) with its frame at `pose` (4, 4). It counts as its hull, or as triangles if
        `exact`.

        Args:
            name: A name that no link and no obstacle has.
            path: The file.
            pose: Pose (4, 4) or position (3,) in the base frame. By default its origin.
            scale: A factor, or one for each axis.
        """
        factors = [as_number(scale, "scale")] * 3 if np.ndim(scale) == 0 else as_vector(scale, "scale")
        self._add(name, "mesh", factors, pose, as_path(path))

    def add_points(
        self,
        name: str,
        points: Given | str | os.PathLike[str],
        voxel: float = VOXEL,
        pose: Given | None = None,
        *,
        without_arm: bool = False,
        theta: ArrayLike | None = None,
    ) -> None:
        """Add a point cloud: every voxel that holds a point is an obstacle, whole.

        Voxels are cubes along the axes of the cloud's frame. An overlap has the depth of one of its voxels.

        Args:
            name: A name that no link and no obstacle has.
            points: Points (N, 3) [m] in the frame of the cloud, or a .ply, .pcd, .npy, .xyz, .txt or .csv file.
            voxel: Side of the voxels [m].
            pose: Pose (4, 4) or position (3,) of the cloud's frame in the base frame. By default its origin.
            without_arm: Leave out points within 20 mm of the arm's shapes at `theta`.
            theta: The configuration (n,) in which the arm stood. By default its ready one.
        """
        place = _as_place(pose)
        given: Path | Array = as_path(points) if isinstance(points, (str, os.PathLike)) else as_points(points)
        if as_flag(without_arm, "without_arm"):
            given = self._beside_arm(as_points(given), place, self.arm.ready if theta is None else theta)
        elif theta is not None:
            raise InputError("theta is where the arm stood for without_arm=True; give both, or none of them")
        self._add(name, "points", [voxel], place, given)

    def replace_points(
        self, name: str, points: Given, *, without_arm: bool = False, theta: ArrayLike | None = None
    ) -> None:
        """Replace the points of a cloud at once, also while another thread plans or a servo runs.

        The scene changes when all that its questions need is made. Only then do they see the new points.

        Args:
            name: A cloud that was added.
            points: As for `add_points`.
            without_arm: As for `add_points`.
            theta: As for `add_points`.
        """
        body = self._require_obstacle(name)
        if body.kind != "points":
            raise InputError(f"{name!r} is a {body.kind}, no cloud; remove it, then add_points")
        other = copy(self)
        other._cache = {}
        del other._obstacles[name]
        other.add_points(name, points, body.size[0], body.pose, without_arm=without_arm, theta=theta)
        other._obstacles[name] = replace(other._obstacles[name], carrier=body.carrier)
        other._prepare()
        tiles, before = list(body.shape.tiles), self._cache
        vars(self).update(vars(other))  # all at once for other threads, with the pairs found meanwhile
        del body, before, other
        while tiles:  # To free all octrees at once would hold the interpreter for 15 ms.
            tiles.pop()
            time.sleep(0.0)

    def allow(self, first: str, second: str, reason: str = "User") -> None:
        """Do not check a pair of links or obstacles any more.

        Args:
            first: A link or obstacle.
            second: Another one.
            reason: What `allowed` and files tell of it.
        """
        for name in require_names((first, second, reason), "first, second and reason")[:2]:
            if name not in self._obstacles:
                self._description.require_link(name, "link or obstacle")
        self._allowed_too[sorted_pair(first, second)] = reason
        self._changed()

    def move(self, name: str, pose: Given) -> None:
        """Put an obstacle at another pose (4, 4) or position (3,) in the base frame.

        Args:
            name: An obstacle that no link holds.
            pose: Its pose, or its position without a rotation.
        """
        body = self._require_obstacle(name)
        if name in self._touching:
            raise InputError(f"{body.carrier} holds {name!r}: detach it before you move it")
        self._obstacles[name] = replace(body, carrier=self.arm.base, pose=_as_place(pose))
        self._changed()

    def resize(self, name: str, size: Row) -> None:
        """Give an obstacle another size.

        Args:
            name: The obstacle.
            size: The numbers of its kind [m], in the order of the `add_…` method. For a mesh its scale.
        """
        body = self._require_obstacle(name)
        shape, sizes = self._shaped(body.kind, size, body.mesh)
        self._obstacles[name] = replace(body, shape=shape, size=sizes)
        self._changed()

    def remove(self, name: str) -> None:
        """Remove an obstacle or attached object."""
        self._require_obstacle(name)
        del self._obstacles[name]
        self._touching.pop(name, None)
        self._allowed_too = {pair: why for pair, why in self._allowed_too.items() if name not in pair}
        self._changed()

    def attach(self, name: str, link: str | None = None, *, theta: ArrayLike, touching: Iterable[str] = ()) -> None:
        """Let `link`, by default the tip, carry an obstacle that it holds at theta (n,).

        The links of the same body and of its children may touch the object. So may those in `touching`.

        Args:
            name: The obstacle.
            link: The link that carries it. By default that of the tip.
            theta: The configuration (n,) at which the link takes it.
            touching: Further links that may touch it (MoveIt's touch_links).
        """
        body = self._require_obstacle(name)
        carrier = self._description.require_link(link or self.arm.tip_link, "link")
        self._hold(name, carrier, self._relative(theta, carrier, body.carrier) @ body.pose, touching)

    def detach(self, name: str, *, theta: ArrayLike) -> None:
        """Put an attached object down where it is at theta (n,).

        Args:
            name: The object.
            theta: The configuration (n,) at which it is put down.
        """
        body = self._require_obstacle(name)
        g = self._relative(theta, self.arm.base, body.carrier)
        self._obstacles[name] = replace(body, carrier=self.arm.base, pose=g @ body.pose)
        self._touching.pop(name, None)
        self._changed()

    def _add(self, name: str, kind: str, size: Row, pose: Given | None, mesh: Mesh = None, frame: str = "") -> None:
        if not isinstance(name, str) or not name or not name.isprintable():
            raise InputError(f"name must be a text on one line that is not empty; got {quote(name)}")
        if len(self._obstacles) >= MOST_OBSTACLES:
            raise InputError(
                f"the scene has {MOST_OBSTACLES} obstacles, the most that it takes; join some in one mesh for add_mesh"
            )
        if name in self._obstacles or name in self._description.links:
            what = "an obstacle" if name in self._obstacles else "a link"
            raise InputError(f"name: {what} is already called {name!r}; choose another name, or remove it first")
        shape, sizes = self._shaped(kind, size, mesh)
        self._obstacles[name] = Body(name, frame or self.arm.base, shape, _as_place(pose), kind, True, sizes, mesh)
        self._known_obstacles.add(name)
        self._changed()

    def _shaped(self, kind: str, size: Row, mesh: Mesh) -> tuple[Any, tuple[float, ...]]:
        """The shape of an obstacle, and the numbers of its size."""
        what = {"mesh": "scale", "points": "voxel"}.get(kind, "size")
        numbers = as_vector(size, what, NUMBERS[kind])
        if numbers.ndim != 1:
            raise InputError(f"{what} must be {NUMBERS[kind]} numbers in a row; got shape {numbers.shape}")
        sizes = tuple(as_positive(number, what) for number in numbers.tolist())
        if max(sizes, default=0.0) > LARGEST:
            raise InputError(f"{what} must be at most {LARGEST:g} m; got {max(sizes):g}: lengths are in metres")
        shapes = Shapes(import_pinocchio().coal, exact=self.exact)
        if kind == "plane":
            return shapes.half_space(), sizes
        if isinstance(mesh, Triangles):
            return shapes.solid(mesh, sizes), sizes
        if kind == "points" or isinstance(mesh, np.ndarray):
            return shapes.cloud(as_points(mesh) if isinstance(mesh, Path) else np.asarray(mesh), *sizes), sizes
        return (shapes.primitive(kind, sizes) if mesh is None else shapes.mesh(mesh, sizes)), sizes

    def _hold(self, name: str, carrier: str, pose: Array, touching: Iterable[str]) -> None:
        """Put an obstacle on a link, at `pose` (4, 4) in its frame."""
        if (kind := self._obstacles[name].kind) in ("plane", "points"):
            raise InputError(f"no link can carry the {kind} {name!r}; attach a box or a mesh instead")
        touched = require_names(touching, "touching")
        for other in touched:
            self._description.require_link(other, "touching")
        self._obstacles[name] = replace(self._obstacles[name], carrier=carrier, pose=pose)
        body = {link for link in self._description.links if self._joint_of(link) == self._joint_of(carrier)}
        children = [joint.name for joint in self._description.joints.values() if joint.parent in body and joint.moving]
        beyond = (
            {link for joint in children for link in self._description.beyond(joint)} if self._joint_of(carrier) else ()
        )
        self._touching[name] = frozenset({*body, *beyond, *touched})
        self._changed()

    def _beside_arm(self, points: Array, place: Array, theta: ArrayLike) -> Array:
        """The points (k, 3), in the frame at `place`, that are not the arm's own at theta (n,)."""
        coal = import_pinocchio().coal
        own, x = np.zeros(len(points), dtype=bool), self._configuration(theta)
        request, ball = coal.CollisionRequest(), coal.Sphere(OWN)
        for body in self._links:
            to_body = np.linalg.inv(self._relative(x, self.arm.base, body.carrier) @ body.pose) @ place
            there = points @ to_body[:3, :3].T + to_body[:3, 3]
            box = body.shape.aabb_local
            for i in np.flatnonzero(((there > box.min_ - OWN) & (there < box.max_ + OWN)).all(axis=1) & ~own):
                at = coal.Transform3s(np.eye(3), there[i])
                own[i] = coal.collide(body.shape, coal.Transform3s(), ball, at, request, coal.CollisionResult())
        return points[~own]

    def _prepare(self) -> None:
        """Make what questions need of the present bodies."""

    def _changed(self) -> None:
        # Another thread may still be making a checker of the bodies before: it goes into the mapping before.
        self._cache = {}

    def _require_obstacle(self, name: str) -> Body:
        if not isinstance(name, str) or name not in self._obstacles:
            listing = f"obstacles: {listed(self._obstacles) or 'none'}"
            raise unknown_name("obstacle", name, self._obstacles, within="the scene", listing=listing)
        return self._obstacles[name]

    def _configuration(self, theta: ArrayLike) -> Array:
        """One configuration (n,), from numbers or a name."""
        x = self._plain(theta)
        if x is None:
            x = self.arm.theta_from(theta)
        if x.ndim != 1:
            raise InputError(f"theta must be one configuration ({self.arm.n},); got {x.shape}")
        return x

    def _plain(self, theta: Any) -> Array | None:
        """Theta if it is one array (n,) that is plainly right. The checks would take longer than the collisions."""
        if type(theta) is np.ndarray and theta.dtype is DOUBLE and theta.shape == self._shape:
            return theta if theta.dot(theta) <= PLAIN else None
        return None

    def _relative(self, theta: ArrayLike, frame: str, link: str) -> Array:
        return self._model.link_poses([self._model.q(self._configuration(theta))], frame, [link])[link][0]

    def _joint_of(self, link: str) -> int:
        """The joint that carries a link, by Pinocchio's number; 0 for the world."""
        return int(self._model.model.frames[self._model.frame_id(link)].parentJoint)


def _as_place(pose: Given | None) -> Array:
    """A pose (4, 4) from a pose, a position (3,) or None."""
    if pose is None:
        return np.eye(4)
    pose = getattr(pose, "g", pose)  # of a Pose
    array = np.asarray(pose, dtype=object)
    if array.shape == (3,):
        g = np.eye(4)
        g[:3, 3] = as_vector(pose, "pose")  # type: ignore[arg-type]
        return g
    return as_pose(pose)
