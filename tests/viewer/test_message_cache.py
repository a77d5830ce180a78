"""Only what has changed is encoded and told again."""

from __future__ import annotations

import json
from typing import Any

import pytest

from twistarm.viewer.protocol import message_cache as board_module
from twistarm.viewer.protocol.message_cache import MessageCache


@pytest.fixture
def encoded(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The types that were encoded, in order."""
    types: list[str] = []

    def encode(message: Any) -> str:
        types.append(message["type"])
        return json.dumps(message, allow_nan=False)

    monkeypatch.setattr(board_module, "encode", encode)
    return types


def test_what_says_the_same_is_neither_encoded_nor_told_again(encoded: list[str]) -> None:
    board = MessageCache()
    frame, path = {"type": "frame", "theta": [0.0]}, {"type": "path", "points": [1, 2, 3]}
    assert set(board.refresh([frame, path])) == {"frame", "path"}
    assert board.refresh([frame, {**path, "points": [1, 2, 3]}]) == {}
    assert encoded == ["frame", "path"]
    changed = board.refresh([{"type": "frame", "theta": [0.5]}, path])
    assert {kind: json.loads(text) for kind, text in changed.items()} == {"frame": {"type": "frame", "theta": [0.5]}}
    assert encoded == ["frame", "path", "frame"]


def test_a_late_page_gets_the_latest_of_everything() -> None:
    board = MessageCache()
    for k in range(5):
        board.refresh([{"type": "frame", "time": k}])
        board.refresh([{"type": "work", "jobs": []}])
    assert {kind: json.loads(text) for kind, text in board.texts().items()} == {
        "frame": {"type": "frame", "time": 4},
        "work": {"type": "work", "jobs": []},
    }


def test_texts_are_the_caller_s_own() -> None:
    board = MessageCache()
    board.refresh([{"type": "frame"}])
    board.texts().clear()
    assert list(board.texts()) == ["frame"]


def test_a_message_that_cannot_be_encoded_leaves_what_was_shown() -> None:
    board = MessageCache()
    board.refresh([{"type": "frame", "time": 1.0}])
    broken = {"type": "frame", "time": float("nan")}
    for _ in range(2):
        with pytest.raises(ValueError, match="not JSON compliant"):
            board.refresh([broken])
    assert json.loads(board.texts()["frame"])["time"] == 1.0
