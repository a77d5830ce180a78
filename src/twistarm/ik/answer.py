"""What a solver hands back before anybody looks at it: numbers alone, whichever solver it was."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol


class Answer(Protocol):
    """One answer as numbers; the compiled core's `Answer` has the same attributes. Arrays are float64 as bytes."""

    @property
    def kind(self) -> int:
        """The target's kind, by its place in `targets.KINDS`."""

    @property
    def numbers(self) -> bytes:
        """The target's numbers."""

    @property
    def theta0(self) -> bytes:
        """(n,): where the search was to begin."""

    @property
    def position_tol(self) -> float:
        """What counts as met [m]."""

    @property
    def orientation_tol(self) -> float:
        """What counts as met [rad]."""

    @property
    def theta(self) -> bytes:
        """(n,)."""

    @property
    def unlimited(self) -> bytes | None:
        """Where limits block: an answer without them, (n,)."""

    @property
    def position_error(self) -> float:
        """[m], of what the target constrains."""

    @property
    def orientation_error(self) -> float:
        """[rad], of what the target constrains."""

    @property
    def iterations(self) -> int:
        """Steps of the search that found theta; of all of them where none did."""

    @property
    def restarts(self) -> int:
        """Searches that were run."""

    @property
    def stop(self) -> int:
        """The reason, by its place in `StopReason`."""

    @property
    def nearest(self) -> bool:
        """Whether theta is the nearest configuration, looked for because no search met the target."""

    @property
    def other_branch(self) -> bool:
        """Whether theta is not near theta0, though the target is near theta0's pose, or cannot be met."""

    @property
    def start_moved(self) -> bool:
        """Whether theta0 lay outside the limits."""


@dataclass(frozen=True)
class PlainAnswer:
    """An answer in Python: the textbook's, one of a batch, or a pickled one."""

    kind: int
    numbers: bytes
    theta0: bytes
    position_tol: float
    orientation_tol: float
    theta: bytes
    unlimited: bytes | None
    position_error: float
    orientation_error: float
    iterations: int
    restarts: int
    stop: int
    nearest: bool
    other_branch: bool
    start_moved: bool


def plain(answer: Answer) -> PlainAnswer:
    """The same answer without the core."""
    return PlainAnswer(**{name: getattr(answer, name) for name in PlainAnswer.__dataclass_fields__})
