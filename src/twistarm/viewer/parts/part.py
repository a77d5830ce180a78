"""Parts of the view, such as the target or the player, with their requests and messages."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple, Protocol

from ...arm.arm import Arm
from ...limits.joint_limits import JointLimits
from ...planning.trajectory import Trajectory
from ...support.checks import Array
from ...support.errors import InputError
from ..protocol.jobs import Job
from ..protocol.messages import Message, Request
from .playback import Playback
from .pose_list import RecordedPose


class Seen(NamedTuple):
    """The state that a step of undo may change."""

    poses: tuple[RecordedPose, ...]
    theta: Array
    others: Mapping[str, float]


class Show(Protocol):
    """The state on show, as a part sees and changes it."""

    arm: Arm
    theta: Array
    others: dict[str, float]
    visible: dict[str, bool]
    driven: bool
    tolerances: Mapping[str, Any]

    @property
    def moving(self) -> bool:
        """Whether a motion runs."""

    @property
    def playback(self) -> Playback | None:
        """The trajectory that is loaded."""

    def show(self, theta: Array) -> None:
        """Show theta (n,) and stop any motion."""

    def go(self, theta: Array, ease: bool, now: float) -> None:
        """Stand at theta (n,), with `ease` in half a second."""

    def stand_by(self, trajectory: Trajectory, limits: JointLimits) -> None:
        """Stand at the start of a trajectory that was planned by `limits`."""

    def draw_path(self, path: Mapping[str, Any]) -> None:
        """Draw this way of the tool."""

    def require_free(self) -> None:
        """InputError while a servo drives the arm."""

    def seen(self) -> Seen:
        """The list of poses, and where the arm stands or is about to."""


class Part(Protocol):
    """A part of what is on show. It lives in the server's loop, and has no threads and no sockets."""

    requests: frozenset[str] = frozenset()
    """The kinds of request that it answers."""

    def handle(self, request: Request, show: Show, now: float) -> Job | None:
        """Handle a page's request at `now` [s] or return a job for it. Raises TwistarmError if it cannot."""
        raise InputError(f"no such request: {request.kind}")

    def messages(self, show: Show) -> Iterable[Message]:
        """The messages for the pages. A large message is the same object until it changes."""
