"""Faults of a motor and gaps of a log: names, words, and what to correct or log."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..limits.actuators import Actuators
from ..support.errors import listed
from .model import Wiring
from .search import Found

SMALL_SCALE, SMALL_ANGLE, SMALL_LENGTH = 0.02, np.radians(1.0), 0.005
"""Normal errors of a scale or offset [joint rad, m]. They are no faults, even if the log shows them."""

ROUNDING = 1e-6
"""A motor does not drive a joint that it turns by less than this share of its largest."""

SIGN, RATIO, ZERO, SWAPPED = "flipped sign", "wrong ratio", "zero offset", "swapped"


def named_faults(found: Found, i: int) -> tuple[str, ...]:
    """The faults of motor i that are worth a name."""
    s, e = found.explanation.p[i], found.explanation.p[found.wiring.k + i]
    small = SMALL_LENGTH if slides(found.wiring, i) else SMALL_ANGLE
    named = {SWAPPED: i in found.swapped, SIGN: s < 0, RATIO: abs(abs(s) - 1.0) > SMALL_SCALE, ZERO: abs(e) > small}
    return tuple(name for name, there in named.items() if there)


def slides(wiring: Wiring, i: int) -> bool:
    """Whether the joint that motor i moves most slides."""
    return wiring.arm.units[int(np.abs(wiring.P[:, i]).argmax())] == "m"


def joints_of(wiring: Wiring, i: int) -> list[int]:
    """The joints that motor i moves, the other motors standing still."""
    moved = np.abs(wiring.P[:, i])
    return [int(j) for j in np.flatnonzero(moved > ROUNDING * moved.max())]


def offset_of(found: Found, i: int) -> float:
    """What is added to the readings of motor i [rad or m, motor side]."""
    return float(found.explanation.p[found.wiring.k + i] * found.wiring.unit[i])


def joint_offset(found: Found, motors: Actuators, i: int) -> dict[str, float]:
    """What the offset makes of the joints [rad or m]."""
    P, e = found.wiring.P, offset_of(found, i)
    return {motors.joint_names[j]: float(P[j, i] * e) for j in joints_of(found.wiring, i)}


def entries(found: Found, motors: Actuators, i: int) -> tuple[dict[str, float], float]:
    """`ratio` and `offset` that [actuators] should have for motor i as wired."""
    s = float(found.explanation.p[i])
    ratio = {joint: float(g / s) for joint, g in zip(motors.joint_names, motors.G[i], strict=True) if g}
    return ratio, float(motors.offset[i] - offset_of(found, i) / s)


def in_words(found: Found, motors: Actuators, i: int) -> str:
    """The faults of motor i."""
    others = [motors.names[j] for j in found.swapped if j != i]
    units = dict(zip(motors.joint_names, found.wiring.arm.units, strict=True))
    added = [f"{_amount(value, units[joint])} to {joint}" for joint, value in joint_offset(found, motors, i).items()]
    words = {
        SWAPPED: f"it is swapped with {listed(others)}: each has the other's counts",
        SIGN: "its sign is flipped",
        RATIO: f"its ratio is {1.0 / abs(found.explanation.p[i]):.4g} times the arm.toml's",
        ZERO: f"its zero is off: add {' and '.join(added)}",
    }
    return "; ".join(words[fault] for fault in named_faults(found, i))


def correction(found: Found, motors: Actuators, i: int) -> str:
    """What to change."""
    steps = ["swap their plugs, or their names in the arm.toml"] if i in found.swapped else []
    ratio, offset = entries(found, motors, i)
    if found.explanation.accounts[i] != "sound":
        written = ", ".join(f"{joint} = {value:.6g}" for joint, value in ratio.items())
        steps.append(f"as wired, [actuators.{motors.names[i]}] has ratio = {{ {written} }}, offset = {offset:.6g}")
    return "; ".join(steps)


def _amount(value: float, unit: str) -> str:
    return f"{1000 * value:+.1f} mm" if unit == "m" else f"{np.degrees(value):+.2f}°"


LITTLE_ANGLE, LITTLE_LENGTH = np.radians(15.0), 0.05
"""A motor that moves its joint by less than this [rad, m] has hardly moved."""

BASE_KNOWN = (
    "measure the base anew, by the tool in several configurations; --base-position-noise (metres) and "
    "--base-orientation-noise (degrees) say how well it is known, 0 and 0 exactly"
)
"""Remedy if base and motor cannot be separated."""

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
    """Gaps of the whole arm, with motors of equal gaps together, and whether the log shows anything."""
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
