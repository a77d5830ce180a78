"""Typed expressions with units, such as 30+15, pi/4 or 2*(300 mm): the grammar of the page's expression.js."""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping

LENGTH, ANGLE, NUMBER = "m", "rad", "1"
UNITS: Mapping[str, Mapping[str, float]] = {
    LENGTH: {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254},
    ANGLE: {"rad": 1.0, "deg": math.radians(1.0), "°": math.radians(1.0)},
    NUMBER: {},
    "s": {"s": 1.0, "ms": 0.001, "min": 60.0},
    "kg": {"kg": 1.0, "g": 0.001},
    "Hz": {"hz": 1.0, "khz": 1000.0},
}
"""The units of each quantity, and their sizes."""

SUCH_AS = {
    LENGTH: "0.3, 300 mm or 12 in",
    ANGLE: "30 deg or pi/6",
    NUMBER: "0.5 or 1/2",
    "s": "0.5 or 500 ms",
    "kg": "0.5 or 500 g",
    "Hz": "100 or 100 Hz",
    "m/s": "0.1 or 100 mm/s",
    "rad m": "0.1, 5 deg or 2 mm",
    "rad/s m/s": "0.5, 30 deg/s or 50 mm/s",
    "rad/s² m/s²": "2, 90 deg/s² or 500 mm/s²",
}

LONGEST = 100
"""Most characters of an expression."""

UNIT = "|".join(sorted({unit for units in UNITS.values() for unit in units}, key=len, reverse=True))
PER = {"s": r"/\s*s(?![\w²^*]|\s*/\s*s)", "s²": r"/\s*s(?:²|2|\^2|\*\*2|\s*/\s*s)(?![\w²^*])"}
"""The ends of the units of rates."""
_NUMERAL = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e[+-]?[0-9]+)?"
_TOKEN = re.compile(rf"\s*({_NUMERAL}|[a-zπ°]+|.)")
_WORD = re.compile(
    rf"(?!-+(?!pi)[a-z])(?=.*[\w°])(?:{_NUMERAL}|pi|π|nan|inf|{UNIT}|²|\^|[-−+*/(),;\[\]])+", re.IGNORECASE
)
_BETWEEN = re.compile(rf"[,;\[\]]|(?<![-−+*/(\s])\s+(?!\s|[*/)]|[-−+]\s|(?:{UNIT})(?![a-z]))", re.IGNORECASE)
_SIGNS: Mapping[type[ast.operator], Callable[[complex, complex], complex]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}


def is_part(word: str) -> bool:
    """Whether a typed word can be an expression, or a part of one such as the unit after a number."""
    return _WORD.fullmatch(word) is not None


def separate(text: str) -> list[str]:
    """The expressions of a list, which spaces or commas separate, in brackets or not.

    A unit belongs to the number before it. A sign belongs to the number after it unless a space follows the sign.
    """
    inner = re.fullmatch(r"\s*\(([^()]*)\)\s*", text)
    return [each for each in _BETWEEN.split(inner[1] if inner else text) if each.strip()]


def evaluated(text: str, quantity: str = NUMBER, *, radians: bool = False) -> float:
    """The value of an expression in SI; NaN if it has none. `quantity` is one of `UNITS`, or a rate such as m/s.

    An angle without a unit is in degrees, unless `radians` is set or pi occurs in it.
    """
    plain = text.strip().lower().replace("−", "-").replace("π", "pi")
    quantity, _, per = quantity.partition("/")
    plain, rates = re.subn(PER[per], "", plain) if per else (plain, 1)
    bare = math.radians(1.0) if quantity == ANGLE and not radians and "pi" not in plain else 1.0
    try:
        value = _value(ast.parse(_python(plain, UNITS[quantity]), mode="eval").body)
    except (SyntaxError, ValueError, ArithmeticError):
        return math.nan
    return math.nan if value.imag and not rates else value.real * bare + value.imag


def _python(text: str, units: Mapping[str, float]) -> str:
    """The expression in Python: a bare number is real, and one with a unit imaginary. ValueError for other words."""
    parts = _TOKEN.findall(text) if len(text) <= LONGEST else [text]
    for i, part in enumerate(parts):
        if part in units:
            parts[i] = f"* {units[part]!r}j"
        elif re.fullmatch(f"{_NUMERAL}|pi", part):
            parts[i] = repr(math.pi if part == "pi" else float(part))
        elif part not in tuple("+-*/()"):
            raise ValueError(part)
    made = " ".join(parts)
    if re.search(r"(?:^|[-+*/(] )[-+] [-+]", made):  # two signs in a row
        raise ValueError(text)
    return made


def _value(node: ast.expr) -> complex:
    """The value of a part. ValueError for what the grammar does not have, such as a product of two lengths."""
    match node:
        case ast.Constant(value=float() | complex() as number):
            return complex(number)
        case ast.UnaryOp(op=op, operand=operand):
            return -_value(operand) if isinstance(op, ast.USub) else _value(operand)
        case ast.BinOp(left=left, op=op, right=right):
            a, b = _value(left), _value(right)
            if b.imag and (isinstance(op, ast.Div) or (isinstance(op, ast.Mult) and a.imag)):
                raise ValueError("a product of two quantities")
            return _SIGNS[type(op)](a, b)
    raise ValueError("no number")
