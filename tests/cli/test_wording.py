"""The command line's words for the arguments and quantities in a message."""

from __future__ import annotations

import pytest

from twistarm.cli.wording import DEGREES, in_options
from twistarm.support.caller_words import argument, package_folder, posture, quantity


@pytest.fixture(autouse=True)
def degrees():
    """Angles are in degrees, although commands of other tests may have left them in radians."""
    token = DEGREES.set(True)
    yield
    DEGREES.reset(token)


@pytest.mark.parametrize(
    ("message", "typed"),
    [
        (f"pass {argument('tip', 'it is')}", "pass --tip 'it is'"),
        (f"pass {argument('tip')}", "pass --tip LINK"),
        ("tip= wins over it", "--tip wins over it"),
        (argument("ignore_packages", ["a'b", "c"]), """--ignore-package 'a'"'"'b' --ignore-package c"""),
        (argument("xacro_args", {"dof": "7", "mesh]": ...}), "--xacro dof:=7 --xacro 'mesh]:=VALUE'"),
        (argument("env_vars", [...]), "--env NAME"),
        (package_folder("it"), "--package-dir FOLDER (the folder that holds it)"),
        (argument("unwrap", True) + " makes that 1", "--unwrap makes that 1"),
        (argument("orientation_tol", 0.01), "--orientation-tol 0.57"),
        ('<limit lower="0"> and default="" stay, as my.tip=3 does', None),
        (f"at {quantity(-1.5707963, 'rad')}, not {quantity(2.0, 'rad/s²')} or 3 m", "at -90°, not 114.59°/s² or 3 m"),
        (f"begin in {posture([0.5, 0.25], ['rad', 'm'])}", 'begin in "28.65 0.25" (° and m)'),
        ("3 rad_joint and 2 radians stay", None),
    ],
)
def test_messages_are_said_in_options_and_degrees(message, typed):
    assert in_options(message) == (typed or message)


def test_radians_stay_where_they_were_typed():
    DEGREES.set(False)
    assert in_options("0.5 rad, orientation_tol=0.01") == "0.5 rad, --orientation-tol 0.01"
