"""What a part of the view is: the target, the list of poses, the player … each with its requests and its messages."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Protocol

from ...support.errors import InputError
from ..protocol.jobs import Job
from ..protocol.message_cache import Message
from ..protocol.messages import Request

if TYPE_CHECKING:
    from ..stage import Stage


class Part(Protocol):
    """A part of what is on show. It lives in the server's loop, and has no threads and no sockets."""

    requests: frozenset[str] = frozenset()
    """The kinds of request that it answers."""

    def handle(self, request: Request, stage: Stage, now: float) -> Job | None:
        """Do what a page asks for at `now` [s], or return the job that will; TwistarmError where it cannot be done."""
        raise InputError(f"no such request: {request.kind}")

    def messages(self, stage: Stage) -> Iterable[Message]:
        """What the pages are told of it; the same object while nothing has changed, where it is large."""
