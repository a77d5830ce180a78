"""What a log does not show, and what to log, in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..limits.actuators import Actuators
from .faults import joints_of, slides
from .model import Wiring

LITTLE_ANGLE, LITTLE_LENGTH = np.radians(15.0), 0.05
"""A motor that moves its joint by less than this [rad, m] has hardly been moved."""

BASE_KNOWN = (
    "measure the base anew, by the tool in several postures; --base-position-noise (metres) and "
    "--base-orientation-noise (degrees) say how well it is known, 0 and 0 exactly"
)
"""Where the base and a motor are not told apart."""

ALL = ("sign", "ratio", "zero")


def moved(wiring: Wiring, i: int) -> bool:
    """Whether motor i was moved enough for its log to say anything."""
    travel = float(np.ptp(wiring.y[:, i]) / wiring.unit[i])
    return travel >= (LITTLE_LENGTH if slides(wiring, i) else LITTLE_ANGLE)


def enumerated(words: Sequence[str], last: str = "and") -> str:
    """`a`, `a and b`, `a, b and c`."""
    return f" {last} ".join(filter(None, [", ".join(words[:-1]), words[-1]]))


def not_shown(unseen: Sequence[str], swapped_with: Sequence[str]) -> str:
    """Of one motor; nothing where all of it is seen."""
    parts = [f"its {enumerated(unseen, 'or')}"] if unseen else []
    parts += [f"whether it is swapped with {' or '.join(map(repr, swapped_with))}"] if swapped_with else []
    return f"the log does not show {', nor '.join(parts)}" if parts else ""


def not_shown_of_all(
    names: Sequence[str], unseen: Sequence[Sequence[str]], swaps: Sequence[tuple[int, int]]
) -> tuple[str, bool]:
    """The gaps of the whole arm, motors with the same gaps together, and whether the log shows anything else."""
    if all(tuple(each) == ALL for each in unseen):
        return "the log does not show the sign, ratio or zero of any motor", False
    alike: dict[tuple[str, ...], list[str]] = {}
    for name, each in zip(names, unseen, strict=True):
        alike.setdefault(tuple(each), []).append(name)
    parts = [
        f"the {enumerated(gap, 'or')} of {enumerated([*map(repr, motors)])}" for gap, motors in alike.items() if gap
    ]
    parts += [f"whether {names[i]!r} and {names[j]!r} are swapped" for i, j in swaps]
    return f"the log does not show {', nor '.join(parts)}" if parts else "", True


def advice(wiring: Wiring, motors: Actuators, i: int) -> str:
    """What to log so that motor i is seen, and told from others."""
    names = [motors.joint_names[j] for j in joints_of(wiring, i)]
    joints = enumerated(names)
    if not moved(wiring, i):
        return f"move it: log {joints} at several places, {'100 mm' if slides(wiring, i) else '30°'} apart and more"
    if len(wiring.y) < 2 * wiring.k:
        return f"log more moments, {2 * wiring.k} at least, every joint moved by itself"
    if wiring.rotation is None:
        return "measure the tool's orientation too, or a point of the tool beside its axis"
    return f"log more moments in which {'each of ' * (len(names) > 1)}{joints} moves by itself"
