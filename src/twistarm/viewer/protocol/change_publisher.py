"""Publishes only changed messages. A failing source does not affect the others."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from ...support.strict_json import encode
from .messages import Message, failure

Source = Callable[[], Iterable[Message]]
"""Says what a part of the view shows now; a message that was said is never changed."""


class ChangePublisher:
    """The messages that the pages know. A failing source keeps its last message and is reported once."""

    def __init__(self) -> None:
        self._shown: dict[str, Message] = {}
        self._texts: dict[str, str] = {}
        self._failing: dict[int, str] = {}

    def gather(self, sources: Sequence[Source]) -> dict[str, str]:
        """Changed texts by type, with an error for each source that fails."""
        changed: dict[str, str] = {}
        for place, source in enumerate(sources):
            self._ask(place, source, changed)
        return changed

    def everything(self) -> dict[str, str]:
        """All messages for a new page, by type."""
        texts = dict(self._texts)
        for error in self._failing.values():
            texts["error"] = error
        return texts

    def _ask(self, place: int, source: Source, changed: dict[str, str]) -> None:
        try:
            for message in source():
                self._show(message, changed)
        except Exception as error:
            if place not in self._failing:
                self._failing[place] = changed["error"] = encode(failure(error))
        else:
            self._failing.pop(place, None)

    def _show(self, message: Message, changed: dict[str, str]) -> None:
        kind = message["type"]
        if self._shown.get(kind) != message:
            self._texts[kind] = changed[kind] = encode(message)
            self._shown[kind] = message
