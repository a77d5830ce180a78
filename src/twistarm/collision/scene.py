"""`Scene`: an arm's collision shapes, obstacles, and the questions about them."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from copy import copy
from dataclasses import replace
from functools import cached_property
from itertools import combinations
from math import isfinite
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ..arm.arm import Arm, require_arm
from ..arm.bodies import Body, Pair, Shapes, Triangles, in_words, sorted_pair
from ..arm.checker import Checker
from ..arm.pinocchio_model import import_pinocchio
from ..description.findings import Finding, finding
from ..support.checks import (
    Array,
    Given,
    Row,
    as_flag,
    as_floats,
    as_not_negative,
    as_number,
    as_pose,
    as_positive,
    as_vector,
    as_whole,
    require,
    require_callback,
    require_mapping,
    require_names,
)
from ..support.errors import InputError, TwistarmError, listed, shown, unknown_name
from ..support.files import as_path, writable, write_whole
from .allowed_pairs import allowed_pairs
from .answers import Collision, Contact, Distance
from .near_pairs import NearPairs
from .scene_file import Entry, SceneFile, read_scene, scene_text
from .swept import FINE, Sweep, pair_speeds, shifted

T = TypeVar("T")

Placed = tuple[Mapping[str, Body], Mapping[str, frozenset[str]]]
"""Obstacles by name, and what those that a link holds may touch."""

NUMBERS = {"box": 3, "sphere": 1, "cylinder": 2, "capsule": 2, "plane": 0, "mesh": 3}
"""How many numbers the size of an obstacle has."""


LARGEST = 100.0
"""The largest size of an obstacle [m]; a larger one is in millimetres, or a plane."""

NEARLY = 1e-3, 0.05
"""How much less than the clearance found a motion may have: so much [m], or this part of it."""

MOST_OBSTACLES = 2000
"""The most obstacles. The time to make a checker grows with the cube of their number: 2,000 take 1 s."""


class Scene:
    """The shapes of an arm's robot and of obstacles, with the pairs to check for collisions.

    A link has its collision shapes, otherwise its visuals, otherwise capsules to the joints that it carries. Meshes are
    replaced by their convex hulls; with `exact=True` they are kept. `findings` tell what each link has.

    `allowed` are the pairs of links that are not checked, with their reasons: the SRDF's, or those of
    `collision.allowed_pairs`. Obstacles are checked against every link that can move relative to them.

    `file` is the file that the scene was loaded from or saved to, or None. `exact` tells whether meshes are kept.
    """

    def __init__(
        self,
        arm: Arm,
        *,
        margin: float | Mapping[str, float] = 0.0,
        exact: bool = False,
        progress: Callable[[float], object] | None = None,
    ) -> None:
        """Read the shapes of `arm`, and find its allowed pairs if no SRDF names them.

        Args:
            arm: An arm with a description.
            margin: Distance [m] below which a pair collides: a number, or {link or obstacle: number}. The larger of
                two margins counts for a pair.
            exact: Check the triangles of meshes. It is slower, and an overlap has no depth.
            progress: Called with the fraction done while allowed pairs are found.

        Raises:
            InputError: The arm has no description, or a margin is negative.
        """
        description = require_arm(arm).description
        if description is None:
            raise InputError(f"{arm.name} has no description, so no shapes: load it from its URDF or xacro file")
        self.arm = arm
        self._description, self._model, self._shape = description, arm.pinocchio, (arm.n,)
        self._margin = _margins(margin)
        self.exact = as_flag(exact, "exact")
        self._progress = require_callback(progress, "progress", "(fraction)")
        with Shapes(import_pinocchio().coal, exact=self.exact) as shapes:
            self._links = tuple(shapes.of_links(description, arm.reach))
            self._unreadable: Mapping[str, list[str]] = shapes.unreadable
        self._obstacles: dict[str, Body] = {}
        self._touching: dict[str, frozenset[str]] = {}
        self._allowed_too: dict[Pair, str] = {}
        self._known_obstacles: set[str] = set()
        self._made: dict[str, Any] = {}  # the checker and the sweep of the present bodies
        self._loaded = SceneFile("", ())
        self.file: Path | None = None

    @classmethod
    def load(
        cls,
        arm: Arm,
        path: str | os.PathLike[str],
        *,
        margin: float | Mapping[str, float] | None = None,
        exact: bool = False,
        progress: Callable[[float], object] | None = None,
    ) -> Scene:
        """Read a scene.toml, MoveIt's planning scene (.yaml) or MoveIt's .scene text, for `arm`.

        `margin` replaces that of the file. A planning scene's allowed collision matrix replaces the allowed pairs.

        Args:
            arm: An arm with a description.
            path: The file.
            margin: Replaces the file's: a number [m], or {link or obstacle: number}.
            exact: Check the triangles of meshes.
            progress: Called with the fraction done while allowed pairs are found.

        Raises:
            InputError: An entry cannot be used, names an unknown link, or the file is for another arm.
            DescriptionError: The file cannot be read.
        """
        file = as_path(path)
        content = read_scene(file)
        if content.arm and content.arm != require_arm(arm).name:
            raise InputError(f"{file} is for the arm {content.arm!r}, not {arm.name!r}; change its entry arm to use it")
        asked = content.margin if margin is None else margin
        scene = cls(arm, margin=0.0 if asked is None else asked, exact=exact, progress=progress)
        try:
            scene._fill(content)
        except TwistarmError as error:
            raise InputError(f"{file}: {error}") from error
        scene.file = file
        return scene

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the obstacles, margins and pairs that may touch as a scene.toml, whole or not at all.

        Comments of a file that is replaced are lost. Meshes are named relative to the file.

        Args:
            path: A file that ends in .toml. An existing one must be a scene.toml.

        Returns:
            The path written.

        Raises:
            InputError: It cannot be written, or another kind of file is there.
        """
        target = writable(path, over_description=True)
        if target.suffix.lower() != ".toml":
            raise InputError(f"cannot write {target}: the name of a scene must end with .toml")
        if target.exists():
            try:
                read_scene(target)
            except TwistarmError as error:
                raise InputError(f"cannot write {target}: no scene.toml is there; give another name") from error
        self.file = write_whole(target, scene_text(self.content(), target.parent), over_description=True)
        return self.file

    def content(self) -> SceneFile:
        """What a file of this scene holds, with poses in the base frame or in that of the link that holds an object."""
        entries = []
        for name, body in self._obstacles.items():
            on = body.carrier if name in self._touching else ""
            pose = body.pose
            if not on and body.carrier != self.arm.base:
                pose = self._relative(self.arm.ready, self.arm.base, body.carrier) @ pose
            touching = tuple(sorted(self._touching.get(name, ())))
            entries.append(Entry(name, body.kind, body.size, pose, body.mesh, on, touching=touching))
        margin = self._margin
        if not isinstance(margin, float):
            known = {*self._obstacles, *self._description.links}
            margin = {name: metres for name, metres in margin.items() if name in known}
        return replace(self._loaded, entries=tuple(entries), allowed=tuple(self._allowed_too), margin=margin)

    def for_arm(self, arm: Arm, *, progress: Callable[[float], object] | None = None) -> Scene:
        """The same obstacles, margins and pairs for another arm.

        Args:
            arm: An arm with a description.
            progress: Called with the fraction done while allowed pairs are found.

        Raises:
            InputError: The arm lacks a link that the scene names.
        """
        scene = Scene(arm, margin=self._margin, exact=self.exact, progress=progress)
        scene._fill(self.content())
        scene.file = self.file
        return scene

    def __reduce__(self) -> tuple[Any, ...]:
        """The arm, the obstacles and the pairs found. Shapes are read again, from the same files."""
        return _again, (self.arm, self._margin, self.exact, self.content(), self._robots_pairs)

    def __repr__(self) -> str:
        return (
            f"Scene({self.arm.name}: {len(self._links)} bodies of links, obstacles {listed(self._obstacles) or 'none'})"
        )

    # -- what is in it -------------------------------------------------------------------------------------------

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        """What shape each link has, and the meshes that could not be read."""
        place = self._description.place()
        found = [
            finding("collision-shapes", place, f"{kind}: {listed(names)}", "check them in the view, layer Collision")
            for kind, names in in_words(self._links).items()
        ]
        bare = [name for name in self._description.links if name not in {body.name for body in self._links}]
        if bare:
            what = f"no shape, so never in collision: {listed(bare)}"
            found.append(finding("collision-shapes", place, what, "write collision shapes into the description"))
        for why, names in self._unreadable.items():
            remedy = "mend the file, or give the link a box or cylinder as collision shape"
            found.append(finding("collision-mesh-unreadable", place, f"{why}; left out of {listed(names)}", remedy))
        return tuple(found)

    @property
    def allowed(self) -> Mapping[Pair, str]:
        """Sorted pairs that are not checked, and why: "SRDF", "Adjacent", "Default", "Always", "Never", or a reason."""
        return {**self._robots_pairs, **self._allowed_too}

    def find_allowed_pairs(self) -> None:
        """Find the allowed pairs now, with `progress`, and not at the first question."""
        self.allowed  # noqa: B018

    @cached_property
    def _robots_pairs(self) -> Mapping[Pair, str]:
        """The pairs of links that the robot's SRDF, or the rules of `allowed_pairs`, exempt."""
        if self.arm.disabled_collisions:
            return dict.fromkeys(sorted(self.arm.disabled_collisions), "SRDF")
        return allowed_pairs(self.arm, self._model, self._description, self._links, progress=self._progress)

    @property
    def links(self) -> tuple[Body, ...]:
        """The bodies of the robot's links."""
        return self._links

    @property
    def obstacles(self) -> Mapping[str, Body]:
        """The obstacles and attached objects by name."""
        return dict(self._obstacles)

    def add_box(self, name: str, size: Row, pose: Given | None = None) -> None:
        """Add a box of `size` (3,) [m], its centre at `pose` (4, 4) or at a position (3,) in the base frame.

        Args:
            name: A name that no link and no obstacle has.
            size: The sides along x, y, z [m].
            pose: Pose (4, 4) or position (3,) in the base frame; by default its origin.
        """
        self._add(name, "box", as_vector(size, "size"), pose)

    def add_sphere(self, name: str, radius: float, pose: Given | None = None) -> None:
        """Add a sphere [m] with its centre at `pose` (4, 4) or at a position (3,).

        Args:
            name: A name that no link and no obstacle has.
            radius: Its radius [m].
            pose: Pose (4, 4) or position (3,) in the base frame; by default its origin.
        """
        self._add(name, "sphere", [radius], pose)

    def add_cylinder(self, name: str, radius: float, length: float, pose: Given | None = None) -> None:
        """Add a cylinder [m] along the z axis of `pose` (4, 4), its centre at the origin of `pose`.

        Args:
            name: A name that no link and no obstacle has.
            radius: Its radius [m].
            length: Its length [m].
            pose: Pose (4, 4) or position (3,) in the base frame; by default its origin.
        """
        self._add(name, "cylinder", [radius, length], pose)

    def add_capsule(self, name: str, radius: float, length: float, pose: Given | None = None) -> None:
        """Add a capsule [m] along the z axis of `pose` (4, 4). `length` is the distance of its two centres.

        Args:
            name: A name that no link and no obstacle has.
            radius: Its radius [m].
            length: The distance of its two centres [m].
            pose: Pose (4, 4) or position (3,) in the base frame; by default its origin.
        """
        self._add(name, "capsule", [radius, length], pose)

    def add_plane(self, name: str = "ground", pose: Given | None = None) -> None:
        """Add everything below the plane z = 0 of `pose` (4, 4); by default the plane of the base.

        Args:
            name: A name that no link and no obstacle has.
            pose: Pose (4, 4) or position (3,) in the base frame.
        """
        self._add(name, "plane", [], pose)

    def add_mesh(
        self, name: str, path: str | os.PathLike[str], pose: Given | None = None, *, scale: float | Row = 1.0
    ) -> None:
        """Add a mesh file (STL, DAE, OBJ) with its frame at `pose` (4, 4): its hull, or its triangles if `exact`.

        Args:
            name: A name that no link and no obstacle has.
            path: The file.
            pose: Pose (4, 4) or position (3,) in the base frame; by default its origin.
            scale: A factor, or one for each axis.
        """
        factors = [as_number(scale, "scale")] * 3 if np.ndim(scale) == 0 else as_vector(scale, "scale")
        self._add(name, "mesh", factors, pose, as_path(path))

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

    @property
    def placed(self) -> Placed:
        """The obstacles as they are now, for `put_back`. Equal as long as none changes."""
        return dict(self._obstacles), dict(self._touching)

    def put_back(self, placed: Placed) -> None:
        """Have the obstacles of an earlier `placed` again, and no others."""
        self._obstacles, self._touching = dict(placed[0]), dict(placed[1])
        self._changed()

    def resize(self, name: str, size: Row) -> None:
        """Give an obstacle another size.

        Args:
            name: The obstacle.
            size: The numbers of its kind [m], in the order of the `add_…` method; of a mesh its scale.
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

        The links of the same body and of its children may touch the object, and so may those in `touching`.

        Args:
            name: The obstacle.
            link: The link that carries it; by default that of the tip.
            theta: The configuration (n,) at which the link takes it.
            touching: Further links that may touch it.
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

    # -- questions -----------------------------------------------------------------------------------------------

    def collides(self, theta: ArrayLike, *, threads: int = 1) -> Any:
        """Whether some pair overlaps or is nearer than its margin at theta (..., n): a bool, or (...) of bool.

        Several configurations are shared among `threads`.

        Args:
            theta: Configurations (..., n) [rad, m].
            threads: How many threads share a batch.
        """
        # One array that is plainly right skips the checks, which take longer than the collisions.
        plain = type(theta) is np.ndarray and theta.dtype == np.float64 and theta.shape == self._shape
        if plain and isfinite(theta.dot(theta)):  # type: ignore[union-attr]
            return self._checker.collides(self._model.q(theta))  # type: ignore[arg-type]
        x = self.arm.theta_from(theta)
        if x.ndim == 1:
            return self._checker.collides(self._model.q(x))
        Q = np.array([self._model.q(row) for row in x.reshape(-1, self.arm.n)]).reshape(-1, self._model.model.nq)
        return self._checker.batch(Q, as_whole(threads, "threads", 1, 256)).reshape(x.shape[:-1])

    def distance(self, theta: ArrayLike) -> Distance:
        """The nearest pair at theta (n,), margins not counted."""
        x = self._one(theta)
        checker = self._checker
        metres = checker.distances(self._model.q(x))
        if not len(metres):
            return Distance(np.inf, (), np.empty((0, 3)))
        k = int(metres.argmin())
        points = (checker.points(k) - self._base(x)[:3, 3]) @ self._base(x)[:3, :3]
        return Distance(float(metres[k]), _names(checker, k), points)

    def contacts(self, theta: ArrayLike) -> tuple[Contact, ...]:
        """The pairs that collide at theta (n,), the deepest first."""
        q, checker = self._model.q(self._one(theta)), self._checker
        if not checker.collides(q):
            return ()
        hit = checker.overlapping(q)
        metres = checker.distances(q)
        worst: dict[tuple[str, str], Contact] = {}
        for k in sorted(hit, key=lambda k: metres[k]):
            first, second = _names(checker, k)
            worst.setdefault((first, second), Contact((first, second), float(metres[k]), checker.margins[k]))
        return tuple(worst.values())

    def first_collision(self, breakpoints: Given, coefficients: Given) -> Collision | None:
        """The first collision of a motion, without gaps; None if there is none.

        The motion is a piecewise polynomial as in `Trajectory`. A pair that is nearer than its margin by less than
        0.5 mm may be missed.

        Args:
            breakpoints: (s + 1,) [s].
            coefficients: (degree + 1, s, n), highest power first.
        """
        found = self._sweep.first(*self._pieces(breakpoints, coefficients))
        return None if found is None else Collision(*found, self.contacts(found[1]))

    def clearance(self, breakpoints: Given, coefficients: Given) -> Distance:
        """The nearest pair of bodies along a motion, with its `time` [s]; margins are not counted.

        The distance is measured there. No pair comes nearer anywhere, between samples either, than that less 1 mm or
        5 % of it, the larger. An interval is left when no pair can lose enough of its distance within it; else it is
        halved, for the pairs that can. The bounds are those of `first_collision`.

        Args:
            breakpoints: (s + 1,) [s].
            coefficients: (degree + 1, s, n), highest power first.
        """
        near, best, time, theta = self.near_pairs, np.inf, 0.0, self.arm.ready
        times, pieces = self._pieces(breakpoints, coefficients)
        every, halves = np.arange(len(near.pairs)), (0.5 * np.diff(times)).tolist()
        waiting = deque((times[k], pieces[:, k], half, half, every) for k, half in enumerate(halves))
        while waiting:
            begin, piece, middle, half, pairs = waiting.popleft()
            about = shifted(piece[:, None], np.array([middle]))[:, 0]
            metres = np.array(near.distances_of(about[-1], pairs))
            if metres.min(initial=np.inf) < best:
                best, time, theta = metres.min(), begin + middle, about[-1]
            moved = np.float_power(half, np.arange(len(piece) - 1, 0, -1)) @ np.abs(about[:-1])
            pairs = pairs[metres - near.speeds[pairs] @ moved < best - max(NEARLY[0], NEARLY[1] * best)]
            if len(pairs):
                waiting += [(begin, piece, middle + side, 0.5 * half, pairs) for side in (-0.5 * half, 0.5 * half)]
        return replace(self.distance(theta), time=time)

    def _pieces(self, breakpoints: Given, coefficients: Given) -> tuple[Array, Array]:
        """The breakpoints (s + 1,) and coefficients (degree + 1, s, n) of a motion, checked."""
        times, pieces = as_floats(breakpoints, "breakpoints"), as_floats(coefficients, "coefficients")
        wrong = times.ndim != 1 or pieces.shape[1:] != (len(times) - 1, self.arm.n) or not pieces.shape[0]
        if wrong or (np.diff(times) < 0.0).any():
            raise InputError(
                f"breakpoints must be (s + 1,) that increase, coefficients (degree + 1, s, {self.arm.n}); "
                f"got {times.shape} and {pieces.shape}"
            )
        return times, pieces

    def is_free(self, one: ArrayLike, other: ArrayLike) -> bool:
        """Whether the straight way in joint space from one configuration (n,) to another collides with nothing.

        Args:
            one: A configuration (n,), or the name of one.
            other: Another.
        """
        return self._sweep.straight(self._one(one), self._one(other))

    def leaving(self, theta: Array) -> Scene:
        """The scene for a motion from theta (n,): bodies that collide there count only if they come 0.5 mm nearer.

        It is the same scene if nothing collides there.
        """
        q, checker = self._model.q(theta), self._checker
        hit = checker.overlapping(q)
        if not hit:
            return self
        # By bodies: a link of several may not bring in another one.
        other, margins, metres = copy(self), list(checker.margins), checker.distances(q)
        for k in hit:
            margins[k] = min(margins[k], metres[k] - 2.0 * FINE)
        other._made = {"checker": checker.with_margins(margins)}
        return other

    @property
    def largest_margin(self) -> float:
        """The largest margin of a pair [m]."""
        return max(self._checker.margins, default=0.0)

    @property
    def near_pairs(self) -> NearPairs:
        """What finds the pairs that are near at a configuration."""
        return self._kept("near pairs", self._make_near_pairs)

    def _make_near_pairs(self) -> NearPairs:
        checker = self._checker
        return NearPairs(self._model, checker.bodies, checker.pairs, checker.margins, self._most)

    def checks(self, clearance: float) -> Callable[[Array], bool]:
        """A quick check of one configuration (n,): whether every pair keeps its margin and this clearance [m]."""
        checker, q = self._sweep.checker(clearance), self._model.q
        return lambda theta: not checker.collides(q(theta))

    # -- inside --------------------------------------------------------------------------------------------------

    def _fill(self, content: SceneFile) -> None:
        """Add what a file holds."""
        self._loaded = replace(content, entries=())
        for entry in content.entries:
            try:
                self._add(entry.name, entry.kind, entry.size, entry.pose, entry.mesh, self._fixed(entry.frame))
            except InputError as error:
                raise InputError(f"{entry.kind} {entry.name!r}: {error}") from error
            if entry.on:
                self._hold(entry.name, self._description.require_link(entry.on, "link"), entry.pose, entry.touching)
        if content.matrix:
            self.__dict__["_robots_pairs"] = {}
        for first, second in content.allowed:
            self.allow(first, second, "File")

    def _fixed(self, frame: str | None) -> str:
        """The link in whose frame a file gives a pose: the base for None, the root for "" and "world"."""
        if frame is None:
            return self.arm.base
        if frame in ("", "world"):
            return self._description.root
        link = self._description.require_link(frame, "frame_id")
        if self._joint_of(link):
            raise InputError(f"frame_id {frame!r} moves with the arm; give the pose in {self._description.root!r}")
        return link

    def _add(
        self,
        name: str,
        kind: str,
        size: Row,
        pose: Given | None,
        mesh: Path | Triangles | None = None,
        frame: str = "",
    ) -> None:
        if not isinstance(name, str) or not name or not name.isprintable():
            raise InputError(f"name must be a text on one line that is not empty; got {shown(name)}")
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

    def _shaped(self, kind: str, size: Row, mesh: Path | Triangles | None) -> tuple[Any, tuple[float, ...]]:
        """The shape of an obstacle, and the numbers of its size."""
        what = "scale" if kind == "mesh" else "size"
        numbers = as_vector(size, what, NUMBERS[kind])
        if numbers.ndim != 1:
            raise InputError(f"{what} must be {NUMBERS[kind]} numbers in a row; got shape {numbers.shape}")
        sizes = tuple(as_positive(number, what) for number in numbers.tolist())
        if max(sizes, default=0.0) > LARGEST:
            raise InputError(f"{what} must be at most {LARGEST:g} m; got {max(sizes):g}: lengths are in metres")
        with Shapes(import_pinocchio().coal, exact=self.exact) as shapes:
            if kind == "plane":
                return shapes.half_space(), sizes
            if isinstance(mesh, Triangles):
                return shapes.solid(mesh, sizes), sizes
            return (shapes.primitive(kind, sizes) if mesh is None else shapes.mesh(mesh, sizes)), sizes

    def _hold(self, name: str, carrier: str, pose: Array, touching: Iterable[str]) -> None:
        """Put an obstacle on a link, at `pose` (4, 4) in its frame."""
        if self._obstacles[name].kind == "plane":
            raise InputError(f"{name!r} is a plane without end, which no link can carry; attach a box instead")
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

    def _changed(self) -> None:
        # Another thread may still be making a checker of the bodies before: it goes into the mapping before.
        self._made = {}

    def _kept(self, what: str, make: Callable[[], T]) -> T:
        """What `make` makes of the present bodies, made once."""
        made = self._made
        if what not in made:
            made[what] = make()
        kept: T = made[what]
        return kept

    def _require_obstacle(self, name: str) -> Body:
        if not isinstance(name, str) or name not in self._obstacles:
            raise unknown_name(
                "obstacle",
                name,
                self._obstacles,
                within="the scene",
                listing=f"obstacles: {listed(self._obstacles) or 'none'}",
            )
        return self._obstacles[name]

    def _base(self, theta: Array) -> Array:
        """The base's pose (4, 4) in Pinocchio's world."""
        return self._model.link_pose(self._model.q(theta), self._description.root, self.arm.base)

    def _one(self, theta: ArrayLike) -> Array:
        """One configuration (n,), from numbers or a name."""
        x = self.arm.theta_from(theta)
        if x.ndim != 1:
            raise InputError(f"theta must be one configuration ({self.arm.n},); got {x.shape}")
        return x

    def _relative(self, theta: ArrayLike, frame: str, link: str) -> Array:
        return self._model.link_pose(self._model.q(self._one(theta)), frame, link)

    @property
    def _checker(self) -> Checker:
        return self._kept("checker", self._make_checker)

    def _make_checker(self) -> Checker:
        bodies = (*self._links, *self._obstacles.values())
        for name in () if isinstance(self._margin, float) else self._margin:
            if name not in self._known_obstacles:
                self._description.require_link(name, "margin")
        joints = [self._joint_of(body.carrier) for body in bodies]
        pairs = [
            (i, j)
            for i, j in combinations(range(len(bodies)), 2)
            if joints[i] != joints[j] and not self._exempt(bodies[i], bodies[j])
        ]
        # theta moves neither body of some pairs against the other, such as a passive wheel and the ground.
        speeds = pair_speeds(self._model, bodies, pairs, self._most)
        pairs = [pair for pair, row in zip(pairs, speeds, strict=True) if row.any()]
        return Checker(self._model, bodies, pairs, [self._margin_of(bodies[i], bodies[j]) for i, j in pairs])

    def _joint_of(self, link: str) -> int:
        """The joint that carries a link, by Pinocchio's number; 0 for the world."""
        return int(self._model.model.frames[self._model.frame_id(link)].parentJoint)

    @property
    def _sweep(self) -> Sweep:
        return self._kept("sweep", lambda: Sweep(self._checker, self._model, self._most))

    @property
    def _most(self) -> Array:
        """The greatest |theta| (n,) inside the arm's limits, and a little more, as bounds of motions are not tight."""
        most: Array = 1.1 * np.abs(self.arm.sampling_bounds).max(axis=0)
        return most

    def _exempt(self, one: Body, other: Body) -> bool:
        pair = sorted_pair(one.name, other.name)
        if pair in self._allowed_too:
            return True
        if one.obstacle or other.obstacle:
            return other.name in self._touching.get(one.name, ()) or one.name in self._touching.get(other.name, ())
        return pair in self._robots_pairs

    def _margin_of(self, one: Body, other: Body) -> float:
        if isinstance(self._margin, float):
            return self._margin
        return max(self._margin.get(one.name, 0.0), self._margin.get(other.name, 0.0))


def _names(checker: Checker, k: int) -> tuple[str, str]:
    i, j = checker.pairs[k]
    return checker.bodies[i].name, checker.bodies[j].name


def _again(
    arm: Arm, margin: float | Mapping[str, float], exact: bool, content: SceneFile, pairs: Mapping[Pair, str]
) -> Scene:
    """A scene that was pickled."""
    scene = Scene(arm, margin=margin, exact=exact)
    scene._fill(content)
    scene.__dict__["_robots_pairs"] = pairs
    return scene


def require_scene(scene: Any, arm: Arm) -> Scene:
    """The scene. InputError if it is none, or of an arm of another description or with other coordinates."""
    require(scene, Scene, "scene", "Scene(arm)")
    known, description = scene.arm, require_arm(arm).description
    same = description is not None and description.text == scene._description.text
    if not same or arm.joint_names != known.joint_names or arm.couplings != known.couplings:
        raise InputError(f"scene is one of {scene.arm.name}, not of this {arm.name}: make it with Scene(arm)")
    return scene  # type: ignore[no-any-return]


def _as_place(pose: Given | None) -> Array:
    """A pose (4, 4) from a pose, a position (3,) or None."""
    if pose is None:
        return np.eye(4)
    array = np.asarray(pose, dtype=object)
    if array.shape == (3,):
        g = np.eye(4)
        g[:3, 3] = as_vector(pose, "pose")  # type: ignore[arg-type]
        return g
    return as_pose(pose)


def _margins(margin: float | Mapping[str, float]) -> float | dict[str, float]:
    if isinstance(margin, Mapping):
        given = require_mapping(margin, "margin", '{"forearm": 0.02}')
        return {name: as_not_negative(value, f"margin[{name!r}]") for name, value in given.items()}
    return as_not_negative(margin, "margin")
