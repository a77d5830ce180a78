"""The page that describes inverse kinematics, the core's headers and the textbook solver name the same constants."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from twistarm.ik import textbook

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "inverse_kinematics.md").read_text("utf-8")
INCLUDE = ROOT / "core" / "include" / "twistarm"

OF_OTHER_ROOMS = {
    "actuators", "box", "chain", "conversion", "elementary", "frame", "instruction_set", "interval_limits",
    "kinematics", "lanes", "ldl", "motion_limits", "path_velocity", "quasi_newton", "resolved_rates", "screw_axes",
    "servo", "singular_directions", "spline_times",
}  # fmt: skip
"""Headers that the page does not go into."""


def initialisers(header):
    """{name: text} of what a header defines with a value: constants, and members of settings with a default."""
    text = re.sub(r"//.*", "", header.read_text("utf-8"))
    found = {}
    settings = "".join(re.findall(r"^(?:template <class T> )?struct \w+_settings \{.*?^\};", text, flags=re.M | re.S))
    members = re.findall(r"^    (?:T|int) (\w+ = [^;]+);", settings, flags=re.M)
    whole = re.findall(r"^(?:template <class T>\s+)?constexpr [\w:<>]+\s+(\w+(?:\[\d*\])?\s*=[^;]+);", text, flags=re.M)
    for declared in [*members, *whole]:
        for one in re.split(r",\s+(?=\w+\s*=)", declared):
            name, _, value = one.partition("=")
            found[re.sub(r"\W.*", "", name.strip())] = value
    return found


def number_of(text):
    """The value in double precision of a C++ initialiser; None where it is another constant."""
    text = re.sub(r"\b([a-z]\w+)<T>", lambda m: INITIALISERS.get(m[1], m[0]), text)
    text = re.sub(r"sizeof\(T\) == 8 \? ([^:]+) : [^,;})]+", r"\1", text).replace("__builtin_inf()", "math.inf")
    text = re.sub(r"\b(true|false)\b", lambda m: m[0].title(), re.sub(r"static_cast<T>|\bT(?=\()", "", text))
    text = re.sub(r"(?<=[\d.])(ULL|F|U)\b", "", text).strip().replace("{", "[").replace("}", "]")
    if re.fullmatch(r"[a-z]\w+", text):
        return None
    value = eval(text, {"math": math})
    return [float(x) for x in value] if isinstance(value, list) else float(value)


def said(text):
    """A value as the page has it: one number or several, units behind, yes and no for what is or is not."""
    numbers = [1.0 if word == "yes" else 0.0 if word == "no" else float(word.split()[0]) for word in text.split(", ")]
    return numbers if len(numbers) > 1 else numbers[0]


def constants_of(header):
    """{name: value} of what a header gives a value of its own."""
    values = {name: number_of(text) for name, text in initialisers(header).items() if name != "machine_epsilon"}
    return {name: value for name, value in values.items() if value is not None}


HEADERS = [
    header
    for header in sorted(INCLUDE.rglob("*.hpp"))
    if header.stem not in OF_OTHER_ROOMS and header.parent.name != "closed_form"
]
INITIALISERS = {name: text for header in HEADERS for name, text in initialisers(header).items()}
TOLD = {name: said(value) for name, value in re.findall(r"^\| `([a-z]\w+)` +\| ([^|]+?) +\|", PAGE, flags=re.M)}


@pytest.mark.promise("The rest of this page describes the algorithm, constant by constant.")
@pytest.mark.parametrize("header", HEADERS, ids=lambda header: header.stem)
def test_the_page_has_the_constants_of_a_header(header):
    constants = constants_of(header)
    assert constants == {name: pytest.approx(TOLD.get(name, math.nan), rel=1e-12) for name in constants}


def test_the_page_names_no_other_constants():
    assert set(TOLD) <= {name for header in HEADERS for name in constants_of(header)}


def test_the_textbook_has_the_constants_of_the_core():
    shared = {name: getattr(textbook, name.upper()) for name in TOLD if hasattr(textbook, name.upper())}
    assert {"damping", "least_damping", "rotation_weight", "progress", "stalls", "iterations"} <= set(shared)
    assert shared == {name: pytest.approx(TOLD[name], rel=1e-12) for name in shared}
