"""The library's remedies in the words of the command line."""

from __future__ import annotations

import re

_AS_TYPED = (
    (r"pass tip= \(a link: ", "pass --tip LINK (a link: "),
    (r"pass tip=", "pass --tip LINK"),
    (r"for (base|tip|locked)=", r"for --\1"),
    (r"package_dirs=\[folder that holds ([^\]]*)\]", r"--package-dir FOLDER (the one that holds \1)"),
    (r"choose a base= beyond it", "choose a --base LINK beyond it"),
    (r"choose another base= or tip=", "choose another --base LINK or --tip LINK"),
    (r"\bas srdf=", "as --srdf FILE"),
    (r"xacro_args=\{('\w+')?[^}]*\}", "--xacro NAME:=VALUE for each"),
    (
        r"give it as limits=\{'(velocity|acceleration)': \{[^}]*\}\}, one number for every joint as "
        r"limits=\{'\w+': …\}, or",
        r"give one for every joint as --\1 NUMBER, or each joint's",
    ),
    (r" \((\d+) frames: arm\.frame_names\)", r" (\1 frames: twistarm info ARM --json)"),
    (r"stop_at_waypoints=True", "--stop"),
    (r"change the limit by limits=", "change it in the arm's arm.toml"),
)


def as_typed(message: str) -> str:
    """`message` with arguments of the Python call replaced by the options that stand for them."""
    for python, option in _AS_TYPED:
        message = re.sub(python, option, message)
    return message
