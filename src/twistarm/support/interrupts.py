"""Ctrl-C, `kill` and a closed terminal, which end the program alike."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

USUAL = (signal.SIG_DFL, signal.default_int_handler)


@contextmanager
def ended_like_ctrl_c() -> Iterator[list[int]]:
    """A closed terminal and `kill` end what runs as Ctrl-C does, by KeyboardInterrupt with the signal's name: the
    cursor comes back, the arm is brought to rest, the poses are kept, no part of a file is left.

    The context gives the list of the signals that were sent: who handles the interruption then ends by `end_by`, as
    whoever sent it expects. Only signals whose usual effect stands are taken, and given it back behind the context: one
    that is ignored, as a closed terminal is under `nohup`, stays so, and a handler of somebody's own (a program's, an
    outer context's) is left alone. Outside the main thread, where Python sets no handlers, nothing is taken.
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
