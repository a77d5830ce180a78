"""What ends a program that serves until it is told to stop."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import FrameType

Handler = Callable[[int, FrameType | None], object] | int | None
"""The value that `signal.signal` takes and gives back."""


@contextmanager
def ended_like_ctrl_c() -> Iterator[None]:
    """A closed terminal and `kill` end what runs as Ctrl-C does: the arm is brought to rest, the poses are kept.

    The process then ends by the signal that it was sent, as whoever sent it expects.
    """
    sent: list[int] = []

    def end(number: int, frame: FrameType | None) -> None:
        sent.append(number)
        raise KeyboardInterrupt

    before = {number: signal.signal(number, end) for number in (signal.SIGTERM, signal.SIGHUP)}
    try:
        yield
    except KeyboardInterrupt:
        _restore(before)
        for number in sent[:1]:
            signal.raise_signal(number)
        raise
    finally:
        _restore(before)


def _restore(handlers: Mapping[signal.Signals, Handler]) -> None:
    for number, handler in handlers.items():
        signal.signal(number, handler)
