"""Commands of the program: their help, options that several share, and options of several numbers without quotes."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Sequence
from itertools import takewhile
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command
from typer.models import OptionInfo

from ..support.errors import InputError
from .numbers import NUMBERS, Typed, is_part

MAIN_OPTIONS = ("--theta", "--to", "--xyz")  # The first that a command has is likely meant by numbers without one.


class Shared(OptionInfo):
    """Options that commands share, in the annotation of one argument: `made` makes it of what was typed.

    They have a section `panel` of the help, if it is named.
    """

    def __init__(self, made: Callable[..., Any], params: Sequence[Any] | None = None, panel: str = "") -> None:
        super().__init__(default=..., parser=str, hidden=True)
        self.made, self.params = made, list(params_of(made) if params is None else params)
        for param in self.params if panel else ():
            param.rich_help_panel = panel


def params_of(function: Callable[..., Any]) -> list[Any]:
    """The options of a function's parameters, as Typer makes them."""
    program = typer.Typer(add_completion=False, rich_markup_mode=None)
    program.command()(function)
    return get_command(program).params


class _Options:
    """A help with a section for each panel. Commands share options, and read numbers in the typed unit."""

    params: list[Any]

    def __init__(self, *args: Any, **keywords: Any) -> None:
        super().__init__(*args, **keywords)
        # Annotations are texts, because of `from __future__ import annotations`.
        arguments = inspect.signature(keywords["callback"], eval_str=True).parameters.values()
        self.shared = {
            argument.name: of
            for argument in arguments
            for of in getattr(argument.annotation, "__metadata__", ())
            if isinstance(of, Shared)
        }
        own = [param for param in self.params if param.name not in self.shared]
        every = [*own, *(param for of in self.shared.values() for param in of.params)]
        # Sections of the help have the order of their first members: arguments, named panels, then the rest.
        self.params = sorted(every, key=lambda param: (param.param_type_name != "argument", not param.rich_help_panel))

    def invoke(self, ctx: Any) -> Any:
        """Read the typed numbers, and make the arguments that options share."""
        radians = bool(ctx.params.get("rad"))
        for param in self.params:
            if param.name in ctx.params:
                ctx.params[param.name] = _read(ctx.params[param.name], param.opts[0], radians)
        for name, of in self.shared.items():
            ctx.params[name] = of.made(**{param.name: ctx.params.pop(param.name) for param in of.params})
        return super().invoke(ctx)  # type: ignore[misc]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the sections in the order of their first members."""
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


def _read(value: Any, option: str, radians: bool) -> Any:
    if isinstance(value, (list, tuple)):
        return [_read(entry, option, radians) for entry in value]
    return value.read(value.text, option, radians) if isinstance(value, Typed) else value


class Group(_Options, TyperGroup):
    """The program, or a command with further commands."""


class Command(_Options, TyperCommand):
    """A command with options of several numbers without quotes: `--theta 0.1 -30 60`, `--xyz 0.8 -0.1 0.7`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Join such numbers to one word for Click, and say which option words belong to that Click would misread."""
        several = [name for option in self.params if option.metavar in NUMBERS for name in option.opts]
        words = joined(args, several)
        if not ctx.resilient_parsing:
            ctx.allow_extra_args = True
            _refuse_misread(ctx, words, several)
        extra: list[str] = super().parse_args(ctx, [*words])
        if extra and not ctx.resilient_parsing:
            _refuse_extra(ctx, words, len(words) - 1 - words[::-1].index(extra[0]), several)
        return extra


def _refuse_misread(ctx: Any, words: Sequence[str], several: Sequence[str]) -> None:
    """Refuse what Click misreads: an option of one value typed twice, -theta, and -30 behind no option."""
    options = {name: param for param in ctx.command.get_params(ctx) for name in param.opts if name.startswith("-")}
    typed: dict[str, str] = {}
    rest = iter(enumerate(words))
    for i, word in rest:
        name, equals, _ = word.partition("=")
        if word == "--":
            return
        if name in options and not options[name].is_flag:
            if not equals:
                next(rest, None)  # its value, which may look like an option
            of = options[name]
            if of.name in typed and not of.multiple:
                alias = f", once as {typed[of.name]}" if typed[of.name] != name else ""
                raise InputError(f"{name} takes one value, and it is typed twice{alias}: leave one of them out")
            typed[of.name] = name
        elif f"-{name}" in options:
            ctx.fail(f"no option {word}: did you mean -{word}?")
        elif word.startswith("-") and is_part(word):
            _refuse_extra(ctx, words, i, several)


def _refuse_extra(ctx: Any, words: Sequence[str], i: int, several: Sequence[str]) -> None:
    """Refuse word i, which is no argument, with the numbers around it, and name the option that takes them."""
    numbers = [*takewhile(is_part, words[i::-1])][:0:-1] + [*takewhile(is_part, words[i:])]
    takes = [param.metavar for param in ctx.command.params if param.param_type_name == "argument"]
    refused, write = repr(" ".join(numbers) or words[i]) + " is no", ""
    before = [word.partition("=")[0] for word in words[max(i - 2, 0) : i]]
    if option := next((word for word in before if word in several), ""):
        refused = f"{words[i]!r} is neither a number for {option} nor an"
    elif numbers and (option := next((name for name in MAIN_OPTIONS if name in several), "")):
        write = f"; write {option} {' '.join(numbers)}"
    ctx.fail(f"{refused} argument: {ctx.info_name} takes {' '.join(takes) or 'none'}{write}")


def joined(words: Sequence[str], options: Collection[str]) -> list[str]:
    """`words`, with numbers or joint=value pairs after one of `options` joined to one word."""
    made: list[str] = []
    goes_on = False
    for i, word in enumerate(words):
        if word == "--":
            return [*made, *words[i:]]
        # A word between numbers is a wrong one of them: who reads the option says so.
        if goes_on and (_is_part(word) or (not word.startswith("-") and _is_part(" ".join(words[i + 1 : i + 2])))):
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
    """Whether a typed word is a part of numbers or joint=value, such as -pi/2 or '12 in'. It may be wrong."""
    name, equals, value = word.rpartition("=")
    if equals and not name.startswith("-"):
        return value.isalpha() or is_part(value)
    first, *rest = word.split() or [""]
    return is_part("".join([first, *rest])) or (is_part(first) and "".join(rest).isalpha())
