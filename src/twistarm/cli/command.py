"""Commands of the program: their help, and options of several numbers without quotes."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from typer.core import TyperCommand, TyperGroup

from .quantities import METAVARS, is_part

VALUES = "VALUES"
POSE = "POSE"
XYZ, PLACE = "'X Y Z'", "'X Y YAW'"
RPY = "'R P Y'"
WXYZ, XYZW = "'W X Y Z'", "'X Y Z W'"
AXIS = "AXIS"
NUMBERS = (VALUES, POSE, XYZ, PLACE, RPY, WXYZ, XYZW, AXIS, *METAVARS.values())
"""The values in the help of options that take several words: numbers, and units after them."""


class _Sections:
    """A help with a section for each panel of options and of commands, in the order of their first members."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        sections: dict[str, list[tuple[str, str]]] = {}
        for param in self.get_params(ctx):  # type: ignore[attr-defined]
            if record := param.get_help_record(ctx):
                usual = "Arguments" if param.param_type_name == "argument" else "Options"
                record = record[0].partition(" <")[0], record[1]  # without the Python type of an argument
                sections.setdefault(getattr(param, "rich_help_panel", None) or usual, []).append(record)
        for name, command in getattr(self, "commands", {}).items():
            # The whole first sentence: the formatter wraps it.
            record = name, command.get_short_help_str(limit=1000)
            sections.setdefault(getattr(command, "rich_help_panel", None) or "Commands", []).append(record)
        for title, records in sections.items():
            with formatter.section(title):
                formatter.write_dl(records)


class Group(_Sections, TyperGroup):
    """The program, or a command with commands of its own."""


class Command(_Sections, TyperCommand):
    """A command with options of several numbers without quotes: `--theta 0.1 -30 60`, `--xyz 0.8 -0.1 0.7`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Join such numbers to one word for Click."""
        several = [name for option in self.params if option.metavar in NUMBERS for name in option.opts]
        return super().parse_args(ctx, joined(args, several))


def joined(words: Sequence[str], options: Collection[str]) -> list[str]:
    """`words`, with expressions or joint=value pairs after one of `options` joined to one word."""
    made: list[str] = []
    goes_on = False
    for i, word in enumerate(words):
        if word == "--":
            return [*made, *words[i:]]
        if goes_on and _is_part(word):
            made[-1] += f" {word}"
            continue
        option, _, value = word.partition("=")
        if made and made[-1] in options:
            goes_on = not word.startswith("-") or _is_part(word)
        else:
            goes_on = option in options and _is_part(value)
        made.append(word)
    return made


def _is_part(word: str) -> bool:
    """Whether a typed word, such as -pi/2 or '12 in', is a part of expressions or joint=value, also if it is wrong."""
    name, equals, value = word.rpartition("=")
    if equals and not name.startswith("-"):
        return value.isalpha() or is_part(value)
    first, *rest = word.split() or [""]
    return is_part("".join([first, *rest])) or (is_part(first) and "".join(rest).isalpha())
