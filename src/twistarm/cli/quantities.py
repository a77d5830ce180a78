"""Numbers with units on the command line: their grammar, and the options that take one."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import numpy as np
from typer import BadParameter, Option

from ..arm.arm import Arm
from ..support.checks import Array
from ..support.errors import InputError
from ..support.units import UNITS, parse

LENGTH, ANGLE, NUMBER = "m", "rad", "1"

SUCH_AS = {
    LENGTH: "0.3, 300 mm or 12 in",
    ANGLE: "30 deg or 0.5 rad",
    NUMBER: "0.5",
    "s": "0.5 or 500 ms",
    "kg": "0.5 or 500 g",
    "Hz": "100 or 100 Hz",
    "m/s": "0.1 or 100 mm/s",
    "rad m": "0.1, 5 deg or 2 mm",
    "rad/s m/s": "0.5, 30 deg/s or 50 mm/s",
    "rad/s² m/s²": "2, 90 deg/s² or 500 mm/s²",
}
"""Examples of each quantity that an option takes, in the units of one or two."""

METAVARS = {units: units.upper().replace(" ", "|") for units in SUCH_AS} | {"rad": "ANGLE", "1": "NUMBER"}

OfJoints = Mapping[str, float]
"""A typed quantity of joints, by their units rad and m."""

_NAMES = "|".join(sorted({unit for units in UNITS.values() for unit in units if unit[0].isalpha()}, key=len)[::-1])
UNIT = rf"(?:{_NAMES}|°)(?:/s(?:\^?[23]|[²³])?)?(?![\w°/])"
"""A unit that may stand behind a number, a rate too."""

_PART = re.compile(
    rf"(?!-+(?!pi)[a-z])(?=.*[\w°])(?:[\d.]+(?:e[-+]?\d+)?|nan|inf|pi|{_NAMES}|[-−+*/^²°(),;\[\]])+", re.I
)
_VALUE = re.compile(rf"[^\s,;\[\]()]+(?:\s+{UNIT})?", re.IGNORECASE)


def is_part(word: str) -> bool:
    """Whether a typed word can be a number, its unit or several of them, also if they are wrong, as 1/0 and pi are."""
    return _PART.fullmatch(word) is not None


def separate(text: str) -> list[str]:
    """The numbers of a list, with their units. Spaces or commas separate them; brackets may enclose them."""
    return _VALUE.findall(text)


def typed_number(text: str, quantity: str = NUMBER, *, radians: bool = False) -> float:
    """A number with or without a unit, in SI; NaN if it is none of the `quantity`.

    An angle without a unit is in degrees, unless `radians` is set.
    """
    with suppress(InputError):
        return parse(text, quantity, "deg" if quantity == ANGLE and not radians else "")
    return math.nan


def quantity(units: str, told: str, *names: str, zero: bool = False) -> Any:
    """An option of a number above 0, or with `zero` from 0, that may have a unit.

    It gives the number in SI. An angle without a unit is in degrees. Of two `units`, for turns and slides, it gives
    `OfJoints`; a number without a unit is then in both.
    """
    each = units.split()

    def parse_option(typed: object) -> Any:
        values = {unit.partition("/")[0]: typed_number(str(typed), unit, radians=len(each) > 1) for unit in each}
        found = {unit: value for unit, value in values.items() if 0.0 < value < math.inf or (zero and value == 0.0)}
        if not found:
            least = "of 0 or more" if zero else "above 0"
            raise BadParameter(f"it takes a number {least} such as {SUCH_AS[units]}; got {typed}")
        return found if len(each) > 1 else found[each[0].partition("/")[0]]

    return Option(*names, metavar=METAVARS[units], parser=parse_option, help=told)


def whole(least: int, most: int, told: str, *names: str) -> Any:
    """An option of a whole number in [least, most]."""

    def parse_option(typed: object) -> int:
        with suppress(ValueError):
            if least <= (number := int(str(typed))) <= most:
                return number
        raise BadParameter(f"it takes a whole number from {least} to {most}; got {typed}")

    return Option(*names, metavar="N", parser=parse_option, help=told)


def of_joints(arm: Arm, typed: OfJoints, otherwise: float, option: str) -> Array:
    """The typed quantity of each joint (n,), `otherwise` for joints in other units."""
    if not typed.keys() & set(arm.units):
        raise InputError(f"{arm.name} has no joint in {' or '.join(typed)}, as {option} is")
    return np.array([typed.get(unit, otherwise) for unit in arm.units])
