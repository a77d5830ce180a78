"""The text of an error: one line that any terminal can show, whatever stands in the file that it is about."""

from __future__ import annotations

import pickle

import pytest

from twistarm.support.errors import LONGEST, DescriptionError, MissingExtraError, TwistarmError, listed, one_line


@pytest.mark.parametrize("kind", [TwistarmError, DescriptionError, MissingExtraError])
def test_a_message_is_one_line_that_can_be_printed(kind: type[TwistarmError]) -> None:
    text = str(kind("joint 'a\nb': \x1b[31mred\x00 \ud800 \u2028 \u202e Gelenk_ä 关节 ξ"))
    assert text == r"joint 'a\nb': \x1b[31mred\x00 \ud800 \u2028 \u202e Gelenk_ä 关节 ξ"
    text.encode("utf-8")


def test_a_long_message_keeps_both_ends() -> None:
    text = str(TwistarmError("begin " + "\n" * 50_000 + " end"))
    assert text.startswith("begin ")
    assert text.endswith(" end")
    assert LONGEST <= len(text) <= LONGEST + 3
    assert one_line("x" * LONGEST) == "x" * LONGEST


def test_long_names_in_a_list_are_cut() -> None:
    assert len(listed(["n" * 5000] * 12)) < 1500
    assert listed(["a", "b"]) == "'a', 'b'"


def test_errors_travel_between_processes() -> None:
    error = DescriptionError("arm.urdf: a\nb", ("finding",))
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.findings) == (str(error), ("finding",))
