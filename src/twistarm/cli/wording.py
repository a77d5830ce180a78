"""The library's remedies in the words of the command line."""

from __future__ import annotations

import re
import shlex
from ast import literal_eval
from collections.abc import Callable

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
    (r" \((\d+) frames: arm\.frame_names\)", r" (\1 frames: twistarm info ARM --json)"),
    (r"stop_at_waypoints=True", "--stop"),
    (r"change the limit by limits=", "change it in the arm's arm.toml"),
)


def _xacro_options(entries: str) -> str:
    """`'dof': '7', 'name': …` as `--xacro dof:=7 --xacro name:=VALUE`."""
    pairs = re.findall(r"'([^']*)': (?:'([^']*)'|…)", entries)
    return " ".join(shlex.join(["--xacro", f"{name}:={value or 'VALUE'}"]) for name, value in pairs)


def as_typed(message: str) -> str:
    """`message` with arguments of the Python call replaced by the options that stand for them."""
    for python, option in _AS_TYPED:
        message = re.sub(python, option, message)
    return message
