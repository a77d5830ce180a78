"""Numbers typed with units: their grammar, and commands that answer by them."""

from __future__ import annotations

import inspect
import json
import math
import re

import pytest
from typer.models import OptionInfo

from twistarm.cli.application import app, run
from twistarm.cli.command import joined
from twistarm.cli.quantities import is_part, separate, typed_number

NUMBERS = {
    ("300 mm", "m"): 0.3,
    ("12in", "m"): 0.3048,
    ("30", "rad"): math.pi / 6,
    ("0.5 rad", "rad"): 0.5,
    ("−30°", "rad"): -math.pi / 6,
    ("2 mm", "rad"): math.nan,
    ("30+15", "rad"): math.nan,
    ("pi/4", "rad"): math.nan,
    ("1/0", "1"): math.nan,
    ("nan", "1"): math.nan,
}


@pytest.mark.parametrize(("text", "quantity"), NUMBERS)
def test_a_number_with_or_without_a_unit(text: str, quantity: str) -> None:
    assert typed_number(text, quantity) == pytest.approx(NUMBERS[text, quantity], rel=1e-12, nan_ok=True)
    assert typed_number("30", "rad", radians=True) == 30.0


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("0.8 -0.1 0.7", ["0.8", "-0.1", "0.7"]),
        ("300  mm 0.1 12 in", ["300  mm", "0.1", "12 in"]),
        ("[0.1, -0.2,\n 0.3]", ["0.1", "-0.2", "0.3"]),
        ("(0 0 1)", ["0", "0", "1"]),
        ("30 deg/s -1rad/s", ["30 deg/s", "-1rad/s"]),
        ("0.1 30 deg inside", ["0.1", "30 deg", "inside"]),
    ],
)
def test_a_list_is_taken_apart_between_its_values(text: str, values: list[str]) -> None:
    assert [value.strip() for value in separate(text)] == values


def test_only_numbers_and_units_go_on_with_an_option() -> None:
    assert all(map(is_part, ["300", "mm", "-pi/2", "30deg/s", "[0.1,", "−5", "nan", "1e-3"]))
    assert not any(map(is_part, ["-o", "-m", "--rad", "-", "rover_arm", "3_dof.urdf", "info", "--"]))


@pytest.mark.parametrize(
    ("words", "value"),
    [
        (["300 mm", "0.1", "12 in"], "300 mm 0.1 12 in"),
        (["0.1", "-30 deg", "-2rad"], "0.1 -30 deg -2rad"),
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
    "fk rover_arm --theta 0 30 -45 0 0": "fk rover_arm --theta 0 30deg -45 0 rad 0",
    "ik rover_arm --xyz 0.5 0.1 0.3 --rpy 0 90 0": "ik rover_arm --xyz 500 mm 10cm 0.3 --rpy 0 0.25 turn 0",
    "ik rover_arm --xyz 0.5 0.1 0.3 --position-tol 0.001": "ik rover_arm --xyz 0.5 0.1 0.3 --position-tol 1mm",
    "plan rover_arm --to elbow=9 --velocity 0.1": "plan rover_arm --to elbow=9 --velocity 0.1 rad/s",
    "plan rover_arm --to slide=0.1 --acceleration 0.5": "plan rover_arm --to slide=0.1 --acceleration 500 mm/s^2",
    "plan rover_arm --to slide=0.1 --dt 0.02": "plan rover_arm --to slide=0.1 --dt 20 ms",
    "payload rover_arm --theta ready --mass 0.5": "payload rover_arm --theta ready --mass 500 g",
    "info rover_arm --locked-joint elbow=36": "info rover_arm --locked-joint elbow=0.1turn",
}


@pytest.mark.parametrize(("plain", "typed"), SAME.items())
def test_commands_answer_units_as_they_answer_numbers(
    plain: str, typed: str, capsys: pytest.CaptureFixture[str]
) -> None:
    answers = [(run([*line.split(), "--json"]), json.loads(capsys.readouterr().out)) for line in (plain, typed)]
    for answer in (found for _, found in answers):
        answer.pop("seconds", None), answer.pop("time", None)
    assert close(answers[0], answers[1])


def close(one: object, other: object) -> bool:
    """Whether two answers are the same but for rounding and what a search took."""
    if isinstance(one, dict) and isinstance(other, dict):
        # A cap with a unit does not touch the limits of other joints.
        return one.keys() == other.keys() and all(close(one[key], other[key]) for key in one if "_limit" not in key)
    if isinstance(one, (list, tuple)) and isinstance(other, (list, tuple)):
        return len(one) == len(other) and all(map(close, one, other))
    return other == (pytest.approx(one, abs=1e-9) if isinstance(one, float) else one)


def numeric_options() -> list[tuple[str, str]]:
    """Every (command, option) that takes a number."""
    found = []
    for command in app.registered_commands:
        assert command.callback is not None
        for each in inspect.signature(command.callback, eval_str=True).parameters.values():
            (told,) = getattr(each.annotation, "__metadata__", (None,))
            if isinstance(told, OptionInfo) and (told.parser or re.search(r"\b(float|int)\b", str(each.annotation))):
                name = told.default if isinstance(told.default, str) else f"--{each.name.replace('_', '-')}"
                found.append((command.callback.__name__, name))
    return found


@pytest.mark.parametrize(("command", "option"), numeric_options())
def test_nonsense_for_a_number_is_answered_by_what_is_allowed(
    command: str, option: str, capsys: pytest.CaptureFixture[str]
) -> None:
    for nonsense in ("banana", "-5", "nan", "1/0", ""):
        assert run([command, option, nonsense]) == 2
        said = " ".join(capsys.readouterr().err.split())
        assert re.search(
            rf"'{option}': it takes a (whole )?number .*(such as \S.*|to \d+); got {nonsense} ?\(see", said
        )


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("ik rover_arm --xyz 0.5 0.1 30deg", "--xyz takes 3 numbers such as 0.3, 300 mm or 12 in"),
        ("ik rover_arm --xyz 1/0 0 0", "got '1/0 0 0'"),
        ("ik rover_arm --xyz 0.5 0 0 --rpy 0 0 2mm", "--rpy takes 3 numbers"),
        ("fk rover_arm --theta elbow=3mm", "elbow takes a number"),
        ("fk rover_arm --theta elbow=pi/2", "'pi/2'"),
        (
            "ik rover_arm --xyz 0.5 0 0 --position-tol 1deg",
            "it takes a number above 0 such as 0.3, 300 mm or 12 in; got 1deg",
        ),
        ("ik rover_arm --xyz 0.5 0 0 --orientation-tol 1mm", "--orientation-tol takes a number such as 30 deg"),
        ("plan rover_arm --to zero --velocity 30 deg/s²", "such as 0.5, 30 deg/s or 50 mm/s; got 30 deg/s²"),
        ("plan rover_arm --to zero --velocity 30 deg", "such as 0.5, 30 deg/s or 50 mm/s; got 30 deg"),
        ("plan rover_arm --to zero --velocity 1 rad/s/s", "such as 0.5, 30 deg/s or 50 mm/s; got 1 rad/s/s"),
        ("plan rover_arm --to zero --acceleration 3 rad/s", "such as 2, 90 deg/s² or 500 mm/s²; got 3 rad/s"),
        ("plan ur5 --to zero --velocity 50mm/s", "ur5 has no joint in m, as --velocity is"),
        ("servo rover_arm --margin 5deg", "--margin is one number for turns and slides"),
        ("plan rover_arm --to zero --dt 0", "it takes a number above 0 such as 0.5 or 500 ms; got 0"),
        ("payload rover_arm --mass -1", "it takes a number of 0 or more such as 0.5 or 500 g; got -1"),
        ("view rover_arm --frame-rate 0", "it takes a whole number from 1 to 120; got 0"),
        ("calibrate rover_arm log.csv --distance a=b=2deg", "--distance takes A=B=LENGTH"),
    ],
)
def test_wrong_units_are_refused_with_what_is_allowed(
    line: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(line.split()) == 2
    assert words in " ".join(capsys.readouterr().err.split())
