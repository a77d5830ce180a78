"""The library's remedies in the words of the command line."""

from __future__ import annotations

import math
import re
import shlex
from ast import literal_eval
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ..support.errors import LimitError, TwistarmError

_AS_TYPED: tuple[tuple[str, str | Callable[[re.Match[str]], str]], ...] = (
    (r"""pass tip=('[^']*'|"[^"]*")""", lambda found: f"pass --tip {shlex.quote(literal_eval(found[1]))}"),
    (r"pass tip=", "pass --tip LINK"),
    (r"for (base|tip|locked)=", r"for --\1"),
    (r"package_dirs=\[folder that holds ([^\]]*)\]", r"--package-dir FOLDER (the one that holds \1)"),
    (r"choose a base= beyond it", "choose a --base LINK beyond it"),
    (r"choose another base= or tip=", "choose another --base LINK or --tip LINK"),
    (r"\bas srdf=", "as --srdf FILE"),
    (r"xacro_args=\{([^}]*)\}", lambda found: _xacro_options(found.group(1))),
    (r"\bwithout=\['([^']*)'\]", r"--without \1"),
    (r"\bwithout=", "--without"),
    (r"\benv=\['([^']*)'\]", r"--env \1"),
    (r"\benv=\[NAME\]", "--env NAME"),
    (r" \((\d+) frames: arm\.frame_names\)", r" (\1 frames: twistarm info ARM --json)"),
    (r"stop_at_waypoints=True", "--stop"),
    (r"change the limit by limits=", "change it in the arm's arm.toml"),
)


_PYTHON_NAMES = {
    "base": "--base",
    "tip": "--tip",
    "srdf": "--srdf",
    "limits": "--limits",
    "locked": "--locked",
    "without": "--without",
    "env": "--env",
    "xacro_args": "--xacro",
    "package_dirs": "--package-dir",
}
"""Arguments of `load_arm` where a message names them alone."""


def in_degrees(message: str) -> str:
    """`message` with what is said in rad, rad/s or rad/s² said in degrees: what was typed in degrees is answered so."""
    return re.sub(
        r"(-?\d[\d.]*(?:e[+-]?\d+)?) rad(?![\w])", lambda found: f"{math.degrees(float(found[1])):.6g}°", message
    )


@contextmanager
def told_in_degrees(wanted: bool) -> Iterator[None]:
    """A LimitError from within says angles in degrees, if `wanted`."""
    try:
        yield
    except LimitError as error:
        raise LimitError(in_degrees(str(error)) if wanted else str(error)) from error


def _xacro_options(entries: str) -> str:
    """`'dof': '7', 'name': …` as `--xacro dof:=7 --xacro name:=VALUE`."""
    pairs = re.findall(r"'([^']*)': (?:'([^']*)'|…)", entries)
    return " ".join(shlex.join(["--xacro", f"{name}:={value or 'VALUE'}"]) for name, value in pairs)


def as_typed(message: str) -> str:
    """`message` with arguments of the Python call replaced by the options that stand for them."""
    for python, option in _AS_TYPED:
        message = re.sub(python, option, message)
    names = "|".join(_PYTHON_NAMES)
    return re.sub(rf"(?<![\w\['\"-])({names})=(?=[\s,;)])", lambda found: _PYTHON_NAMES[found[1]], message)


def told(error: Exception) -> str:
    """What an error is told as: ours in the program's words, the system's as it is, any other as our fault."""
    if isinstance(error, TwistarmError):
        return as_typed(str(error))
    if isinstance(error, OSError):
        return f"the operating system refuses: {error}"
    return f"{type(error).__name__}: {error}; a fault of twistarm's: please report it with the output of --debug"
