"""`Scene`: an arm's collision shapes, obstacles, and the questions about them."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arm.arm import Arm, require_arm
from ..arm.bodies import Body, in_words
from ..description.findings import Finding, Place, finding
from ..description.tree import Pair
from ..support.checks import Array, Given, as_floats, as_whole, require
from ..support.errors import InputError, TwistarmError, listed, quote
from ..support.files import as_path, writable, write_whole
from ..support.messages import Argument, Text
from .answers import Collision, Contact, Distance
from .checkers import Checkers
from .scene_file import Entry, SceneFile, read_scene, scene_text, with_points_in_files
from .swept import FINE, shifted

FAR = 2.0  # A cloud whose nearest point is so many times the arm's reach away is in another unit or frame.
SLACK = 1e-3, 0.05  # How much less than the clearance found a motion may have: so much [m], or this part of it.


class Scene(Checkers):
    """The shapes of an arm's robot and of obstacles, with the pairs to check for collisions.

    A link has its collision shapes, otherwise its visuals, otherwise capsules to the joints that it carries. Meshes are
    replaced by their convex hulls. With `exact=True` they are kept. `findings` tell what each link has.

    `allowed` are the pairs of links that are not checked, with their reasons. They come from the SRDF, or from
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
            exact: Check the triangles of meshes. It is slower, and surfaces that meet have no depth. A closed mesh is
                solid: a body wholly inside collides, by its distance from the surface.
            progress: Called with the fraction done while allowed pairs are found.

        Raises:
            InputError: The arm has no description, or a margin is negative.
        """
        super().__init__(arm, margin, exact, progress)
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
        description = require_arm(arm).description
        content = read_scene(file, description.links if description else ())
        if content.arm and content.arm != arm.name:
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

        Comments in the file are lost. Meshes are named relative to it. A cloud without a file is written beside it.

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
        text = scene_text(with_points_in_files(self.content(), target), target.parent)
        self.file = write_whole(target, text, over_description=True)
        return self.file

    def content(self) -> SceneFile:
        """What a file of this scene holds. Poses are in the base frame, or in that of the link that holds an object."""
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
        scene = _rebuilt(arm, self._margin, self.exact, self.content(), None, progress)
        scene.file = self.file
        return scene

    def __reduce__(self) -> tuple[Any, ...]:
        """The arm, the obstacles and the pairs found. Shapes are read again, from the same files."""
        given = self.arm, self._margin, self.exact, self.content(), self.find_allowed_pairs()
        return _rebuilt, given, {"file": self.file}

    def __copy__(self) -> Scene:
        """Another scene with the same bodies. By `__reduce__` a copy would read and build them all again."""
        other = object.__new__(type(self))
        for name, value in vars(self).items():  # what is added to one scene is not in the other
            vars(other)[name] = copy(value) if isinstance(value, (dict, set)) else value
        return other

    def __repr__(self) -> str:
        return (
            f"Scene({self.arm.name}: {len(self._links)} bodies of links, obstacles {listed(self._obstacles) or 'none'})"
        )

    # -- what is in it -------------------------------------------------------------------------------------------

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What shape each link has, the meshes that could not be read, and those that are open."""
        place = self._description.place()
        kinds = {kind: listed(names) for kind, names in in_words(self._links).items()}
        if bare := [name for name in self._description.links if name not in {body.name for body in self._links}]:
            kinds["no collision shape, so not checked"] = listed(bare)  # frames without a body
        own = [f"{kind}: {names}" for kind, names in kinds.items() if "collision shape" in kind]
        found = [finding("collision-shapes", place, what, "check them in the view, layer Collision") for what in own]
        if others := [f"{kind}: {names}" for kind, names in kinds.items() if "collision shape" not in kind]:
            what = f"links without collision shapes are checked by other shapes: {'; '.join(others)}"
            found.append(finding("no-collision-shapes", place, what, "write collision shapes into the description"))
        for why, names in self._unreadable.items():
            remedy = "mend the file, or give the link a box or cylinder as collision shape"
            found.append(finding("mesh-unreadable", place, f"{why}; left out of {listed(names)}", remedy))
        bodies = (*self._links, *self._obstacles.values())
        open_ones = dict.fromkeys(body.name for body in bodies if body.solid is not None and not body.solid.closed)
        if open_ones:
            what = f"the triangles are not closed, so what is wholly inside counts as free: {listed(open_ones)}"
            found.append(finding("mesh-open", place, what, "close the holes of the mesh, or leave out exact"))
        for name, body in self._obstacles.items():
            if body.kind == "points" and body.carrier == self.arm.base and len(body.shape.centres):
                near = float(np.linalg.norm(body.shape.centres @ body.pose[:3, :3].T + body.pose[:3, 3], axis=1).min())
                if near > FAR * self.arm.reach:
                    what = (
                        f"{name!r} is {near:.3g} m from the base at least, and the arm reaches {self.arm.reach:.3g} m"
                    )
                    remedy = "check the unit of its points, which must be metres, and its pose"
                    found.append(finding("points-far", Place(str(self.file or "")), what, remedy))
        if absent := self._loaded.absent:
            what = f"the scene has no such link or object, so what may touch them is left out: {listed(absent)}"
            remedy = "check that the scene is of this robot"
            found.append(finding("scene-names", Place(str(self.file or "")), what, remedy))
        driven = {name for name, affine in self.arm.couplings.items() if affine.master in self.arm.joint_names}
        stands = {name: float(x) for name, x in self.arm.joint_values(self.arm.ready).items() if name not in driven}
        moved = [f"joint_state of {name}" for name, x in self._loaded.state if abs(x - stands.get(name, x)) > FINE]
        if unread := dict.fromkeys([*self._loaded.unread, *moved]):
            remedy = Text("write shapes, padding as margin, joints as {locked}", locked=Argument("locked_joints", None))
            found.append(finding("scene-names", Place(str(self.file or "")), f"not used: {listed(unread)}", remedy))
        return tuple(found)

    # -- questions -----------------------------------------------------------------------------------------------

    def collides(self, theta: ArrayLike, *, threads: int = 1) -> Any:
        """Whether some pair overlaps or is nearer than its margin at theta (..., n): a bool, or (...) of bool.

        Several configurations are shared among `threads`.

        Args:
            theta: Configurations (..., n) [rad, m].
            threads: How many threads share a batch.
        """
        x = self._plain(theta)
        if x is None:
            x = self.arm.theta_from(theta)
        if x.ndim == 1:
            return self._checker.collides(self._model.q(x))
        Q = x.reshape(-1, self.arm.n) @ self._model.dq_dtheta.T + self._model.q(np.zeros(self.arm.n))
        return self._checker.batch(Q, as_whole(threads, "threads", 1, 256)).reshape(x.shape[:-1])

    def distance(self, theta: ArrayLike) -> Distance:
        """The nearest pair at theta (n,), margins not counted."""
        x, near = self._configuration(theta), self.near_pairs
        if not len(near.body_pairs):
            return Distance(np.inf, (), np.empty((0, 3)))
        k, metres, points = near.nearest(x)
        base = self._base(x)
        return Distance(metres, _names(near.bodies, near.body_pairs[k]), (points - base[:3, 3]) @ base[:3, :3])

    def contacts(self, theta: ArrayLike) -> tuple[Contact, ...]:
        """The pairs that collide at theta (n,), the deepest first."""
        q, checker = self._model.q(self._configuration(theta)), self._checker
        if not checker.collides(q):
            return ()
        hit = checker.overlapping(q)
        worst: dict[tuple[str, str], Contact] = {}
        for metres, k in sorted(zip(checker.distances(q, hit).tolist(), hit, strict=True)):
            first, second = _names(checker.bodies, checker.pairs[k])
            worst.setdefault((first, second), Contact((first, second), metres, checker.margins[k]))
        return tuple(worst.values())

    def first_collision(self, motion: Any, coefficients: Given | None = None) -> Collision | None:
        """The first collision of a motion, without gaps, or None.

        A pair that is nearer than its margin by less than 0.5 mm may be missed.

        Args:
            motion: A `Trajectory`, or the breakpoints (s + 1,) [s] of a piecewise polynomial.
            coefficients: Those of the polynomial, (degree + 1, s, n), highest power first.
        """
        found = self._sweep.first(*self._pieces(motion, coefficients))
        return None if found is None else Collision(*found, self.contacts(found[1]))

    def clearance(self, motion: Any, coefficients: Given | None = None) -> Distance:
        """The nearest pair of bodies along a motion, with its `time` [s]. Margins are not counted.

        The distance is exact at that time. At other times a pair may come nearer by at most 1 mm or 5 % of it, the
        larger. An interval is left when no pair can lose enough of its distance within it. Otherwise it is halved, for
        the pairs that can. The bounds are those of `first_collision`.

        Args:
            motion: A `Trajectory`, or the breakpoints (s + 1,) [s] of a piecewise polynomial.
            coefficients: Those of the polynomial, (degree + 1, s, n), highest power first.
        """
        near, best, time, theta = self.near_pairs, np.inf, 0.0, self.arm.ready
        times, pieces = self._pieces(motion, coefficients)
        every, halves = np.arange(len(near.body_pairs)), (0.5 * np.diff(times)).tolist()
        waiting = deque((times[k], pieces[:, k], half, half, every) for k, half in enumerate(halves))
        while waiting:
            # Long intervals first: a small distance that is found early rules out most of the others.
            begin, piece, middle, half, pairs = waiting.popleft()
            about = shifted(piece[:, None], np.array([middle]))[:, 0]
            moved = np.float_power(half, np.arange(len(piece) - 1, 0, -1)) @ np.abs(about[:-1])
            low, lost = near.bounds(about[-1], moved, pairs), near.speeds[pairs] @ moved
            counts = low < best + np.maximum(lost - SLACK[0], 0.0)
            pairs, lost = pairs[counts], lost[counts]
            metres = near.distances_of(about[-1], pairs)
            if metres.min(initial=np.inf) < best:
                best, time, theta = metres.min(), begin + middle, about[-1]
            pairs = pairs[metres - lost < best - max(SLACK[0], SLACK[1] * best)]
            if len(pairs):
                waiting += [(begin, piece, middle + side, 0.5 * half, pairs) for side in (-0.5 * half, 0.5 * half)]
        return replace(self.distance(theta), time=time)

    def _pieces(self, motion: Any, coefficients: Given | None) -> tuple[Array, Array]:
        """The breakpoints (s + 1,) and coefficients (degree + 1, s, n) of a motion, checked."""
        if coefficients is None:
            if not hasattr(motion, "coefficients"):
                raise InputError(f"motion must be a Trajectory, or breakpoints and coefficients; got {quote(motion)}")
            motion, coefficients = motion.breakpoints, motion.coefficients
        times, pieces = as_floats(motion, "breakpoints"), as_floats(coefficients, "coefficients")
        wrong = times.ndim != 1 or pieces.shape[1:] != (len(times) - 1, self.arm.n) or not pieces.shape[0]
        if wrong or (np.diff(times) < 0.0).any():
            raise InputError(
                f"breakpoints must be (s + 1,) that increase, coefficients (degree + 1, s, {self.arm.n}); "
                f"got {times.shape} and {pieces.shape}"
            )
        return times, pieces

    def is_free(self, start: ArrayLike, end: ArrayLike) -> bool:
        """Whether the straight path in joint space from one configuration (n,) to another collides with nothing.

        Args:
            start: A configuration (n,), or the name of one.
            end: Another.
        """
        return self._sweep.straight(self._configuration(start), self._configuration(end))

    def leaving(self, theta: ArrayLike) -> Scene:
        """The scene for a motion from theta (n,). A pair that collides there may stay, but not come 0.5 mm nearer.

        It is the same scene if nothing collides there. Triangles of `exact=True` and voxels of a cloud overlap without
        a depth. A motion cannot leave them.
        """
        q, checker = self._model.q(self._configuration(theta)), self._checker
        hit = checker.overlapping(q)
        if not hit:
            return self
        # By bodies: a link of several may not bring in another one.
        other, margins = copy(self), list(checker.margins)
        for k, metres in zip(hit, checker.distances(q, hit).tolist(), strict=True):
            margins[k] = min(margins[k], metres - 2.0 * FINE)
        other._cache = {"checker": checker.with_margins(margins)}
        return other

    # -- inside --------------------------------------------------------------------------------------------------

    def _fill(self, content: SceneFile) -> None:
        """Add what a file holds."""
        known = {*self._description.links, *(entry.name for entry in content.entries)}
        absent = list(content.absent)

        def there(names: Iterable[str]) -> bool:
            """Whether the robot or the file has all of these, or must have."""
            missing = [name for name in names if content.foreign and name not in known]
            absent.extend(missing)
            return not missing

        for entry in content.entries:
            try:
                self._add(entry.name, entry.kind, entry.size, entry.pose, entry.mesh, self._fixed(entry.frame))
            except InputError as error:
                raise InputError(f"{entry.kind} {entry.name!r}: {error}") from error
            if entry.on:
                touching = [link for link in entry.touching if there([link])]
                self._hold(entry.name, self._description.require_link(entry.on, "link"), entry.pose, touching)
        if content.matrix:
            self._found_pairs = {}
        for pair in content.allowed:
            if there(pair):
                self.allow(*pair, "File")
        self._loaded = replace(content, entries=(), foreign=False, absent=tuple(dict.fromkeys(absent)))

    def _fixed(self, frame: str | None) -> str:
        """The link of a pose's frame in a file: the base for None, the root for "", "world" and what it is fixed to."""
        if frame is None:
            return self.arm.base
        root, semantics = self._description.root, self._description.semantics
        if frame in ("", "world") or (semantics and (frame, root) in semantics.virtual_joints.values()):
            return root
        link = self._description.require_link(frame, "frame_id")
        if self._joint_of(link):
            raise InputError(f"frame_id {frame!r} moves with the arm; give the pose in {root!r}")
        return link

    def _prepare(self) -> None:
        self.collides(self.arm.ready)
        self.distance(self.arm.ready)
        self._sweep.checker(0.0)


def _names(bodies: Sequence[Body], pair: tuple[int, int]) -> tuple[str, str]:
    return bodies[pair[0]].name, bodies[pair[1]].name


def _rebuilt(
    arm: Arm, margin: float | Mapping[str, float], exact: bool, content: SceneFile, pairs: Mapping[Pair, str] | None,
    progress: Callable[[float], object] | None = None,
) -> Scene:  # fmt: skip
    """A scene with the content of another one, and its pairs if they are found."""
    scene = Scene(arm, margin=margin, exact=exact, progress=progress)
    scene._fill(content)
    scene._found_pairs = scene._found_pairs if pairs is None else pairs
    return scene


def require_scene(scene: Any, arm: Arm) -> Scene:
    """The scene. Raises InputError for another object, or if its arm has another description or other coordinates."""
    require(scene, Scene, "scene", "Scene(arm)")
    known, description = scene.arm, require_arm(arm).description
    same = description is not None and description.text == scene._description.text
    if not same or arm.joint_names != known.joint_names or arm.couplings != known.couplings:
        raise InputError(f"scene is one of {scene.arm.name}, not of this {arm.name}: make it with Scene(arm)")
    return scene
