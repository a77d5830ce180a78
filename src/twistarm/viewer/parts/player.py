"""Player of the trajectory on show: play, pause, seek, speed and loop."""

from __future__ import annotations

from collections.abc import Iterator

from ...limits.joint_limits import JointLimits
from ...planning.trajectory import Trajectory
from ...support.checks import Array
from ...support.errors import InputError
from ..protocol.jobs import Job
from ..protocol.messages import Message, Request
from .limit_checks import checked_theta
from .part import Show
from .playback import Playback

SPEEDS = (0.05, 20.0)
"""Slowest and fastest speed from a page. Python may set a speed beyond them, which a page then keeps."""


class Player:
    """Holds the playback of at most one trajectory."""

    requests = frozenset({"play", "pause", "seek", "pace"})

    def __init__(self) -> None:
        self.playback: Playback | None = None

    def handle(self, request: Request, show: Show, now: float) -> Job | None:
        """Do what a page asks for; InputError where no trajectory is loaded."""
        if self.playback is None:
            raise InputError(f"nothing to {request.kind}: no trajectory is loaded")
        if request.kind == "play":
            self.playback.play(now)
        elif request.kind == "pause":
            self.playback.running = False
        elif request.kind == "pace":
            speed, (slowest, fastest) = request.fields["speed"], SPEEDS
            if speed != self.playback.speed and not slowest <= speed <= fastest:
                raise InputError(f"speed must be {slowest:g} … {fastest:g} times the trajectory's own; got {speed:g}")
            self.playback.speed, self.playback.loop = speed, request.fields["loop"]
        else:
            self.playback.seek(request.fields["time"])
            show.theta = checked_theta(show.arm, self.playback.theta())
        return None

    def messages(self, show: Show) -> Iterator[Message]:
        """The trajectory that is loaded; duration null where none is."""
        at = self.playback
        yield {
            "type": "player",
            "duration": None if at is None else at.duration,
            "speed": 1.0 if at is None else at.speed,
            "loop": at is not None and at.loop,
        }

    def load(self, trajectory: Trajectory, speed: float, loop: bool, now: float) -> Array:
        """Play `trajectory` from its start, which is returned."""
        self.playback = Playback(trajectory, speed, loop)
        self.playback.play(now)
        return self.playback.theta()

    def stand_by(self, trajectory: Trajectory, limits: JointLimits) -> Array:
        """Stop at the start of `trajectory`, which is returned; speed and loop stay. It was planned by `limits`."""
        at = self.playback
        speed, loop = (1.0, False) if at is None else (at.speed, at.loop)
        self.playback = Playback(trajectory, speed, loop, limits=limits)
        return self.playback.theta()

    def halt(self) -> None:
        """Stop at the current moment."""
        if self.playback is not None:
            self.playback.running = False

    def advance(self, now: float) -> Array | None:
        """The configuration at `now` [s] of what runs, None where nothing does."""
        if self.playback is None or not self.playback.running:
            return None
        self.playback.advance(now)
        return self.playback.theta()

    @property
    def running(self) -> bool:
        """Whether a trajectory runs."""
        return self.playback is not None and self.playback.running

    @property
    def time(self) -> float:
        """The moment on show [s]."""
        return 0.0 if self.playback is None else self.playback.time
