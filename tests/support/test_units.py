"""The table of units: sizes in SI, written numbers, headers of columns."""

from __future__ import annotations

import math

import pytest

from twistarm.support.errors import InputError
from twistarm.support.units import column, factor, parse


@pytest.mark.parametrize(
    ("text", "quantity", "value"),
    [
        ("300 mm", "m", 0.3),
        ("12in", "m", 0.3048),  # an inch is 25.4 mm by definition
        ("-30deg", "rad", -math.pi / 6),
        ("−90 °", "rad", -math.pi / 2),
        ("0.5 turn", "rad", math.pi),
        ("1.5e3 ms", "s", 1.5),
        ("500 g", "kg", 0.5),
        ("2 kHz", "Hz", 2000.0),
        ("30 deg/s", "rad/s", math.pi / 6),
        ("500 mm/s^2", "m/s²", 0.5),
        ("90 deg/s2", "rad/s²", math.pi / 2),
        ("7 N m", "N m", 7.0),
        (".5", "1", 0.5),
    ],
)
def test_a_written_number_in_si(text, quantity, value):
    assert parse(text, quantity) == pytest.approx(value, rel=1e-12)


def test_a_number_without_a_unit_is_in_the_default():
    assert parse("180", "rad", "deg") == pytest.approx(math.pi)
    assert parse("180 rad", "rad", "deg") == 180.0


@pytest.mark.parametrize(
    ("text", "quantity"),
    [
        ("", "m"), ("mm", "m"), ("nan", "m"), ("1e999", "m"), ("0,5", "m"), ("1_000", "m"), ("3 deg", "m"),
        ("3 rad", "rad/s"), ("3 rad/s", "rad/s²"), ("3 rad/s/s", "rad/s"), ("1/0", "1"), ("pi", "rad"), ("2 2", "m"),
    ],
)  # fmt: skip
def test_anything_else_is_refused(text, quantity):
    with pytest.raises(InputError):
        parse(text, quantity)


@pytest.mark.parametrize(
    ("header", "found"),
    [
        ("x", ("x", "")),
        (" x [mm]", ("x", "mm")),
        ("Roll (deg)", ("roll", "deg")),
        ("roll_deg", ("roll", "deg")),
        ("left_m", ("left_m", "")),  # a name of its own wins over a unit
        ("y", (None, "")),
    ],
)
def test_a_column_s_header(header, found):
    assert column(header, {"x": "x", "roll": "roll", "left_m": "left_m", "left": "left"}) == found


def test_the_size_of_a_unit():
    assert factor("mm/s", "m/s") == 0.001
    assert factor("", "rad") == 1.0
    with pytest.raises(InputError):
        factor("mm", "rad")
