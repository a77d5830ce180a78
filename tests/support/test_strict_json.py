"""JSON from outside: what is not exactly one object of finite numbers is refused in one line."""

from __future__ import annotations

import pytest

from twistarm.support.errors import InputError
from twistarm.support.strict_json import LARGEST_MESSAGE, counter, decoded, encode, flag, number, numbers, text


def test_what_is_encoded_is_decoded():
    message = {"a": [1.5, -2], "b": {"c": None}, "d": "ß"}
    line = encode(message)
    assert "\n" not in line
    assert decoded(line) == decoded(line.encode()) == message
    with pytest.raises(ValueError, match="JSON compliant"):
        encode({"time": float("nan")})


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ('{"a": 1, "a": 2}', "each name once"),
        ('{"a": {"b": 1, "b": 2}}', "each name once"),
        ('{"a": NaN}', "numbers must be finite; got NaN"),
        ("[1]", r"one JSON object; got \[1\]"),
        ("[" * 60_000, "one JSON object; it nests too deep"),
        (" " * (LARGEST_MESSAGE + 1), "at most 65536 bytes; got 65537"),
        (b"\xff{}", "one JSON object"),
    ],
    ids=lambda value: repr(value[:30]),
)
def test_what_is_no_message(line, why):
    with pytest.raises(InputError, match=why) as caught:
        decoded(line)
    assert len(str(caught.value)) < 300
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("read", "value", "why"),
    [
        (number, True, "x must be a number; got True"),
        (number, 10**400, "x must be finite"),
        (lambda value, name: number(value, name, 10.0), -10.5, "x must be finite and at most 10 in size; got -10.5"),
        (numbers, [0, None], r"x\[1\] must be a number; got None"),
        (lambda value, name: numbers(value, name, 2), [0], "x must be a list of 2 numbers"),
        (lambda value, name: numbers(value, name, largest=1.0), [0, 2], r"x\[1\] must be finite and at most 1 in size"),
        (counter, -1, "x must be a whole number"),
        (counter, 2**53, "x must be a whole number"),
        (counter, False, "x must be a whole number"),
        (text, 3, "x must be text; got 3"),
        (flag, 1, "x must be true or false; got 1"),
    ],
)
def test_what_does_not_fit(read, value, why):
    with pytest.raises(InputError, match=why):
        read(value, "x")


def test_an_integer_without_a_decimal_text():
    with pytest.raises(InputError, match="x must be finite"):
        number(10**5000, "x")
    with pytest.raises(InputError, match="one JSON object|must be finite"):
        number(decoded('{"x": 1%s}' % ("0" * 5000))["x"], "x")


def test_what_fits():
    assert number(3, "x") == 3.0
    assert numbers([1, 2.5], "x", 2) == [1.0, 2.5]
    assert counter(2**53 - 1, "x") == 2**53 - 1
    assert text("", "x") == ""
    assert flag(False, "x") is False
