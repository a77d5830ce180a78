"""Messages as data and as one line, and what objects show of themselves at a prompt."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
import typer

from catalogue import load
from twistarm import (
    Arm,
    JointLimits,
    Pose,
    Position,
    ServoState,
    Trajectory,
    arm_from_screws,
    plan_joint,
    screws,
    servo_step,
    solve_ik,
    solve_ik_batch,
)
from twistarm.cli.application import app
from twistarm.cli.wording import OPTIONS as OPTION_TABLE
from twistarm.cli.wording import words
from twistarm.support.errors import LONGEST, DescriptionError, MissingExtraError, TwistarmError, listed, one_line
from twistarm.support.messages import Argument, Posture, Quantity, Remedies, Text, joined, package_folder
from twistarm.viewer.messages import page_words

OPTIONS = [
    (Argument("tip", "it is"), "tip='it is'", "--tip 'it is'"),
    (Argument("tip"), "tip=...", "--tip LINK"),
    (Argument("ignore_packages", ["a'b", "c"]), None, """--ignore-package 'a'"'"'b' --ignore-package c"""),
    (Argument("xacro_args", {"x]": ...}), "xacro_args={'x]': ...}", "--xacro 'x]:=VALUE'"),
    (Argument("env_vars", [...]), "env_vars=[...]", "--env NAME"),
    (Argument("unwrap", True), "unwrap=True", "--unwrap"),
    (Argument("orientation_tol", Quantity(0.01, "rad", 2)), "orientation_tol=0.01", "--orientation-tol 0.57"),
    (Quantity(-1.5707963, "rad"), "-1.5708 rad", "-90°"),
    (Quantity(2.0, "rad/s²"), "2 rad/s²", "114.59°/s²"),
    (Quantity(float("inf"), "rad"), "inf rad", "inf°"),
    (Posture((0.5, 0.25), ("rad", "m")), "[0.5 rad, 0.25 m]", '"28.65 0.25" (° and m)'),
    (package_folder("it"), None, "--package-dir FOLDER (the folder that holds it)"),
]  # fmt: skip


@pytest.mark.parametrize(("value", "python", "option"), OPTIONS)
def test_each_reader_has_his_own_words(value: object, python: str | None, option: str) -> None:
    text = Text("at {value}", value=value)
    assert python is None or text == f"at {python}"
    assert words(text) == f"at {option}"


def test_a_page_offers_only_what_its_reader_can_set() -> None:
    larger, far = Text("a larger {tol}", tol=Argument("tol")), Quantity(1.78, "rad", 3)
    wider = Text("a wider {tol}", tol=Argument("position_tol", Quantity(0.002, "m")))
    text = Text("{far} off: give {remedies}", far=far, remedies=Remedies(("another goal", larger, wider)))
    assert text == "1.78 rad off: give another goal, a larger tol=..., or a wider position_tol=0.002"
    assert words(text) == "102° off: give another goal, a larger --keep-tol ANGLE, or a wider --position-tol 0.002"
    assert page_words(text) == "102° off: give another goal or a wider Tolerance in the Move panel: 0.002 m"
    assert "tip=... (or its option)" in page_words(Text("pass {tip}", tip=Argument("tip")))
    assert page_words(Posture((0.5, 0.25), ("rad", "m"))) == "[28.65°, 0.25 m]"


def test_radians_stay_for_who_types_radians() -> None:
    text = joined(
        "; ", [Quantity(0.5, "rad"), Argument("orientation_tol", Quantity(0.01, "rad")), Posture((1.0,), ("rad",))]
    )
    assert words(text, radians=True) == '0.5 rad; --orientation-tol 0.01; "1" (rad and m)'


@pytest.mark.parametrize("name", ["tip='x'", "0.5 rad", "{limit}", "arm.my.tip=3", "{"])
def test_names_that_look_like_values_stay(name: str) -> None:
    text = Text("{joint!r} to {limit}: {why}", joint=name, limit=Quantity(1.0, "m"), why=joined(name, ["a", "b"]))
    assert text == words(text) == f"{name!r} to 1 m: a{name}b"


def test_values_survive_errors_nesting_and_pickles() -> None:
    inner = Text("joint {joint!r} at {value}", joint="elbow", value=Quantity(0.5, "rad"))
    for kind in (TwistarmError, DescriptionError):
        error = pickle.loads(pickle.dumps(kind(joined(": ", ["arm.urdf", inner]))))
        assert str(error) == "arm.urdf: joint 'elbow' at 0.5 rad"
        assert words(error.message) == "arm.urdf: joint 'elbow' at 28.648°"
    assert pickle.loads(pickle.dumps(DescriptionError("a", ("finding",)))).findings == ("finding",)


def test_every_option_that_messages_name_exists() -> None:
    commands = typer.main.get_command(app).commands.values()  # type: ignore[attr-defined]
    flags = {flag for command in commands for param in command.params for flag in param.opts}
    assert {option for option, _ in OPTION_TABLE.values()} <= flags


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


LONGEST_REPR = 240  # three lines of a terminal of 80 columns


def printed() -> list[object]:
    """One of whatever a person prints."""
    arm = load("panda")
    theta, motion = arm.ready, plan(arm)
    targets = [Pose(arm.fk(theta)), Position([9, 0, 0])]
    answers = [solve_ik(arm, targets[1]), solve_ik_batch(arm, targets), arm.manipulability(theta), motion.sample(0.1)]
    state = ServoState.at(arm, theta)
    output = servo_step(arm, state, [0.1, 0, 0, 0, 0, 0], 0.01)[1]
    return [arm, arm.limits, arm.coupling, arm.description, motion, state, output, *targets, *answers]


def plan(arm: Arm) -> Trajectory:
    return plan_joint(arm, [arm.ready, arm.ready], limits={"velocity": 1.0, "acceleration": 1.0})


def test_every_object_fits_three_lines_of_a_terminal() -> None:
    for thing in printed():
        text = repr(thing)
        assert text.startswith(type(thing).__name__), text
        assert "\n" not in text, text
        assert len(text) <= LONGEST_REPR, f"{len(text)}: {text}"


def test_numbers_have_four_digits() -> None:
    assert repr(Position([1.23456789, 1e-17, -2])) == "Position(p=[1.235, 0, -2])"
    assert "pitch=0," in repr(screws.to_screw([0.4, 0, 4.6e-23, 0, 0, 1])), "a number alone, as those in a row"
    g = screws.exp([0.5, 0, 0, 0, 0, 0]) @ screws.exp([0, 0, 0, 0, 0, np.pi / 3])
    assert "lower=[-inf, -0.5]" in repr(JointLimits.unbounded(2).with_({"lower": {"b": -0.5}}, ("a", "b")))
    assert repr(Pose(g)) == "Pose(g=at [0.5, 0, 0] turned 60°)"


def test_long_arms_are_told_in_brief() -> None:
    arm = arm_from_screws(np.tile([[0.0], [0], [0], [0], [0], [1]], (1, 32)), np.eye(4), name="long")
    for thing in (arm, arm.limits, plan(arm)):
        assert len(repr(thing)) <= LONGEST_REPR
