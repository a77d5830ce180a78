"""Output files of a command: `-o FILE`. The ending gives the kind, and `-` is standard output."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TextIO

import typer

from ..support.errors import InputError
from ..support.files import writable, write_whole
from .output import say

STDOUT = "-"

NAMED = typer.Option("--output", "-o", metavar="FILE", help="Where to write it; - is standard output.")
Output = Annotated[str | None, NAMED]


def repeated(what: str) -> Any:
    """The option -o of a command that writes several files."""
    return typer.Option("--output", "-o", metavar="FILE", help=f"{what}; repeat it.")


Format = Annotated[
    str | None, typer.Option("--format", metavar="KIND", help="The kind of what -o - writes, or a name without ending.")
]
Force = Annotated[bool, typer.Option("--force", help="Replace files that are there.")]

Kinds = Mapping[str, tuple[str, ...]]
"""The kinds of files that a command can write, with their endings."""


@dataclass(frozen=True)
class Outputs:
    """The files that a command writes, as kind and name, checked before it begins."""

    files: tuple[tuple[str, str], ...] = ()
    over_description: bool = False

    @property
    def words(self) -> TextIO:
        """The stream for messages: stderr if standard output is one of the files."""
        return sys.stderr if any(name == STDOUT for _, name in self.files) else sys.stdout

    def write(self, contents: Mapping[str, Callable[[], str | bytes]]) -> list[str]:
        """Write every file with the result of the function of its kind. Return the names."""
        made = [(name, contents[kind]()) for kind, name in self.files]
        for name, content in made:
            if name == STDOUT:
                _to_stdout(content)
            else:
                write_whole(name, content, over_description=self.over_description)
        return [name for name, _ in made]

    def say(self, written: Sequence[str]) -> None:
        """Tell a person which files were written."""
        for name in written:
            if name != STDOUT:
                say(f"written: {name}", file=self.words)


def _to_stdout(content: str | bytes) -> None:
    """Write unchanged into a pipe or a file; show printable text on a terminal."""
    if isinstance(content, str) and sys.stdout.isatty():
        say(*content.splitlines())
    else:
        sys.stdout.buffer.write(content.encode() if isinstance(content, str) else content)


def outputs_of(
    typed: str | Sequence[str] | None,
    kinds: Kinds,
    form: str | None = "",
    *,
    force: bool,
    json: bool = False,
    over_description: bool = False,
) -> Outputs:
    """The outputs of a command as typed. InputError for one that cannot be written or would replace a file.

    The ending gives the kind, else `form`, else the only one of `kinds`. Standard output takes the first of `kinds`.
    `form` is "" in a command without `--format`.
    """
    names = [typed] if isinstance(typed, str) else list(typed or ())
    if form and form not in kinds:
        raise InputError(f"--format is one of {', '.join(kinds)}; got {form!r}")
    if names.count(STDOUT) + json > 1:
        raise InputError("-o - gives standard output to one file: leave out --json or the other -o -")
    for name in names:
        target = None if name == STDOUT else writable(name, over_description=over_description)
        if target is not None and target.exists() and not force:
            raise InputError(f"{name} exists; --force replaces it, another name keeps it")
    return Outputs(tuple((_kind(name, kinds, form), name) for name in names), over_description)


def _kind(name: str, kinds: Kinds, form: str | None) -> str:
    said = next((kind for kind, endings in kinds.items() if name.lower().endswith(endings)), None)
    if said and form and said != form:
        raise InputError(f"{name} is named like a file of kind {said}, and --format says {form}")
    kind = said or form or (next(iter(kinds)) if name == STDOUT or len(kinds) == 1 else None)
    if kind is None:
        endings = " or ".join(f"*{endings[0]}" for endings in kinds.values())
        option = f", or --format {'|'.join(kinds)}," if form is None else ""
        raise InputError(f"-o takes {endings}; got {name}: another name{option} says the kind")
    return kind
