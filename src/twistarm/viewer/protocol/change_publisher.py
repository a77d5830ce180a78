"""Publisher of changes. It encodes only what has changed, and a failing source leaves the others alone."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from ...support.strict_json import encode
from .messages import Message, failure

Source = Callable[[], Iterable[Message]]
"""Returns what a part of the view shows now. A returned message never changes."""


class ChangePublisher:
    """Keeps what the pages know. A failing source keeps its last messages; its error is reported once."""

    def __init__(self) -> None:
        self._shown: dict[str, Message] = {}
        self._texts: dict[str, str] = {}
        self._failing: dict[int, str] = {}

    def gather(self, sources: Sequence[Source]) -> dict[str, str]:
        """The texts of changes since the last call, by type, and the error of a failing source."""
        changed: dict[str, str] = {}
        for place, source in enumerate(sources):
            self._ask(place, source, changed)
        return changed

    def everything(self) -> dict[str, str]:
        """The texts for a new page, by type."""
        texts = dict(self._texts)
        for error in self._failing.values():
            texts["error"] = error
        return texts

    def _ask(self, place: int, source: Source, changed: dict[str, str]) -> None:
        try:
            for message in source():
                kind = message["type"] + message.get("node", "")  # of one type there is one for each node
                if self._shown.get(kind) != message:
                    self._texts[kind] = changed[kind] = encode(message)
                    self._shown[kind] = message
        except Exception as error:
            if place not in self._failing:
                self._failing[place] = changed["error"] = encode(failure(error))
        else:
            self._failing.pop(place, None)
