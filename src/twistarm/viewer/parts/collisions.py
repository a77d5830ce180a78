"""Collisions on show: the shapes that are checked, obstacles, the links in collision and the nearest pair."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...arm.bodies import Body, outline
from ...collision import Scene
from ...planning.trajectory import Trajectory
from ...support.checks import Array, Progress, as_vector, pose_of
from ...support.errors import InputError
from ...theory.rotations import from_xyzw
from ..jobs import Job, Memo, same
from ..messages import Message, packed
from ..scene.drawing import columns, link_path
from .pose_list import RecordedPose
from .show import Part, Route, Show
from .target import Solutions

KINDS = {"box": 3, "sphere": 1, "cylinder": 2}  # What pages may add, and how many numbers its size has.
SAMPLES = 500  # Configurations of a motion that are checked.
WHOLE = 2**16 - 1  # The largest number of two bytes.

BATCH = 50

NOWHERE: Message = {"type": "collision", "ready": False, "links": [], "words": [], "nearest": None}


class Collisions(Part):
    """Checks what is on show with a scene.

    The scene is the program's. Without one, the layer makes it when a page first switches it on.
    """

    def __init__(self, scene: Scene | None, solutions: Solutions) -> None:
        self.scene, self._solutions = scene, solutions
        self._before: Scene | None = None  # of the arm before
        self._requested = self._ready = False
        self._checked: tuple[Any, ...] = (None,)  # what the band is of
        self._band: list[list[float]] = []
        self.shapes: list[Message] = []  # those that are checked, as pages draw them, once the checks are ready
        self._saved = self._bodies  # as the file has them
        self._obstacles, self._now, self._elsewhere = Memo(self._described), Memo(_in_collision), Memo(_colliding)
        self.routes = {
            "obstacle": Route(self._put),
            "remove_obstacle": Route(lambda show, now, name: self._require_ready().remove(name)),
            "save_scene": Route(self._save),
        }

    def take_over(self, other: Collisions) -> None:
        """Take over the obstacles of another arm."""
        self._before = other.scene or other._before

    def due(self, show: Show) -> Job | None:
        """The work that what is on show calls for: the checks themselves, then the collisions of the motion."""
        if not self._ready:
            needed = self.scene or self._before or "collision" in show.needed
            if self._requested or not needed or show.arm.description is None:
                return None
            self._requested = True
            prepare = partial(_prepared, self.scene, self._before, show.arm)
            return Job("collision", "preparing the collision checks", prepare, partial(self._begin, show))
        motion = None if show.playback is None else show.playback.trajectory
        before, self._checked = self._checked, (motion, *self._bodies)
        if same(before, self._checked):
            return None
        if motion is not before[0]:
            self._band = []
        if motion is None:
            return None
        check = partial(_band, self.scene, motion)
        return Job("band", "checking the motion for collisions", check, partial(setattr, self, "_band"))

    def _require_ready(self) -> Scene:
        if self.scene is None or not self._ready:
            raise InputError("turn on the layer Collision and wait until it is ready; then obstacles can be edited")
        return self.scene

    def _save(self, show: Show, now: float) -> None:
        """Write the file of the scene."""
        scene = self._require_ready()
        if self.file is None:
            raise InputError("the scene has no file yet: download it, and start with --scene FILE")
        scene.save(self.file)
        self._saved = self._bodies

    @property
    def file(self) -> str | None:
        """The scene.toml of the scene, where it has one."""
        file = None if self.scene is None else self.scene.file
        return str(file) if file is not None and file.suffix.lower() == ".toml" else None

    def messages(self, show: Show) -> Iterator[Message]:
        """Shapes and obstacles as they are drawn, what collides now, and what else collides."""
        scene, bodies = self.scene if self._ready else None, self._bodies
        yield {"type": "shapes", "bodies": self.shapes}
        yield self._obstacles(self._saved, *bodies)
        yield self._now(scene, show.theta, "collision" in show.needed, *bodies)
        yield self._elsewhere(scene, show.poses.poses, self._solutions.theta, self._band, *bodies)

    @property
    def _bodies(self) -> tuple[Body, ...]:
        return () if self.scene is None else tuple(self.scene.obstacles.values())

    def _begin(self, show: Show, result: tuple[Scene, list[dict[str, Any]]]) -> None:
        self.scene, self.shapes = result
        show.scene, self._ready = self.scene, True

    def _put(self, show: Show, now: float, name: str, kind: str, size: list[float], position: Any, xyzw: Any) -> None:
        """Add an obstacle, or move and resize it."""
        scene, g = self._require_ready(), pose_of(from_xyzw(np.array(xyzw)), position)
        body = scene.obstacles.get(name)
        if body is None:
            if kind not in KINDS:
                raise InputError(f"a page adds {', '.join(KINDS)}; a {kind} comes from a file")
            numbers = as_vector(size, "size", KINDS[kind])
            getattr(scene, f"add_{kind}")(name, *([numbers] if kind == "box" else numbers), g)
            return
        if body.kind != kind:
            raise InputError(f"{name!r} is a {body.kind}; remove it to add a {kind} of that name")
        scene.move(name, g)
        if tuple(size) != body.size:
            scene.resize(name, size)

    @property
    def drawn(self) -> list[Message]:
        """The obstacles as pages draw them."""
        held = set() if self.scene is None else {entry.name for entry in self.scene.content().entries if entry.on}
        return [{"name": body.name, "held": body.name in held, **drawing(body)} for body in self._bodies]

    def _described(self, saved: tuple[Body, ...], *bodies: Body) -> Message:
        return {"type": "obstacles", "obstacles": self.drawn, "file": self.file, "saved": same(saved, bodies)}


def _in_collision(scene: Scene | None, theta: Array, near: bool, *bodies: Body) -> Message:
    """The links in collision at theta (n,), and with `near` the nearest pair."""
    if scene is None:
        return NOWHERE
    contacts = scene.contacts(theta) if scene.collides(theta) else ()
    links = list(dict.fromkeys(name for contact in contacts for name in contact.links))
    nearest = None
    if near and len((found := scene.distance(theta)).links):
        nearest = {"points": found.points.tolist(), "metres": found.metres, "words": str(found)}
    words = [str(contact) for contact in contacts]
    return {"type": "collision", "ready": True, "links": links, "words": words, "nearest": nearest}


def _colliding(
    scene: Scene | None, poses: Sequence[RecordedPose], theta: Array | None, band: list[list[float]], *bodies: Body
) -> Message:
    """What collides: ids of recorded poses, places of configurations (k, n), parts of the motion."""
    message: Message = {"type": "colliding", "poses": [], "solutions": [], "band": band}
    if scene is not None:
        message["poses"] = [pose.id for pose in poses if scene.collides(pose.theta)]
        if theta is not None:
            message["solutions"] = np.flatnonzero(scene.collides(theta)).tolist()
    return message


def drawing(body: Body) -> dict[str, Any]:
    """A body for the page: kind, size, the node of its link, its matrix there, packed triangles."""
    outlined = outline(body.shape)
    if outlined["kind"] == "points":
        outlined |= _quantised(outlined["points"], body.size[0])
    elif outlined["kind"] == "mesh":
        outlined |= {"points": packed(outlined["points"], "<f4"), "faces": packed(outlined["faces"], "<u4")}
        outlined["size"] = list(body.size)
    return {**outlined, "node": link_path(body.carrier), "matrix": columns(body.pose)}


def _quantised(centres: Array, voxel: float) -> Message:
    """The centres (k, 3) of voxels as whole numbers of steps from the lowest one: six bytes for each."""
    low = centres.min(axis=0) if len(centres) else np.zeros(3)
    step = max(voxel, float((centres - low).max(initial=0.0)) / WHOLE)
    return {"points": packed(np.round((centres - low) / step), "<u2"), "low": low.tolist(), "step": step}


def _prepared(
    scene: Scene | None, before: Scene | None, arm: Arm, progress: Progress
) -> tuple[Scene, list[dict[str, Any]]]:
    """The scene with its checker made, and the bodies of its links as they are drawn."""
    progress(0.0)
    if scene is None:
        scene = Scene(arm, progress=progress) if before is None else before.for_arm(arm, progress=progress)
    scene.collides(arm.ready)
    return scene, [{"name": body.name, **drawing(body)} for body in scene.links]


def _band(scene: Scene | None, motion: Trajectory, progress: Progress) -> list[list[float]]:
    """The parts [from, to] of a motion that collide, in shares of its duration.

    Samples find them. If none collides, `first_collision` tells whether something between them does.
    """
    assert scene is not None
    times = np.linspace(0.0, motion.duration, SAMPLES)
    hit = []
    for start in range(0, SAMPLES, BATCH):
        progress(start / SAMPLES)
        hit += scene.collides(motion(times[start : start + BATCH])).tolist()
    edges = np.flatnonzero(np.diff([0, *hit, 0]))
    step = 1.0 / (SAMPLES - 1)
    band = [[first * step, (last - 1) * step] for first, last in edges.reshape(-1, 2).tolist()]
    if not band and (found := scene.first_collision(motion)) is not None:
        share = found.time / motion.duration if motion.duration > 0.0 else 0.0
        band = [[share, share]]
    return band
