"""Options of numbers: with a unit, as expressions, and whole numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import numpy as np
from typer import BadParameter, Option

from ..arm.arm import Arm
from ..support.checks import Array
from ..support.errors import InputError
from .expression import SUCH_AS, evaluated

OfJoints = Mapping[str, float]
"""A typed quantity of joints, by their units rad and m."""

METAVARS = {units: units.upper().replace(" ", "|") for units in SUCH_AS} | {"rad": "ANGLE", "1": "NUMBER"}


def quantity(units: str, told: str, *names: str, zero: bool = False) -> Any:
    """An option of a number above 0, or with `zero` from 0, that may have a unit.

    It gives the number in SI. An angle without a unit is in degrees. Of two `units`, for turns and slides, it gives
    `OfJoints`; a number without a unit is then in both.
    """
    each = units.split()

    def parse(typed: object) -> Any:
        values = {unit.partition("/")[0]: evaluated(str(typed), unit, radians=len(each) > 1) for unit in each}
        found = {unit: value for unit, value in values.items() if 0.0 < value < math.inf or (zero and value == 0.0)}
        if not found:
            least = "of 0 or more" if zero else "above 0"
            raise BadParameter(f"it takes a number {least} such as {SUCH_AS[units]}; got {typed}")
        return found if len(each) > 1 else found[each[0].partition("/")[0]]

    return Option(*names, metavar=METAVARS[units], parser=parse, help=told)


def whole(least: int, most: int, told: str, *names: str) -> Any:
    """An option of a whole number in [least, most]."""

    def parse(typed: object) -> int:
        with suppress(ValueError):
            if least <= (number := int(str(typed))) <= most:
                return number
        raise BadParameter(f"it takes a whole number from {least} to {most}; got {typed}")

    return Option(*names, metavar="N", parser=parse, help=told)


def of_joints(arm: Arm, typed: OfJoints, otherwise: float, option: str) -> Array:
    """The typed quantity of each joint (n,), `otherwise` for joints in other units."""
    if not typed.keys() & set(arm.units):
        raise InputError(f"{arm.name} has no joint in {' or '.join(typed)}, as {option} is")
    return np.array([typed.get(unit, otherwise) for unit in arm.units])
