"""The arm on show: its configuration and motion, and the interface of parts such as the player."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm, require_arm
from ...collision import Scene
from ...control.servo.settings import SLIDE
from ...planning.trajectory import Trajectory
from ...support.checks import Array, as_theta
from ...support.errors import InputError
from ..jobs import Job, Memo
from ..messages import Message
from .arm_data import NO_PATH, checked_theta, extra_joints, rest
from .pose_list import PoseList

GLIDE_TIME = 0.5  # Duration of a glide [s], as in page/glide.js.


@dataclass
class Playback:
    """The clock of one trajectory."""

    trajectory: Trajectory
    speed: float = 1.0
    loop: bool = False
    time: float = 0.0
    running: bool = False
    _last: float = 0.0

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.trajectory.duration)

    def play(self, now: float) -> None:
        """Run from the moment shown. At the end, run from the start."""
        if self.time >= self.duration:
            self.time = 0.0
        self.running, self._last = True, now

    def seek(self, time: float) -> None:
        """Stop at `time`, or at the nearer end."""
        self.running = False
        self.time = min(max(time, 0.0), self.duration)

    def advance(self, now: float) -> None:
        """Advance the clock to `now`. At the end, start again with `loop`. Otherwise stop there."""
        if not self.running:
            return
        self.time += self.speed * (now - self._last)
        self._last = now
        if self.time >= self.duration:
            again = self.loop and self.duration > 0.0
            self.time = self.time % self.duration if again else self.duration
            self.running = again

    def theta(self) -> Array:
        """The configuration (n,) at the moment shown."""
        return as_theta(self.trajectory(self.time), len(self.trajectory.joint_names), "the trajectory's theta")


@dataclass(frozen=True, eq=False)
class Glide:
    """From `start` (n,) to `goal` (n,), begun at `begun` [s] on the caller's clock."""

    start: Array
    goal: Array
    begun: float

    def at(self, now: float) -> Array:
        """start + (3s² − 2s³)(goal − start) with s = (now − begun)/GLIDE_TIME: at rest at both ends."""
        s = max(0.0, (now - self.begun) / GLIDE_TIME)
        if s >= 1.0:
            return self.goal
        way: Array = self.start + s * s * (3.0 - 2.0 * s) * (self.goal - self.start)
        return way


# The report without a servo.
NO_REPORT: dict[str, Any] = {"status": None, "joint": None, "reason": "", "share": None}
# on_unreachable: what a servo does if the arm cannot follow. free: pages may choose it for a servo of the program.
NO_DRIVE: Message = {"type": "drive", "on": False, "note": "", "on_unreachable": SLIDE, "free": False}


class Show:
    """The arm on show: where it stands, how it moves, and what its parts share."""

    def __init__(self, arm: Arm, theta: ArrayLike | None) -> None:
        self.number = 0
        self.arm = require_arm(arm)
        self.theta = arm.ready if theta is None else checked_theta(arm, theta)
        self.extra_joints = extra_joints(arm)
        self.others = {name: rest(joint) for name, joint in self.extra_joints.items()}
        self.poses = PoseList(arm)
        self.visible: dict[str, list[Any]] = {"screws": [True, 0], "frames": [True, 0], "reach": [False, 0]}
        self.needed: frozenset[str] = frozenset()  # of collision and reach, by the pages
        self.tolerances: Mapping[str, Any] = {}
        self._paths: list[tuple[Message, Callable[[], bool]]] = []
        self.draw_path(NO_PATH)
        self.playback: Playback | None = None
        self.scene: Scene | None = None  # what motions and the servo collide with
        self.driven = False
        self.report: Mapping[str, Any] = NO_REPORT  # of the servo
        self.drive: Message = NO_DRIVE
        self._glide: Glide | None = None
        self._rates = Memo(_rates)

    def show(self, theta: Array) -> None:
        """Show theta (n,) and stop any motion."""
        self.stop()
        self.theta = theta

    def go(self, theta: Array, ease: bool, now: float) -> None:
        """Go to theta (n,), with `ease` in half a second, and stop any other motion."""
        self.show(self.theta if ease else theta)
        if not np.array_equal(self.theta, theta):
            self._glide = Glide(self.theta, theta, now)

    def stop(self) -> None:
        """Stop any motion here."""
        self._glide = None
        if self.playback is not None:
            self.playback.running = False

    def load(self, trajectory: Trajectory, speed: float = 1.0, loop: bool = False) -> Playback:
        """Stand at the start of `trajectory`, which the result plays."""
        self.stop()
        self.playback = Playback(trajectory, speed, loop)
        self.theta = self.playback.theta()
        return self.playback

    def advance(self, now: float) -> None:
        """Advance motions to `now` [s]. A trajectory that raises stops there."""
        if self._glide is not None:
            self.theta = self._glide.at(now)
            self._glide = None if self.theta is self._glide.goal else self._glide
        elif self.playback is not None and self.playback.running:
            try:
                self.playback.advance(now)
                self.theta = checked_theta(self.arm, self.playback.theta())
            except Exception:
                self.playback.running = False
                raise

    @property
    def running(self) -> bool:
        """Whether a trajectory runs."""
        return self.playback is not None and self.playback.running

    @property
    def rates(self) -> list[float] | None:
        """The joint rates (n,) [rad/s, m/s] of the motion now. None while the arm is not on it."""
        at = self.playback
        return None if at is None else self._rates(at, at.time, self.running, self.theta)

    @property
    def moving(self) -> bool:
        """Whether the arm moves by itself, in a trajectory or on its way to a pose."""
        return self.running or self._glide is not None

    @property
    def goal(self) -> Array:
        """The configuration (n,) where the arm stands, or to which it is on its way."""
        return self.theta if self._glide is None else self._glide.goal

    def draw_path(self, path: Mapping[str, Any], holds: Callable[[], bool] | None = None) -> None:
        """Draw this path of the tool: points and radius. With `holds`, only while that is true, over the others."""
        self._paths = [*(self._paths if holds else ()), ({"type": "path", **path}, holds or (lambda: True))]

    @property
    def path(self) -> Message:
        """The path that was drawn last, of those that still hold."""
        self._paths = [path for path in self._paths if path[1]()]
        return self._paths[-1][0]

    def require_free(self) -> None:
        """Raise InputError while a servo drives the arm."""
        if self.driven:
            remedy = "turn off Drive in the Jog panel first" if self.drive["on"] else "end it first"
            raise InputError(f"a servo drives {self.arm.name}: {remedy}")


def _rates(at: Playback, time: float, running: bool, theta: Array) -> list[float] | None:
    # A trajectory of a program may raise here. `advance` tells of it, and the frame must not be lost.
    with suppress(Exception):
        if running or np.array_equal(at.theta(), theta):
            return as_theta(at.trajectory(time, 1), len(theta), "the trajectory's rates").tolist()
    return None


class Route(NamedTuple):
    """The handler of one kind of request.

    `handle(show, now, **fields)` runs in the loop at `now` [s] and may return a job. Where it raises TwistarmError,
    nothing has changed. `moves`: it moves the arm, so it is refused while a servo drives the arm.
    """

    handle: Callable[..., Job | None]
    moves: bool = False


class Part:
    """A part of what is on show. It lives in the server's loop, and has no threads and no sockets."""

    routes: Mapping[str, Route] = {}
    """The requests of the pages that it handles, by kind."""

    def messages(self, show: Show) -> Iterable[Message]:
        """The messages for the pages. A large message is the same object until it changes."""
        return ()
