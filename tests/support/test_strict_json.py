"""JSON from outside: what is not exactly one object of finite numbers is refused in one line."""

from __future__ import annotations

import pytest

from twistarm.support.errors import InputError
from twistarm.support.strict_json import LARGEST_MESSAGE, decoded, encode


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
