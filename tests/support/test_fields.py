"""Fields of files and messages, and the table of units."""

import math
from functools import partial

import numpy as np
import pytest

from twistarm.support import checks, fields
from twistarm.support.errors import InputError
from twistarm.support.strict_json import LARGEST_MESSAGE, decoded, encode
from twistarm.support.units import column, parse

MOTOR = partial(fields.fields, needed={"ratio": fields.table_of(checks.as_number)}, optional={"unit": fields.word})


def test_a_format_is_a_table_of_checks():
    found = fields.fields(
        {"name": "arm", "motors": {"m": {"ratio": {"elbow": 100}}}, "xyz": [1, 2.5, 0]},
        "",
        {"name": fields.word},
        {"motors": fields.table_of(MOTOR), "xyz": partial(fields.numbers, size=3), "tip": fields.word},
    )
    assert found == {"name": "arm", "motors": {"m": {"ratio": {"elbow": 100.0}}}, "xyz": [1.0, 2.5, 0.0]}


@pytest.mark.parametrize(
    ("check", "value", "result"),
    [
        (checks.as_number, np.float32(0.5), 0.5),
        (partial(checks.as_number, most=math.inf), math.inf, math.inf),
        (checks.number_in, " -1.5e2 ", -150.0),
        (partial(checks.number_in, least=-math.inf), "-inf", -math.inf),
        (checks.as_whole, 2**53 - 1, 2**53 - 1),
        (checks.as_flag, False, False),
        (fields.text, "", ""),
        (fields.one_of(("a", "b")), "b", "b"),
        (fields.list_of(checks.as_whole, 1, 2), [3], [3]),
    ],
)
def test_what_fits(check, value, result):
    assert check(value, "x") == result


@pytest.mark.parametrize(
    ("check", "value"),
    [
        *((checks.as_number, value) for value in (True, np.bool_(True), "3", None, math.nan, math.inf, 10**400)),
        (lambda _, name: checks.as_number(10**5000, name), None),  # which has no decimal text
        (partial(checks.as_number, least=0.0, most=10.0), 10.5),
        (checks.as_positive, 0),
        *((checks.number_in, text) for text in ("", "0,5", "1_000", "٣", "inf", "nan", "1 2", "0" * 401)),
        *((checks.as_whole, value) for value in (-1, 2**53, False, 1.0)),
        (fields.text, 3),
        (fields.word, " "),
        (checks.as_flag, 1),
        (fields.one_of(("a", "b")), ["a"]),
        (fields.list_of(checks.as_whole, 1, 2), [1, 2, 3]),
        (fields.list_of(checks.as_whole), {"a": 1}),
        (partial(fields.numbers, size=2), [0]),
        (fields.table_of(checks.as_whole), []),
        (MOTOR, 3),
    ],
)
def test_what_does_not_fit(check, value):
    with pytest.raises(InputError) as caught:
        check(value, "arm.elbow")
    assert "arm.elbow" in str(caught.value)
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize(
    ("value", "culprit"),
    [
        ({"ratio": {"elbow": "fast"}}, "motor.ratio.elbow"),
        ({"ratio": {}, "unit": ""}, "motor.unit"),
        ({"unit": "rad"}, "'ratio'"),
        ({"ratio": {}, "unitt": "rad"}, "'unitt' in motor; closest: 'unit'"),
    ],
)
def test_an_error_names_the_field(value, culprit):
    with pytest.raises(InputError) as caught, fields.inside("robot.toml", "line 3"):
        MOTOR(value, "motor")
    assert str(caught.value).startswith("robot.toml, line 3: ")
    assert culprit in str(caught.value)


def test_an_entry_of_a_list_is_counted():
    with pytest.raises(InputError, match=r"xyz\[1\]"):
        fields.numbers([0, None], "xyz")


def test_what_is_encoded_is_decoded():
    message = {"a": [1.5, -2], "b": {"c": None}, "d": "ß"}
    line = encode(message)
    assert "\n" not in line
    assert decoded(line) == decoded(line.encode()) == message
    with pytest.raises(ValueError, match="JSON"):
        encode({"time": float("nan")})


@pytest.mark.parametrize(
    "line",
    [
        '{"a": 1, "a": 2}',
        '{"a": {"b": 1, "b": 2}}',
        '{"a": NaN}',
        '{"a": 1%s}' % ("0" * 5000),
        "[1]",
        "[" * 60_000,
        " " * (LARGEST_MESSAGE + 1),
        b"\xff{}",
        7,
    ],
    ids=lambda value: repr(value)[:30],
)
def test_what_is_no_message(line):
    with pytest.raises(InputError) as caught:
        decoded(line)
    assert len(str(caught.value)) < 300
    assert "\n" not in str(caught.value)


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
