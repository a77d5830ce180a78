"""Numbers typed on the command line: configurations, positions, directions."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
from typer.core import TyperCommand, TyperGroup

from ..arm.arm import Arm
from ..support.checks import Array
from ..support.errors import InputError, UnknownNameError, listed
from .output import as_written, note

VALUES = "VALUES"
POSE = "POSE"
XYZ, PLACE = "'X Y Z'", "'X Y YAW'"
RPY = "'R P Y'"
WXYZ, XYZW = "'W X Y Z'", "'X Y Z W'"
AXIS = "AXIS"
NUMBERS = (VALUES, POSE, XYZ, PLACE, RPY, WXYZ, XYZW, AXIS)
"""The values in the help of options that take several numbers."""

ROUNDING = 1e-6
"""A smaller distance outside a limit [rad, m] is rounding of a printed number."""

_AROUND = "[](),;"
"""Signs around numbers in the output of Python, NumPy and --json."""


class _Flags:
    """Hides the value of a flag in the help. Typer 0.29 writes <bool>."""

    def get_params(self, ctx: Any) -> list[Any]:
        params: list[Any] = super().get_params(ctx)  # type: ignore[misc]
        for param in params:
            if getattr(param, "is_flag", False) and param.metavar is None:
                param.metavar = ""
        return params


class Group(_Flags, TyperGroup):
    """The program, which holds the commands."""


class Command(_Flags, TyperCommand):
    """A command with options of several numbers without quotes: `--theta 0.1 -30 60`, `--xyz 0.8 -0.1 0.7`."""

    def __init__(self, *args: Any, **keywords: Any) -> None:
        """Escape brackets in the help, so that Rich does not read them as styles."""
        super().__init__(*args, **keywords)
        for param in self.params:
            param.help = as_written(getattr(param, "help", None) or "")  # type: ignore[attr-defined]

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Join such numbers to one word for Click."""
        several = [name for option in self.params if option.metavar in NUMBERS for name in option.opts]
        return super().parse_args(ctx, joined(args, several))


def joined(words: Sequence[str], options: Collection[str]) -> list[str]:
    """`words`, with numbers or joint=value pairs after one of `options` joined to one word."""
    made: list[str] = []
    goes_on = False
    for i, word in enumerate(words):
        if word == "--":
            return [*made, *words[i:]]
        if goes_on and _is_part(word):
            made[-1] += f" {word}"
            continue
        option, _, value = word.partition("=")
        goes_on = _is_part(word if made and made[-1] in options else value if option in options else "")
        made.append(word)
    return made


def _is_part(word: str) -> bool:
    """Whether a typed word is a number or joint=value."""
    name, equals, value = word.rpartition("=")
    try:
        float(_plain(value if equals and not name.startswith("-") else word))
    except ValueError:
        return False
    return True


def _plain(text: str) -> str:
    """`text` without brackets and commas around numbers, and with an ASCII minus."""
    return text.translate({ord(sign): " " for sign in _AROUND} | {ord("−"): "-"}).strip()


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
    try:
        names, values = _pairs(text)
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"{name} takes joint=value, as in {name} {arm.joint_names[-1]}=10; got {text!r}") from error
    theta = _onto_limits(arm, _of_joints(arm, names, values, radians))
    return {joint: float(theta[arm.joint_names.index(joint)]) for joint in names}


def _onto_limits(arm: Arm, theta: Array) -> Array:
    onto = np.clip(theta, arm.limits.lower, arm.limits.upper)
    return np.where(np.abs(theta - onto) <= ROUNDING, onto, theta)


def _typed(arm: Arm, text: str, radians: bool, rest: tuple[str, Array] | None) -> Array:
    try:
        if "=" in text:
            return _by_joint(arm, *_pairs(text), radians, rest)
        theta = np.array([float(word) for word in _plain(text).split()])
    except (UnknownNameError, InputError):
        raise
    except ValueError as error:
        raise InputError(
            f"{text!r} is neither joint values ({arm.n} numbers, or joint=value …) nor one of the poses "
            f"{listed(arm.configurations)}"
        ) from error
    if theta.shape != (arm.n,):
        raise InputError(f"{arm.name} takes {arm.n} values ({', '.join(arm.joint_names)}); got {len(theta)}: {text!r}")
    for name, value in zip(arm.joint_names, theta, strict=True):
        _require_finite(name, value, value)
    return theta if radians else from_degrees(arm, theta)


def _by_joint(arm: Arm, names: list[str], values: list[float], radians: bool, rest: tuple[str, Array] | None) -> Array:
    """theta of typed joints, with the others as in `rest`."""
    typed = _of_joints(arm, names, values, radians)
    others = [name for name in arm.joint_names if name not in names]
    if not others:
        return typed
    name, theta = rest or ("the pose ready", arm.ready)
    note(f"{', '.join(others)} as in {name}")
    return np.where([joint in names for joint in arm.joint_names], typed, theta)


def _of_joints(arm: Arm, names: list[str], values: list[float], radians: bool) -> Array:
    """theta of typed joints, the others 0."""
    if len(set(names)) < len(names):
        raise InputError(f"a joint is named twice: {', '.join(names)}")
    others = [name for name in arm.joint_names if name not in names]
    typed = arm.theta_from([*names, *others], [*values, *(0.0 for _ in others)])
    return typed if radians else from_degrees(arm, typed)


def _pairs(text: str) -> tuple[list[str], list[float]]:
    """Names and values of `joint=value` pairs, spaces inside names and around = allowed; else ValueError."""
    pair = re.compile(r"[\s,]*([^=]+?)\s*=\s*([^\s=,]+)(?=[\s,]|$)")
    names, values, end = [], [], 0
    for match in pair.finditer(text):
        if match.start() != end:
            raise ValueError(text)
        name, value = match.groups()
        try:
            number = float(_plain(value))
        except ValueError:
            number = np.nan
        _require_finite(name, number, value)
        names.append(name)
        values.append(number)
        end = match.end()
    if text[end:].strip(", "):
        raise ValueError(text)
    return names, values


def _require_finite(joint: str, number: float, typed: object) -> None:
    if not np.isfinite(number):
        raise InputError(f"{joint} takes a number, as in {joint}=10; got {typed}")


def from_degrees(arm: Arm, values: Array) -> Array:
    """Typed values, degrees and metres, in rad and m."""
    return np.where(np.array(arm.units) == "rad", np.radians(values), values)


def parse_numbers(text: str, count: int, name: str) -> Array:
    """`count` numbers separated by spaces or commas."""
    try:
        numbers = np.array([float(word) for word in _plain(text).split()])
    except ValueError:
        numbers = np.array([])
    if numbers.shape != (count,) or not np.isfinite(numbers).all():
        raise InputError(f"{name} takes {count} numbers, as in {name} {' '.join(['0'] * count)}; got {text!r}")
    return numbers
