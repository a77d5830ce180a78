"""Numbers typed as expressions with units: the cases of the page's grammar, and commands that answer by them."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from twistarm.cli.application import run
from twistarm.cli.expression import evaluated, is_part, separate
from twistarm.cli.typed import joined

CASES = json.loads((Path(__file__).parents[1] / "data/expressions.json").read_text(encoding="utf-8"))
"""{quantity: {expression: value [rad, m], null where it has none}}; tests/browser has the same for the page."""


@pytest.mark.parametrize("quantity", CASES)
def test_expressions_have_the_value_that_they_have_on_the_page(quantity: str) -> None:
    unit, radians = "m" if quantity == "metres" else "rad", quantity == "radians"
    found = {text: evaluated(text, unit, radians=radians) for text in CASES[quantity]}
    assert {text: value if math.isfinite(value) else None for text, value in found.items()} == {
        text: value and pytest.approx(value, rel=1e-12) for text, value in CASES[quantity].items()
    }


def test_long_expressions_are_none() -> None:
    assert math.isnan(evaluated("(" * 5000 + "1" + ")" * 5000))
    assert math.isnan(evaluated("+".join("1" * 5000)))


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("0.8 -0.1 0.7", ["0.8", "-0.1", "0.7"]),
        ("30 + 15 2 - 1", ["30 + 15", "2 - 1"]),
        ("300  mm 0.1 12 in", ["300  mm", "0.1", "12 in"]),
        ("[0.1, -0.2,\n 0.3]", ["0.1", "-0.2", "0.3"]),
        ("(0 0 1)", ["0", "0", "1"]),
        ("2*(300 mm) pi", ["2*(300 mm)", "pi"]),
    ],
)
def test_a_list_is_taken_apart_between_its_values(text: str, values: list[str]) -> None:
    assert [value.strip() for value in separate(text)] == values


def test_only_numbers_and_units_go_on_with_an_option() -> None:
    assert all(map(is_part, ["300", "mm", "-pi/2", "2*(300", "mm)", "[0.1,", "−5", "nan"]))
    assert not any(map(is_part, ["-o", "-m", "--rad", "-", "rover_arm", "3_dof.urdf", "info", "--"]))


@pytest.mark.parametrize(
    ("words", "value"),
    [
        (["300 mm", "0.1", "12 in"], "300 mm 0.1 12 in"),
        (["0.1", "-30 deg", "-pi / 9"], "0.1 -30 deg -pi / 9"),
        (["300 bananas", "0.1", "0.3"], "300 bananas 0.1 0.3"),
        (["elbow=abc", "slide=0.1"], "elbow=abc slide=0.1"),
    ],
)
def test_quotes_around_single_values_change_nothing(words: list[str], value: str) -> None:
    assert joined(["--xyz", *words, "rover_arm", "--rad"], ["--xyz"]) == ["--xyz", value, "rover_arm", "--rad"]


@pytest.mark.parametrize(
    ("line", "wrong"),
    [
        ("ik rover_arm --xyz 0.3 0.1 deg 0.2", "'0.1 deg'"),
        ("fk rover_arm --theta 0.1 rad -30 60 -20 0", "'0.1 rad'"),
        ("ik rover_arm --xyz 0.3 0.1 1/0", "'1/0'"),
    ],
)
def test_an_error_shows_the_wrong_value_as_it_was_typed(
    line: str, wrong: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(line.split()) == 2
    assert wrong in capsys.readouterr().err


SAME = {
    "fk rover_arm --theta 0 30 -45 0 0": [
        "fk rover_arm --theta 0 pi/6 -(40+5) 0 rad 0",
        "fk rover_arm --theta 0 0.5*60deg -45 0 0",
    ],
    "fk rover_arm --theta elbow=90": ["fk rover_arm --theta elbow=pi/2", "fk rover_arm --theta elbow=100-10 deg"],
    "ik rover_arm --xyz 0.5 0.1 0.3 --rpy 0 90 0": ["ik rover_arm --xyz 500 mm 10cm 0.3 --rpy 0 pi/2 0"],
    "ik rover_arm --xyz 0.5 0.1 0.3 --position-tol 0.001": ["ik rover_arm --xyz 0.5 0.1 0.3 --position-tol 1mm"],
    "info rover_arm --locked-joint elbow=30": ["info rover_arm --locked-joint elbow=pi/6"],
}  # fmt: skip


@pytest.mark.parametrize(("plain", "typed"), [(plain, typed) for plain, every in SAME.items() for typed in every])
def test_commands_answer_expressions_as_they_answer_numbers(
    plain: str, typed: str, capsys: pytest.CaptureFixture[str]
) -> None:
    answers = [(run([*line.split(), "--json"]), json.loads(capsys.readouterr().out)) for line in (plain, typed)]
    for answer in (found for _, found in answers):
        answer.pop("seconds", None), answer.pop("time", None)
    assert close(answers[0], answers[1])


def close(one: object, other: object) -> bool:
    """Whether two answers are the same but for rounding and what a search took."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(close(one[key], other[key]) for key in one)
    if isinstance(one, (list, tuple)) and isinstance(other, (list, tuple)):
        return len(one) == len(other) and all(map(close, one, other))
    return other == (pytest.approx(one, abs=1e-9) if isinstance(one, float) else one)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("ik rover_arm --xyz 0.5 0.1 30deg", "--xyz takes 3 numbers such as 0.3, 300 mm or 12 in"),
        ("ik rover_arm --xyz 1/0 0 0", "got '1/0 0 0'"),
        ("ik rover_arm --xyz 0.5 0 0 --rpy 0 0 2mm", "--rpy takes 3 numbers such as 30 deg or pi/6"),
        ("fk rover_arm --theta elbow=3mm", "elbow takes a number such as 30 deg or pi/6; got '3mm'"),
        ("ik rover_arm --xyz 0.5 0 0 --position-tol 1deg", "it takes a length such as 0.3, 300 mm or 12 in; got 1deg"),
        ("ik rover_arm --xyz 0.5 0 0 --orientation-tol 1mm", "--orientation-tol takes a number such as 30 deg"),
        ("reach rover_arm --voxel five", "it takes a length such as 0.3"),
    ],
)
def test_wrong_units_are_refused_with_what_is_allowed(
    line: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(line.split()) == 2
    assert words in " ".join(capsys.readouterr().err.split())
