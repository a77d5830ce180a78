"""Numbers typed with units: their grammar, and commands that answer by them."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from typer.main import get_command

from twistarm import arm_from_dh
from twistarm.cli.application import app, run
from twistarm.cli.numbers import METAVARS, JointValues

SAME = {
    "fk rover_arm --theta 0 30 -45 0 0": "fk rover_arm --theta 0 30deg -45° 0 rad 0",
    "ik rover_arm --xyz 0.5 0.1 0.3 --rpy 0 90 0": "ik rover_arm --xyz 500 mm 10cm 0.3m --rpy 0 1.25 turn 0",
    "ik rover_arm --xyz 0.5 0.1 0.3 --position-tol 0.001": "ik rover_arm --xyz 0.5 0.1 0.3 --position-tol 1mm",
    "plan rover_arm --to elbow=9 --velocity 0.1": "plan rover_arm --to elbow=9 --velocity 0.1 rad/s",
    "plan rover_arm --to slide=0.1 --dt 0.02": "plan rover_arm --to slide=0.1 --dt 20 ms",
    "ik rover_arm --xyz 0.5 0 0.3 --tool 0 0 0.1": "ik rover_arm --xyz 500mm,0,30 cm --tool 0 0 100 mm",
    "fk rover_arm --theta 0 30 60 0 0": "fk rover_arm --theta 0 30 60 deg 0 0",
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
    commands: dict[str, Any] = get_command(app).commands  # type: ignore[attr-defined]
    numeric = {"N", *METAVARS.values()}
    return [(name, parameter.opts[-1]) for name, command in commands.items() for parameter in command.params
            if parameter.metavar in numeric]  # fmt: skip


@pytest.mark.parametrize(("command", "option"), numeric_options())
def test_nonsense_for_a_number_names_the_option_and_the_value(
    command: str, option: str, capsys: pytest.CaptureFixture[str]
) -> None:
    needed = dict.fromkeys(("demo", "guide"), 0) | dict.fromkeys(
        ("designs", "panel", "wiring", "calibrate", "follow"), 2
    )
    for nonsense in ("banana", "-5", "nan", "1/0", ""):
        assert run([command, *["x"] * needed.get(command, 1), option, nonsense]) == 2
        error = capsys.readouterr().err
        assert option in error
        assert nonsense in error


WRONG = [
    ("ik rover_arm --xyz 0.3 0.1 deg 0.2", "'0.1 deg'"),
    ("fk rover_arm --theta elbow=pi/2", "'pi/2'"),
    ("ik rover_arm --xyz 800 100 700 mm", "800mm 100mm 700 mm"),
    ("ik rover_arm --xyz 0.8 0.1 70 cm", "0.8cm 0.1cm 70 cm"),
    ("fk rover_arm --theta 0 30 0.5 rad 0 0", "30 has none"),
    ("fk rover_arm --theta shoulder=30 elbow=0.5 rad", "30 has none"),
    ("fk rover_arm --theta 0,1 30 60 0 0", "0.1"),
    ("fk rover_arm --theta elbow=0,1", "0.1"),
    ("ik rover_arm --xyz 0,3 1", "0.3"),
    ("ik rover_arm --xyz 0.5 0 0 --rpy 0 0 2mm", "--rpy"),
    ("ik rover_arm --xyz 0.5 0 0 --position-tol 1deg", "1deg"),
    ("plan rover_arm --to zero --velocity 30 deg/s²", "30 deg/s²"),
    ("plan ur5 --to zero --velocity 50mm/s", "--velocity"),
    ("calibrate rover_arm log.csv --distance a=b=2deg", "a=b=2deg"),
]


@pytest.mark.parametrize(("line", "culprit"), WRONG)
def test_wrong_units_are_refused_by_option_or_value(
    line: str, culprit: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(line.split()) == 2
    assert culprit in capsys.readouterr().err


def test_a_comma_before_a_joint_called_by_a_number_is_no_decimal_comma() -> None:
    arm = arm_from_dh([[0.4, 0.0, 0.0, 0.0]] * 2, "standard", joints=["1", "2"])
    assert np.degrees(JointValues("1=10,2=20", "--theta", radians=False).of(arm)) == pytest.approx([10.0, 20.0])
