"""Player of the trajectory on show: play, pause, seek, speed and loop."""

from __future__ import annotations

from collections.abc import Iterator

from ...support.errors import InputError
from ..protocol.jobs import Job
from ..protocol.messages import Message, Request
from .limit_checks import checked_theta
from .part import Part, Show

SPEEDS = (0.05, 20.0)
"""Slowest and fastest speed from a page. Python may set a speed beyond them, which a page then keeps."""


class Player(Part):
    """Plays the loaded trajectory as the pages ask."""

    requests = frozenset({"play", "pause", "seek", "pace"})

    def handle(self, request: Request, show: Show, now: float) -> Job | None:
        """Do what a page asks for; InputError where no trajectory is loaded."""
        at = show.playback
        if at is None:
            raise InputError(f"nothing to {request.kind}: no trajectory is loaded")
        if request.kind == "play":
            at.play(now)
        elif request.kind == "pause":
            at.running = False
        elif request.kind == "pace":
            speed, (slowest, fastest) = request.fields["speed"], SPEEDS
            if speed != at.speed and not slowest <= speed <= fastest:
                raise InputError(f"speed must be {slowest:g} … {fastest:g} times the trajectory's own; got {speed:g}")
            at.speed, at.loop = speed, request.fields["loop"]
        else:
            at.seek(request.fields["time"])
            show.theta = checked_theta(show.arm, at.theta())
        return None

    def messages(self, show: Show) -> Iterator[Message]:
        """The trajectory that is loaded; duration null where none is."""
        at = show.playback
        yield {
            "type": "player",
            "duration": None if at is None else at.duration,
            "speed": 1.0 if at is None else at.speed,
            "loop": at is not None and at.loop,
        }
