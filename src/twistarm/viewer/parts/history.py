"""Undo and redo for the pages: changes of the pose list and of obstacles, and moves of the arm."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from time import monotonic

import numpy as np

from ...collision.scene import Placed
from ...support.checks import Array
from ...support.errors import InputError
from ..protocol.jobs import Job
from ..protocol.messages import Message, Request
from .part import Seen, Show
from .pose_list import RecordedPose

MAX_STEPS = 100
"""Most steps to keep."""

PAUSE = 1.0
"""Seconds that separate two moves of the same kind. A drag is one move."""

WORDS = {
    "record": "record a pose",
    "rename": "rename a pose",
    "reorder": "reorder the poses",
    "delete": "delete a pose",
    "move": "choose a move",
    "poses": "load a list",
    "theta": "move the arm",
    "joint": "move {name}",
    "pose": "go to {name}",
    "random": "go to a random configuration",
    "target": "move the tool",
    "solution": "go to another configuration",
    "go": "go to a pose",
    "jog": "jog",
    "obstacle": "change {name}",
    "remove_obstacle": "remove {name}",
}
"""Names of the requests that can be undone. Playing a motion is not among them: seek back instead."""


@dataclass(frozen=True, eq=False)
class Step:
    """The state before a change: the list, theta, the joints beside the arm, or obstacles. `words` name the change."""

    words: str
    poses: tuple[RecordedPose, ...] | None = None
    theta: Array | None = None
    others: Mapping[str, float] | None = None
    obstacles: Placed | None = None


class History:
    """Two stacks of steps. Undoing one puts back what it changed and nothing else."""

    requests = frozenset({"undo", "redo"})

    def __init__(self) -> None:
        self._past: list[Step] = []
        self._future: list[Step] = []
        self._last: tuple[str, float] = ("", -np.inf)

    def handle(self, request: Request, show: Show, now: float) -> Job | None:
        """Undo the last step, or redo it. Raises InputError without one."""
        source, sink = (self._past, self._future) if request.kind == "undo" else (self._future, self._past)
        if not source:
            raise InputError(f"nothing to {request.kind}")
        step = source[-1]
        if step.theta is not None:
            show.require_free()
        source.pop()
        sink.append(self._undone(step, show, request.fields["ease"], now))
        self._last = ("", -np.inf)
        return None

    def messages(self, show: Show) -> Iterator[Message]:
        """What would be undone and done again, in words; null for nothing."""
        past, future = (steps[-1].words if steps else None for steps in (self._past, self._future))
        yield {"type": "history", "undo": past, "redo": future}

    def note(self, kind: str, name: str, before: Seen, after: Seen) -> None:
        """Record what a request has changed, if anything. `name` is its object."""
        if kind not in WORDS:
            return
        words = WORDS[kind].format(name=name)
        if after.poses is not before.poses:
            self._keep(Step(words, poses=before.poses))
            return
        theta = None if np.array_equal(after.theta, before.theta) else before.theta
        others = None if after.others == before.others else before.others
        obstacles = None if after.obstacles == before.obstacles else before.obstacles
        if theta is not None or others is not None or obstacles is not None:
            (last, at), now = self._last, monotonic()
            if last != words or now - at > PAUSE:
                self._keep(Step(words, theta=theta, others=others, obstacles=obstacles))
            self._last = (words, now)

    def _keep(self, step: Step) -> None:
        self._past = [*self._past[1 - MAX_STEPS :], step]
        self._future = []
        self._last = ("", -np.inf)

    def _undone(self, step: Step, show: Show, ease: bool, now: float) -> Step:
        """Put back what the step has kept; the step that undoes this again."""
        there = show.seen()
        if step.poses is not None:
            show.poses.poses = step.poses
        if step.others is not None:
            show.others = dict(step.others)
        if step.obstacles is not None and show.scene is not None:
            show.scene.put_back(step.obstacles)
        if step.theta is not None:
            show.go(step.theta, ease, now)
        changed = {name: value for name, value in there._asdict().items() if getattr(step, name) is not None}
        return Step(step.words, **changed)
