"""Ctrl-C beside code that swallows it."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def interrupts_held() -> Iterator[None]:
    """Let a Ctrl-C inside the block take effect at its end; a second one takes effect at once.

    For calls of trimesh: around its optional imports and inside its readers it catches BaseException, so that a
    KeyboardInterrupt raised there is lost, and what it was importing stays missing. Other threads than the main one
    get no KeyboardInterrupt.
    """
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or before is None:  # None: set outside Python
        yield
        return
    pressed: list[int] = []

    def note(number: int, frame: Any) -> None:
        if pressed and callable(before):
            before(number, frame)
        pressed.append(number)

    signal.signal(signal.SIGINT, note)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        if pressed:
            signal.raise_signal(signal.SIGINT)
