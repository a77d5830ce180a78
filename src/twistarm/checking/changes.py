"""Changes of limits, motors and masses between two arms, in words, one sentence each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ..description.inertial import Body
from ..limits.actuators import Actuators
from ..limits.joint_limits import RATES, JointLimits
from ..support.checks import Array

SAME_TOL = 1e-6
"""Smaller differences, below 1 µm and 1e-6 rad, come from rounding in an export, not from a changed description."""

SAME_RATIO_TOL = 1e-9
"""Relative: ratios and ticks are written by hand, and a ratio of 1e-4 m per rad is a usual one."""

SAME_MASS_TOL = 1e-5
"""Relative, of masses and inertias: exports write six digits."""


def name_changes(kind: str, before: Sequence[str], now: Sequence[str]) -> list[str]:
    """Which joints, or motors, are gone or new; else whether their order is another."""
    changes = [f"{kind} {name} is gone" for name in before if name not in now]
    changes += [f"{kind} {name} is new" for name in now if name not in before]
    if not changes and list(before) != list(now):
        changes.append(f"the {kind}s' order was {', '.join(before)}, is {', '.join(now)}")
    return changes


def limit_changes(name: str, unit: str, then: JointLimits, i: int, now: JointLimits, j: int) -> Iterator[str]:
    """Changes in the limits of one joint or motor, number `i` before and `j` now."""
    before, after = ((float(one.lower[k]), float(one.upper[k])) for one, k in ((then, i), (now, j)))
    if not all(map(_same, before, after)):
        lower, upper = map(_pair, before, after)
        spans = (f"[{low}, {high}]" for low, high in zip(lower, upper, strict=True))
        yield f"limits of {name} {_word(*before, *after)}: {' to '.join(spans)} {unit}"
    for rate in RATES:
        old, new = float(getattr(then, rate)[i]), float(getattr(now, rate)[j])
        if not _same(old, new):
            yield f"{rate} limit of {name} {'lowered' if new < old else 'raised'}: {' to '.join(_pair(old, new))}"


def mass_changes(then: Mapping[str, Body], now: Mapping[str, Body]) -> Iterator[str]:
    """How the masses of the links have changed, their centres and their inertias."""
    for link in {**then, **now}:
        if link not in now or link not in then:
            yield f"the mass of link {link} is {'new' if link in now else 'gone'}"
            continue
        before, after = then[link], now[link]
        if not _same_share(before.mass, after.mass, max(before.mass, after.mass)):
            word = "lowered" if after.mass < before.mass else "raised"
            yield f"mass of link {link} {word}: {' to '.join(_pair(before.mass, after.mass))} kg"
        shift = float(np.linalg.norm(after.centre - before.centre))
        if shift > SAME_TOL:
            yield f"centre of mass of link {link} moved {1e3 * shift:.4g} mm"
        largest = max(float(np.abs(body.inertia).max()) for body in (before, after))
        if not _same_share(before.inertia, after.inertia, largest):
            share = float(np.abs(after.inertia - before.inertia).max()) / largest
            yield f"inertia of link {link} changed by {100 * share:.3g} % of its largest moment"


def _same_share(before: Array | float, after: Array | float, whole: float) -> bool:
    return bool(np.abs(np.subtract(after, before)).max() <= SAME_MASS_TOL * whole)


def motor_changes(then: Actuators | None, now: Actuators | None) -> list[str]:
    """Changes of an arm's motors: names, units, ticks, ratios, offsets and limits."""
    before, after = (() if motors is None else motors.names for motors in (then, now))
    changes = name_changes("motor", before, after)
    if then is None or now is None:
        return changes
    for i, name in enumerate(before):
        if name in after:
            j = after.index(name)
            old, new = _motor(then, i), _motor(now, j)
            parts = [
                f"{part} from {' to '.join(_pair(old.get(part, 0.0), new.get(part, 0.0)))}"
                for part in {**old, **new}
                if not _same_ratio(old.get(part, 0.0), new.get(part, 0.0))
            ]
            if then.units[i] != now.units[j]:
                parts.append(f"unit from {then.units[i]} to {now.units[j]}")
            changes += [f"motor {name} changed its {part}" for part in parts]
            changes += limit_changes(f"motor {name}", now.motor_units[j], then.limits, i, now.limits, j)
    return changes


def _motor(motors: Actuators, i: int) -> dict[str, float]:
    """The numbers of one motor, by name."""
    ratios = {f"ratio to joint {joint}": float(motors.G[i, k]) for k, joint in enumerate(motors.joint_names)}
    return ratios | {"ticks per turn": float(motors.ticks_per_turn[i]), "offset": float(motors.offset[i])}


def _same(a: float, b: float) -> bool:
    return a == b or abs(a - b) <= SAME_TOL


def _same_ratio(a: float, b: float) -> bool:
    return bool(np.isclose(a, b, rtol=SAME_RATIO_TOL, atol=0.0, equal_nan=True))


def _word(lower: float, upper: float, new_lower: float, new_upper: float) -> str:
    if new_lower >= lower and new_upper <= upper:
        return "narrowed"
    return "widened" if new_lower <= lower and new_upper >= upper else "shifted"


def _pair(before: float, after: float) -> tuple[str, str]:
    """Two numbers in as few digits, six at least, as tell them apart."""
    pairs = ((_number(before, digits), _number(after, digits)) for digits in (6, 9, 12, 17))
    return next(((a, b) for a, b in pairs if a != b or before == after), ("", ""))


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}g}" if np.isfinite(value) else "not given"
