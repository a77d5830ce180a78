"""The report of the wiring check: a verdict on each motor, in words and for programs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from typing import NamedTuple

from ..support.checks import Array
from ..support.display import told
from ..support.errors import ComparisonError


class Residual(NamedTuple):
    """Root mean square of measured against computed: position [m], rotation [rad] or None."""

    position: float
    rotation: float | None


@dataclass(frozen=True)
class MotorVerdict:
    """The log's verdict on one motor; by default none.

    `verdict` is "sound", "fault", "possible fault" or "cannot tell". `faults` are from "flipped sign", "wrong ratio",
    "zero offset" and "swapped". A fault is possible if the log does not separate it from another, or from a base that
    stands elsewhere. `unseen` is what the log does not show: "sign", "ratio", "zero" or "swapped with NAME".

    The fit reads the motor as `scale` y + `offset` [rad or m, motor side]. Their standard deviations hold when all
    parameters are fitted; inf if the log shows nothing. `joint_offset` is the offset of the joints [rad or m]. `ratio`
    and `zero` are the right entries of arm.toml for the present wiring. None: the log does not tell. `what` and
    `remedy` say it in words.
    """

    name: str
    verdict: str = "cannot tell"
    faults: tuple[str, ...] = ()
    unseen: tuple[str, ...] = ("sign", "ratio", "zero")
    scale: float = 1.0
    scale_std: float = inf
    offset: float = 0.0
    offset_std: float = inf
    joint_offset: Mapping[str, float] = field(default_factory=dict)
    ratio: Mapping[str, float] | None = None
    zero: float | None = None
    what: str = ""
    remedy: str = ""


@dataclass(frozen=True, eq=False, repr=False)
class WiringReport:
    """The verdict on the whole arm ("sound", "fault", "cannot tell", "unexplained"), and on each motor.

    `before` is the residual with the values of arm.toml, `after` that with the found scales and offsets. `rows` moments
    were logged; `worst_row`, counted from 1, fits least. `base` (4, 4) is where the base seems to stand, seen from its
    measured place, if the log needs that. None: as measured.
    """

    arm: str
    verdict: str
    what: str
    motors: tuple[MotorVerdict, ...]
    rows: int
    before: Residual
    after: Residual
    worst_row: int
    base: Array | None = None

    def __repr__(self) -> str:
        return told("WiringReport", {"arm": self.arm, "verdict": self.verdict, "what": self.what})

    @property
    def ok(self) -> bool:
        """Every motor is sound, and the log says so."""
        return self.verdict == "sound"

    def require(self) -> WiringReport:
        """Itself, or ComparisonError with what was found."""
        if not self.ok:
            faulty = [f"{motor.name}: {motor.what}" for motor in self.motors if motor.verdict != "sound" and motor.what]
            raise ComparisonError(f"the wiring of {self.arm}: {'; '.join([self.what, *faulty])}")
        return self
