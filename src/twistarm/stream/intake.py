"""What arrives as text from senders, read once a cycle: the last of each counts, nonsense is refused in their name."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from math import inf
from typing import Generic, TypeVar

from ..errors import InputError
from .latest import Latest

T = TypeVar("T")

MOST_SENDERS = 3
"""Senders told apart in one cycle: two are one too many already."""


class Intake(Generic[T]):
    """Fills `latest` with what `parse(text)` makes of texts: (value, number), or an InputError.

    What waited while nobody looked for a timeout is left out: nobody knows how old it is. `heard(text, fresh)`
    takes each text that is none of these messages, whoever sent it and whatever followed, and says whether it is one.
    """

    def __init__(
        self,
        latest: Latest[T],
        parse: Callable[[bytes], tuple[T, int | None]],
        heard: Callable[[bytes, bool], bool] = lambda text, fresh: False,
    ) -> None:
        self._latest = latest
        self._parse = parse
        self._heard = heard
        self._looked = -inf

    def take(self, arrivals: Iterable[tuple[Hashable, bytes]], now: float, name: Callable[[Hashable], str]) -> None:
        """Read all that has arrived, (sender, text), at `now` [s]."""
        last: dict[Hashable, bytes] = {}
        missed, self._looked = now - self._looked > self._latest.timeout, now
        for sender, text in arrivals:
            if self._heard(text, not missed):
                continue
            if last.pop(sender, None) is not None or len(last) < MOST_SENDERS:
                last[sender] = text
        for sender, text in last.items() if not missed else ():
            self._put(name(sender), text, now)

    def _put(self, sender: str, text: bytes, now: float) -> None:
        try:
            value, number = self._parse(text)
        except InputError as error:
            self._latest.refuse(sender, str(error), now)
        else:
            self._latest.put(sender, value, now, number)
