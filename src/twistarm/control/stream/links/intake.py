"""The intake of text from senders, read once a cycle: each one's last messages, malformed ones refused by sender."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Hashable, Iterable
from math import inf
from typing import Generic, Protocol, TypeVar

from ....support.errors import InputError
from ....support.strict_json import LARGEST_MESSAGE

T = TypeVar("T")
T_in = TypeVar("T_in", contravariant=True)

MOST_SENDERS = 3
"""Senders of commands told apart in one cycle: two are one too many already."""

STATE_SENDERS, STATES_EACH = 16, 32
"""Of joint states: a robot may have a sender for each bus, and a message for each joint."""


class Latest(Protocol[T_in]):
    """What is filled: `Inbox`, `StateInbox`."""

    timeout: float

    def put(self, sender: str, value: T_in, now: float, number: int | None = None) -> None:
        """`value` arrived."""

    def refuse(self, sender: str, reason: str, now: float) -> None:
        """Something that cannot be used arrived."""


class Intake(Generic[T]):
    """Fills `latest` with what `parse(text)` makes of texts: (value, number), or an InputError.

    What waited while nobody looked for a timeout is left out: nobody knows how old it is. `heard(text, fresh)`
    takes each text that is none of these messages, whoever sent it and whatever followed, and says whether it is one.
    Of each of at most `senders`, the last `each` texts count, together no longer than a message may be: what else a
    flood brings is not read.
    """

    def __init__(
        self,
        latest: Latest[T],
        parse: Callable[[bytes], tuple[T, int | None]],
        heard: Callable[[bytes, bool], bool] = lambda text, fresh: False,
        *,
        senders: int = MOST_SENDERS,
        each: int = 1,
    ) -> None:
        self._senders, self._each = senders, each
        self._latest = latest
        self._parse = parse
        self._heard = heard
        self._looked = -inf

    def take(self, arrivals: Iterable[tuple[Hashable, bytes]], now: float, name: Callable[[Hashable], str]) -> None:
        """Read all that has arrived, (sender, text), at `now` [s]."""
        last: dict[Hashable, deque[bytes]] = {}
        missed, self._looked = now - self._looked > self._latest.timeout, now
        for sender, text in arrivals:
            if self._heard(text, not missed):
                continue
            texts = last.pop(sender, None)
            if texts is not None or len(last) < self._senders:
                last[sender] = texts or deque(maxlen=self._each)
                last[sender].append(text)
                _keep_short(last[sender])
        for sender, texts in last.items() if not missed else ():
            for text in texts:
                self._put(name(sender), text, now)

    def _put(self, sender: str, text: bytes, now: float) -> None:
        try:
            value, number = self._parse(text)
        except InputError as error:
            self._latest.refuse(sender, str(error), now)
        else:
            self._latest.put(sender, value, now, number)


def _keep_short(texts: deque[bytes]) -> None:
    """Let go of the oldest, but never of the last one, until all are together as short as one message may be."""
    size = sum(map(len, texts))
    while len(texts) > 1 and size > LARGEST_MESSAGE:
        size -= len(texts.popleft())
