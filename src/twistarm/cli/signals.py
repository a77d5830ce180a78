"""What ends a program that serves until it is told to stop."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import FrameType

Handler = Callable[[int, FrameType | None], object] | int | None
"""The value that `signal.signal` takes and gives back."""


@contextmanager
def ended_like_ctrl_c() -> Iterator[list[int]]:
    """A closed terminal and `kill` end what runs as Ctrl-C does: the arm is brought to rest, the poses are kept.

    The process then ends by the signal that it was sent, as whoever sent it expects; where something inside takes the
    interruption for its own end, it does so by `end_by` and the list that the context gives. A signal that is ignored,
    as a closed terminal is under `nohup`, stays so.
    """
    sent: list[int] = []

    def end(number: int, frame: FrameType | None) -> None:
        sent.append(number)
        raise KeyboardInterrupt

    heeded = [number for number in (signal.SIGTERM, signal.SIGHUP) if signal.getsignal(number) != signal.SIG_IGN]
    before = {number: signal.signal(number, end) for number in heeded}
    try:
        yield sent
    except KeyboardInterrupt:
        _restore(before)
        end_by(sent)
        raise
    finally:
        _restore(before)


def end_by(sent: Sequence[int]) -> None:
    """End by the first of the signals that were sent, if any was."""
    for number in sent[:1]:
        signal.raise_signal(number)


def _restore(handlers: Mapping[signal.Signals, Handler]) -> None:
    for number, handler in handlers.items():
        signal.signal(number, handler)
