"""Ends: Ctrl-C, `kill` and a closed terminal, which end the program alike, and objects that close what they opened."""

from __future__ import annotations

import signal
import threading
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import Any, TypeVar

C = TypeVar("C", bound="Closeable")

SIGNALS = tuple(signal.Signals[name] for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))

USUAL = (signal.SIG_DFL, signal.default_int_handler)


@contextmanager
def _handlers(new: Mapping[int, Any]) -> Iterator[None]:
    """Give signals these handlers inside the block, and then those from before."""
    before = {number: signal.signal(number, handler) for number, handler in new.items()}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _handled() -> dict[int, Any]:
    """The signals and their handlers of Python. Empty outside the main thread, where Python sets no handlers."""
    here = threading.current_thread() is threading.main_thread()
    return {number: handler for number in SIGNALS if here and callable(handler := signal.getsignal(number))}


@contextmanager
def ended_like_ctrl_c() -> Iterator[list[int]]:
    """Let a closed terminal and `kill` act as Ctrl-C does: by KeyboardInterrupt with the signal's name.

    The cursor then comes back, the arm comes to rest, and no part of a file is left. The context
    gives the list of the signals that were sent. The code that handles the interruption ends the process by `end_by`.

    Only signals with their usual effect are handled, and they get it back after the context. An ignored signal stays
    ignored, as under `nohup`. The handler of a program or of an outer context stays. Outside the main thread nothing
    is handled.
    """
    sent: list[int] = []

    def end(number: int, frame: FrameType | None) -> None:
        sent.append(number)
        raise KeyboardInterrupt(signal.Signals(number).name)

    here = threading.current_thread() is threading.main_thread()
    with _handlers({number: end for number in SIGNALS if here and signal.getsignal(number) in USUAL}):
        yield sent


def end_by(sent: Sequence[int]) -> None:
    """End by the first of the signals that were sent, if any was."""
    if sent:
        signal.signal(sent[0], signal.SIG_DFL)
        signal.raise_signal(sent[0])


@contextmanager
def ending_at_once() -> Iterator[None]:
    """Let Ctrl-C, and what acts like it, end the process at once. Python hears of a signal only between calls of C.

    Only a signal that Python handles is changed, and it gets its handler back.
    """
    with _handlers(dict.fromkeys(_handled(), signal.SIG_DFL)):
        yield


@contextmanager
def interruptible() -> Iterator[None]:
    """Raise a KeyboardInterrupt again at the end of a block that caught it and went on, as some libraries do."""
    caught: list[KeyboardInterrupt] = []
    usual = _handled()

    def note(number: int, frame: FrameType | None) -> None:
        try:
            usual[number](number, frame)
        except KeyboardInterrupt as interruption:
            caught.append(interruption)
            raise

    try:
        with _handlers(dict.fromkeys(usual, note)):
            yield
    finally:
        if caught:
            raise caught[0]


class Closeable(ABC):
    """A context manager that is closed at the end of its block."""

    @abstractmethod
    def close(self) -> None:
        """Give back what was opened. Harmless when repeated."""

    def __enter__(self: C) -> C:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()
