"""Typed numbers with units: their grammar, the options that take them, and joint values."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from typer import Argument, Option

from ..arm.arm import Arm
from ..support.checks import Array
from ..support.errors import InputError, closest, listed
from ..support.units import NUMBER as WRITTEN
from ..support.units import UNITS, parse
from .output import note, warn
from .tables import outside

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

METAVARS = {units: units.upper().replace(" ", "|") for units in SUCH_AS} | {ANGLE: "ANGLE", NUMBER: "NUMBER"}
VALUES, AXIS = "VALUES", "AXIS"
XYZ, RPY, WXYZ, XYZW, PLACE = "'X Y Z'", "'R P Y'", "'W X Y Z'", "'X Y Z W'", "'X Y YAW'"
# The values in the help of options that take several words: numbers, and units after them.
NUMBERS = (VALUES, AXIS, XYZ, RPY, WXYZ, XYZW, PLACE, *METAVARS.values())
OfJoints = Mapping[str, float]  # A typed quantity of joints, by their units rad and m.
PRINTED_ROUNDING = 1e-6  # A smaller distance outside a limit [rad, m] is rounding of a printed number.

_NAMES = "|".join(sorted({unit for units in UNITS.values() for unit in units if unit[0].isalpha()}, key=len)[::-1])
# A unit that may follow a number, a rate too.
UNIT = rf"(?:{_NAMES}|°)(?:/s(?:\^?[23]|[²³])?)?(?![\w°/])"

_PART = re.compile(
    rf"(?!-+(?!pi)[a-z])(?=.*[\w°])(?:[\d.]+(?:e[-+]?\d+)?|nan|inf|pi|{_NAMES}|[-−+*/^²°(),;\[\]])+", re.I
)
_VALUE = re.compile(rf"[^\s,;\[\]()]+(?:\s+{UNIT})?", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"(?<![\w.,])[-+−]?\d+,\d+(?![\d.,]|\s*=)")  # 0,1, but not 1=10,2=20 of joints 1 and 2
_NO_LIST = re.compile(r"[^\s,]\s+[-+−]?[\d.]|=")  # Commas do not separate what has spaces alone, or joint=value.
# joint=value, where spaces may be in the name and around the sign.
_PAIR = re.compile(rf"[\s,]*([^=]+?)\s*=\s*([^\s=,]+(?:\s+(?:{UNIT}))?)(?=[\s,]|$)", re.IGNORECASE)


def is_part(word: str) -> bool:
    """Whether a typed word can be a number, its unit or several of them. They may be wrong, as 1/0 and pi."""
    return _PART.fullmatch(word) is not None


def separate(text: str, option: str) -> list[str]:
    """The numbers of a list between spaces or commas, with their units. InputError for a decimal comma."""
    comma = _DECIMAL_COMMA.search(text)
    if comma and _NO_LIST.search(text):
        raise InputError(f"{option}: {comma[0]} is two numbers; write the decimal {comma[0].replace(',', '.')}")
    return _VALUE.findall(text)


def require_units(typed: Sequence[str], quantities: Sequence[str], option: str, radians: bool) -> None:
    """Raise InputError if a number has an unusual unit and another of its quantity, not 0, has none."""
    for quantity in dict.fromkeys(quantities):
        alike = [(text, WRITTEN.sub("", text)) for text, of in zip(typed, quantities, strict=True) if of == quantity]
        usual = typed_number("1", quantity, radians=radians)
        other = [unit for _, unit in alike if unit and typed_number(f"1{unit}", quantity) != usual]
        bare = [text for text, unit in alike if not unit and typed_number(text, quantity)]
        if bare and other:
            each = " ".join(text if unit else text + other[-1] for text, unit in alike)
            raise InputError(f"{option}: {other[-1]} belongs to the number before it, {bare[0]} has none; write {each}")


def typed_number(text: str, quantity: str = NUMBER, *, radians: bool = False) -> float:
    """A number with or without a unit, in SI. NaN if it is no `quantity`.

    An angle without a unit is in degrees, unless `radians` is set.
    """
    with suppress(InputError):
        return parse(text, quantity, "deg" if quantity == ANGLE and not radians else "")
    return math.nan


def parse_numbers(text: str, units: str, option: str, radians: bool = False) -> Array:
    """Numbers [rad, m] separated by spaces or commas, one for each of `units`, such as 'm m rad'."""
    typed, quantities = separate(text, option), units.split()
    values = [typed_number(*pair, radians=radians) for pair in zip(typed, quantities, strict=False)]
    wrong = [written.strip() for written, value in zip(typed, values, strict=False) if not np.isfinite(value)]
    if len(typed) != len(quantities) or wrong:
        example = " ".join("100"[: len(quantities)] + "0" * (len(quantities) - 3))
        why = f"; {wrong[0]!r} is not such a number" if wrong else ""
        such = SUCH_AS[quantities[0]]
        raise InputError(
            f"{option} takes {len(quantities)} numbers such as {such}, as in {option} {example}; got {text!r}{why}"
        )
    require_units(typed, quantities, option, radians)
    return np.array(values)


@dataclass(frozen=True)
class Typed:
    """The text of an option. `Command` reads it, with the option's name, as soon as it knows of --rad."""

    text: str
    read: Callable[[str, str, bool], Any]


def option(metavar: str | None, help_text: str, *names: str, **more: Any) -> Any:
    """An option with its value as `--help` calls it, and its help."""
    return Option(*names, metavar=metavar, help=help_text, **more)


def switch(help_text: str, *names: str, **more: Any) -> Any:
    """An option without a value."""
    return Option(*names, help=help_text, **more)


def argument(metavar: str, help_text: str, **more: Any) -> Any:
    """An argument as `--help` calls it, and its help."""
    return Argument(metavar=metavar, help=help_text, **more)


def typed_option(read: Callable[[str, str, bool], Any], metavar: str, help_text: str, *names: str) -> Any:
    """An option with the value that `read` makes of its text, its name and whether --rad was typed."""
    return option(metavar, help_text, *names, parser=lambda text: Typed(str(text), read))


def numbers(units: str, metavar: str, help_text: str, *names: str) -> Any:
    """An option of several numbers, one for each of `units`, which gives them in SI as an array."""

    def read(text: str, option: str, radians: bool) -> Array:
        values = parse_numbers(text, units, option, radians)
        # 400 typed degrees are 40; in radians they are a mistake, which the target refuses.
        turning = [unit == ANGLE and not radians for unit in units.split()]
        return np.where(turning, np.fmod(values, 2.0 * np.pi), values)

    return typed_option(read, metavar, help_text, *names)


def quantity(units: str, help_text: str, *names: str, zero: bool = False) -> Any:
    """An option of a number above 0, or with `zero` from 0, that may have a unit. It gives the number in SI.

    Of two `units`, for turns and slides, it gives `OfJoints`. A number without a unit is then in both, in SI.
    """
    choices = units.split()

    def read(text: str, option: str, radians: bool) -> Any:
        radians = radians or len(choices) > 1
        values = {unit.partition("/")[0]: typed_number(text, unit, radians=radians) for unit in choices}
        found = {unit: value for unit, value in values.items() if 0.0 < value < math.inf or (zero and value == 0.0)}
        if not found:
            least = "of 0 or more" if zero else "above 0"
            raise InputError(f"{option} takes a number {least} such as {SUCH_AS[units]}; got {text!r}")
        return found if len(choices) > 1 else found[choices[0].partition("/")[0]]

    return typed_option(read, METAVARS[units], help_text, *names)


def whole(least: int, most: int, help_text: str, *names: str) -> Any:
    """An option of a whole number in [least, most]."""

    def read(text: str, option: str, _: bool) -> int:
        with suppress(ValueError):
            if least <= (value := int(text)) <= most:
                return value
        raise InputError(f"{option} takes a whole number from {least} to {most}; got {text!r}")

    return typed_option(read, "N", help_text, *names)


def of_joints(arm: Arm, typed: OfJoints, otherwise: float, option: str) -> Array:
    """The typed quantity of each joint (n,), `otherwise` for joints in other units."""
    if not typed.keys() & set(arm.units):
        raise InputError(f"{arm.name} has no joint in {' or '.join(typed)}, as {option} is")
    return np.array([typed.get(unit, otherwise) for unit in arm.units])


@dataclass(frozen=True)
class JointValues:
    """Typed joint values: numbers base to tip, `joint=value` pairs, or a name. The arm knows their units.

    A value outside a limit by rounding becomes the limit.
    """

    text: str
    option: str
    radians: bool

    def of(self, arm: Arm, rest: tuple[str, Array] | None = None) -> Array:
        """theta (n,) of the arm. Omitted joints are as in `rest`, a name and its theta, by default ready."""
        if self.text.strip() in arm.configurations:
            return arm.theta_from(self.text.strip())
        wrong = next((word for word in self.text.split() if "=" not in word and not is_part(word)), self.text)
        neither = (
            f"{self.option} takes joint values ({arm.n} numbers, or joint=value …) or one of the configurations "
            f"{listed(arm.configurations)}; {wrong!r} is none of them{closest(wrong, arm.configurations)}"
        )
        if "=" not in self.text:
            if not is_part("".join(self.text.split())):
                raise InputError(neither)
            values = separate(self.text, self.option)
            if len(values) != arm.n:
                wanted = f"{arm.n} values ({', '.join(arm.joint_names)})"
                raise InputError(f"{arm.name} takes {wanted}; got {len(values)}: {self.text!r}")
            return self._theta(arm, arm.joint_names, values)
        names, values = self._pairs(neither)
        theta, others = self._theta(arm, names, values), [name for name in arm.joint_names if name not in names]
        if not others:
            return theta
        which, as_before = rest or ("ready", arm.ready)
        note(f"{', '.join(others)} as in {which}")
        return np.where([joint in names for joint in arm.joint_names], theta, as_before)

    def anywhere(self, arm: Arm) -> Array:
        """As `of`, for what also works outside the position limits: a warning names each joint that is there."""
        theta = self.of(arm)
        for words in outside(arm, theta, self.radians):
            warn(words)
        return theta

    def joints(self, arm: Arm) -> dict[str, float]:
        """The values of `joint=value` pairs alone, {joint: value} [rad, m]."""
        such = f"{self.option} takes joint=value, as in {self.option} {arm.joint_names[-1]}=10; got {self.text!r}"
        names, values = self._pairs(such)
        theta = self._theta(arm, names, values)
        return {joint: float(theta[arm.joint_names.index(joint)]) for joint in names}

    def _theta(self, arm: Arm, names: Sequence[str], values: Sequence[str]) -> Array:
        """theta (n,) of typed joints, the others 0."""
        if len(set(names)) < len(names):
            raise InputError(f"a joint is named twice: {', '.join(names)}")
        units = dict(zip(arm.joint_names, arm.units, strict=True))
        found = dict.fromkeys(arm.joint_names, 0.0)
        for joint, text in zip(names, values, strict=True):
            unit = units.get(joint, ANGLE)
            found[joint] = typed_number(text, unit, radians=self.radians)
            if not np.isfinite(found[joint]):
                raise InputError(f"{joint} takes a number such as {SUCH_AS[unit]}; got {text!r}")
        require_units(values, [units.get(joint, ANGLE) for joint in names], self.option, self.radians)
        theta = arm.theta_from([*found], [*found.values()])
        onto = np.clip(theta, arm.limits.lower, arm.limits.upper)
        return np.where(np.abs(theta - onto) <= PRINTED_ROUNDING, onto, theta)

    def _pairs(self, otherwise: str) -> tuple[list[str], list[str]]:
        """Names and values of the pairs. InputError with the text `otherwise` if there is anything else."""
        separate(self.text, self.option)  # refuses a decimal comma
        pairs = _PAIR.findall(self.text)
        if not pairs or _PAIR.sub("", self.text).strip(", "):
            raise InputError(otherwise)
        return [name for name, _ in pairs], [value for _, value in pairs]


def joint_values(help_text: str, *names: str) -> Any:
    """An option of `JointValues`."""
    return typed_option(JointValues, VALUES, help_text, *names)
