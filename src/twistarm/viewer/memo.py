"""A function's last result, kept as long as its arguments are the same objects."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class Memo(Generic[T]):
    """Calls `make` again once an argument is another object than at the last call.

    What is on show is replaced and never changed in place, so identity is enough and costs nothing.
    """

    def __init__(self, make: Callable[..., T]) -> None:
        self._make = make
        self._last: tuple[tuple[object, ...], T] | None = None

    def __call__(self, *arguments: object) -> T:
        """The result of `make(*arguments)`."""
        if self._last is None or not same(self._last[0], arguments):
            self._last = arguments, self._make(*arguments)
        return self._last[1]


def same(one: tuple[object, ...], other: tuple[object, ...]) -> bool:
    """Whether both hold the same objects."""
    return len(one) == len(other) and all(a is b for a, b in zip(one, other, strict=True))
