"""Undo and redo for the pages: changes of the pose list and of obstacles, and moves of the arm."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from time import monotonic
from typing import Any, NamedTuple

import numpy as np

from ...support.errors import InputError
from ..protocol.jobs import Job
from ..protocol.messages import Message, Request
from .part import Seen, Show

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


class Step(NamedTuple):
    """What a change has replaced: fields of `Seen` as they were before it. `words` name the change."""

    words: str
    before: Mapping[str, Any]


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
        if "theta" in step.before:
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
        old, new = before._asdict(), after._asdict()
        changed = {field: was for field, was in old.items() if was is not None and not _same(was, new[field])}
        (last, at), now = self._last, monotonic()
        if "poses" in changed:
            self._keep(Step(words, {"poses": before.poses}))
        elif changed:
            if last != words or now - at > PAUSE:
                self._keep(Step(words, changed))
            self._last = (words, now)

    def _keep(self, step: Step) -> None:
        self._past = [*self._past[1 - MAX_STEPS :], step]
        self._future = []
        self._last = ("", -np.inf)

    def _undone(self, step: Step, show: Show, ease: bool, now: float) -> Step:
        """Put back what the step has kept; the step that undoes this again."""
        there, before = show.seen()._asdict(), step.before
        show.poses.poses = before.get("poses", show.poses.poses)
        show.others = before.get("others", show.others)
        if "obstacles" in before and show.scene is not None:
            show.scene.put_back(before["obstacles"])
        if "theta" in before:
            show.go(before["theta"], ease, now)
        return Step(step.words, {field: there[field] for field in before})


def _same(one: Any, other: Any) -> bool:
    return np.array_equal(one, other) if isinstance(one, np.ndarray) else bool(one == other)
