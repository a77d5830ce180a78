"""Numbers typed on the command line: configurations, positions, directions."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from ..arm.arm import Arm
from ..support.checks import Array
from ..support.errors import InputError, listed
from .output import note
from .quantities import ANGLE, SUCH_AS, UNIT, is_part, separate, typed_number

ROUNDING = 1e-6
"""A smaller distance outside a limit [rad, m] is rounding of a printed number."""


def parse_theta(arm: Arm, text: str, radians: bool, rest: tuple[str, Array] | None = None) -> Array:
    """A typed configuration: numbers base to tip, `joint=value` pairs, or the name of a pose.

    Omitted joints are as in `rest`, a name and its theta, by default the pose ready. A note says so. A value outside a
    limit by rounding becomes the limit.
    """
    if text.strip() in arm.configurations:
        return arm.theta_from(text.strip())
    return _onto_limits(arm, _typed(arm, text, radians, rest))


def parse_joints(arm: Arm, text: str, name: str, radians: bool) -> dict[str, float]:
    """Typed `joint=value` pairs, {joint: value} [rad, m]; `name`: of the option."""
    names, values = _pairs(text, f"{name} takes joint=value, as in {name} {arm.joint_names[-1]}=10; got {text!r}")
    theta = _onto_limits(arm, _of_joints(arm, names, values, radians))
    return {joint: float(theta[arm.joint_names.index(joint)]) for joint in names}


def _onto_limits(arm: Arm, theta: Array) -> Array:
    onto = np.clip(theta, arm.limits.lower, arm.limits.upper)
    return np.where(np.abs(theta - onto) <= ROUNDING, onto, theta)


def _typed(arm: Arm, text: str, radians: bool, rest: tuple[str, Array] | None) -> Array:
    poses = listed(arm.configurations)
    neither = f"{text!r} is neither joint values ({arm.n} numbers, or joint=value …) nor one of the poses {poses}"
    if "=" in text:
        return _by_joint(arm, *_pairs(text, neither), radians, rest)
    if not is_part("".join(text.split())):
        raise InputError(neither)
    values = separate(text)
    if len(values) != arm.n:
        raise InputError(f"{arm.name} takes {arm.n} values ({', '.join(arm.joint_names)}); got {len(values)}: {text!r}")
    return _of_joints(arm, arm.joint_names, values, radians)


def _by_joint(arm: Arm, names: list[str], values: list[str], radians: bool, rest: tuple[str, Array] | None) -> Array:
    """theta of typed joints, with the others as in `rest`."""
    typed = _of_joints(arm, names, values, radians)
    others = [name for name in arm.joint_names if name not in names]
    if not others:
        return typed
    name, theta = rest or ("the pose ready", arm.ready)
    note(f"{', '.join(others)} as in {name}")
    return np.where([joint in names for joint in arm.joint_names], typed, theta)


def _of_joints(arm: Arm, names: Sequence[str], values: Sequence[str], radians: bool) -> Array:
    """theta of typed joints, the others 0."""
    if len(set(names)) < len(names):
        raise InputError(f"a joint is named twice: {', '.join(names)}")
    units = dict(zip(arm.joint_names, arm.units, strict=True))
    numbers = [joint_value(*each, units.get(each[0], ANGLE), radians) for each in zip(names, values, strict=True)]
    others = [name for name in arm.joint_names if name not in names]
    return arm.theta_from([*names, *others], [*numbers, *(0.0 for _ in others)])


def joint_value(joint: str, text: str, unit: str, radians: bool) -> float:
    """A joint's typed value [rad, m]."""
    value = typed_number(text, unit, radians=radians)
    if not np.isfinite(value):
        raise InputError(f"{joint} takes a number such as {SUCH_AS[unit]}; got {text!r}")
    return value


def _pairs(text: str, otherwise: str) -> tuple[list[str], list[str]]:
    """Names and values of `joint=value` pairs, spaces inside names and around = allowed; else InputError."""
    pair = re.compile(rf"[\s,]*([^=]+?)\s*=\s*([^\s=,]+(?:\s+(?:{UNIT}))?)(?=[\s,]|$)", re.IGNORECASE)
    names, values, end = [], [], 0
    for match in pair.finditer(text):
        if match.start() != end:
            raise InputError(otherwise)
        names.append(match[1])
        values.append(match[2])
        end = match.end()
    if text[end:].strip(", "):
        raise InputError(otherwise)
    return names, values


def parse_numbers(text: str, units: str, name: str, radians: bool = False) -> Array:
    """Numbers [rad, m] separated by spaces or commas, one for each of `units`, such as 'm m rad'."""
    typed, quantities = separate(text), units.split()
    numbers = [typed_number(*each, radians=radians) for each in zip(typed, quantities, strict=False)]
    wrong = [each.strip() for each, number in zip(typed, numbers, strict=False) if not np.isfinite(number)]
    if len(typed) != len(quantities) or wrong:
        zeros = " ".join("0" for _ in quantities)
        such = SUCH_AS[quantities[0]]
        count = "a number" if len(quantities) == 1 else f"{len(quantities)} numbers"
        why = f", where {wrong[0]!r} is none" if wrong and len(typed) > 1 else ""
        raise InputError(f"{name} takes {count} such as {such}, as in {name} {zeros}; got {text!r}{why}")
    return np.array(numbers)
