"""Ends: Ctrl-C, `kill` and a closed terminal, which end the program alike, and objects that close what they opened."""

from __future__ import annotations

import signal
import threading
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import TypeVar

C = TypeVar("C", bound="Closeable")

SIGNALS = tuple(signal.Signals[name] for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))

USUAL = (signal.SIG_DFL, signal.default_int_handler)


@contextmanager
def ended_like_ctrl_c() -> Iterator[list[int]]:
    """Let a closed terminal and `kill` act as Ctrl-C does: by KeyboardInterrupt with the signal's name.

    The cursor then comes back, the arm comes to rest, and no part of a file is left. The context
    gives the list of the signals that were sent. The code that handles the interruption ends the process by `end_by`.

    Only signals with their usual effect are taken, and they get it back after the context. An ignored signal stays
    ignored, as under `nohup`. The handler of a program or of an outer context stays. Outside the main thread nothing
    is taken, because Python sets no handlers there.
    """
    sent: list[int] = []

    def end(number: int, frame: FrameType | None) -> None:
        sent.append(number)
        raise KeyboardInterrupt(signal.Signals(number).name)

    here = threading.current_thread() is threading.main_thread()
    heeded = [number for number in SIGNALS if here and signal.getsignal(number) in USUAL]
    before = {number: signal.signal(number, end) for number in heeded}
    try:
        yield sent
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def end_by(sent: Sequence[int]) -> None:
    """End by the first of the signals that were sent, if any was."""
    for number in sent[:1]:
        signal.signal(number, signal.SIG_DFL)
        signal.raise_signal(number)


@contextmanager
def ending_at_once() -> Iterator[None]:
    """Let Ctrl-C, and what acts like it, end the process at once: Python hears of a signal only between calls of C.

    Only a signal that Python handles is taken, and it gets its handler back. Outside the main thread this does
    nothing.
    """
    here = threading.current_thread() is threading.main_thread()
    before = {number: handler for number in SIGNALS if here and callable(handler := signal.getsignal(number))}
    for number in before:
        signal.signal(number, signal.SIG_DFL)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def interruptible() -> Iterator[None]:
    """Raise a KeyboardInterrupt again at the end of a block that caught it and went on, as some libraries do.

    Outside the main thread this does nothing, because no signal comes there.
    """
    caught: list[KeyboardInterrupt] = []
    here = threading.current_thread() is threading.main_thread()
    handlers = {int(each): handler for each in SIGNALS if here and callable(handler := signal.getsignal(each))}

    def note(number: int, frame: FrameType | None) -> None:
        try:
            handlers[number](number, frame)
        except KeyboardInterrupt as interruption:
            caught.append(interruption)
            raise

    for number in handlers:
        signal.signal(number, note)
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
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
