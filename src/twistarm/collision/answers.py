"""Answers of a scene: distances, contacts and the first collision of a motion."""

from __future__ import annotations

from dataclasses import dataclass

from ..support.checks import Array


def in_millimetres(metres: float) -> str:
    """The size of a distance [m] in mm, short distances to 0.1 mm."""
    size = 1000.0 * abs(metres)
    return f"{size:.0f} mm" if size >= 10.0 else f"{size:.1g} mm" if size >= 0.05 else "less than 0.1 mm"


@dataclass(frozen=True)
class Distance:
    """The nearest pair of bodies: `metres` apart, negative by the depth of an overlap.

    `links` are the names of the two links or obstacles. `points` (2, 3) are their nearest points in the base frame [m].
    `metres` is inf and `links` empty if the scene has no pair to check. `time` [s] is that on a motion, else None.
    """

    metres: float
    links: tuple[str, ...]
    points: Array
    time: float | None = None

    def __str__(self) -> str:
        if not self.links:
            return "nothing to collide with"
        where, size = f"{self.links[0]} and {self.links[1]}", in_millimetres(self.metres)
        when = "" if self.time is None else f", at {self.time:.2f} s"
        return (f"{where}, {size} apart" if self.metres >= 0.0 else f"{where} overlap by {size}") + when


@dataclass(frozen=True)
class Contact:
    """A pair nearer than its `margin` [m]. The `distance` [m] is negative by the depth of an overlap."""

    links: tuple[str, str]
    distance: float
    margin: float

    def __str__(self) -> str:
        where = f"{self.links[0]} and {self.links[1]}"
        if self.distance < 0.0:
            return f"{where} overlap by {in_millimetres(self.distance)}"
        return f"{where}: {in_millimetres(self.distance)} apart, {in_millimetres(self.margin)} asked"


@dataclass(frozen=True, eq=False)
class Collision:
    """The first collision of a motion: its `time` [s], the configuration theta (n,) there, and the contacts."""

    time: float
    theta: Array
    contacts: tuple[Contact, ...]
