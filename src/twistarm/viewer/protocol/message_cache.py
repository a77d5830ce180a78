"""Cache of the last message of each type: only what has changed is encoded and sent again."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ...support.strict_json import encode

Message = dict[str, Any]


class MessageCache:
    """The latest message of each type; one that was shown is never changed, so what equals it is the same text."""

    def __init__(self) -> None:
        self._shown: dict[str, Message] = {}
        self._texts: dict[str, str] = {}

    def refresh(self, messages: Iterable[Message]) -> dict[str, str]:
        """Show `messages`; the texts of those that say something new, by type."""
        changed: dict[str, str] = {}
        for message in messages:
            kind = message["type"]
            if self._shown.get(kind) == message:
                continue
            self._texts[kind] = changed[kind] = encode(message)
            self._shown[kind] = message
        return changed

    def texts(self) -> dict[str, str]:
        """Everything on show, by type."""
        return dict(self._texts)
