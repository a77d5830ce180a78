"""Output files of a command: `-o FILE` by its ending, `-` for standard output; no silent replacement."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, TextIO

import typer

from ..support.errors import InputError
from ..support.files import writable, write_whole
from .output import say

STDOUT = "-"

NAMED = typer.Option("--output", "-o", metavar="FILE", help="Where to write it; - is standard output.")
Output = Annotated[str | None, NAMED]
Format = Annotated[
    str | None, typer.Option("--format", metavar="KIND", help="The kind of what -o - writes, or a name without ending.")
]
Force = Annotated[bool, typer.Option("--force", help="Replace files that are there.")]

Kinds = Mapping[str, tuple[str, ...]]
"""What a command can write: each kind's name and the endings of such files."""


@dataclass(frozen=True)
class Outputs:
    """The requested files as kind and name, checked before the command begins."""

    files: tuple[tuple[str, str], ...] = ()
    over_description: bool = False

    @property
    def words(self) -> TextIO:
        """Where the command speaks: beside standard output, if that is one of its files."""
        return sys.stderr if any(name == STDOUT for _, name in self.files) else sys.stdout

    def write(self, contents: Mapping[str, Callable[[], str | bytes]]) -> list[str]:
        """Write every file, whole or not at all, with the text of its kind's function. Returns the names."""
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
    """Write unchanged into a pipe or a file, and readably on a terminal."""
    if isinstance(content, str) and sys.stdout.isatty():
        say(*content.splitlines())
    else:
        sys.stdout.buffer.write(content.encode() if isinstance(content, str) else content)


def outputs_of(
    typed: str | Sequence[str] | None,
    kinds: Kinds,
    form: str | None = None,
    *,
    force: bool,
    json: bool = False,
    over_description: bool = False,
) -> Outputs:
    """The outputs of a command.

    Raises InputError for a file that cannot be written or would be replaced.

    The kind is that of the ending, else `form`, else the only one of `kinds` (the first for standard output).
    """
    names = [typed] if isinstance(typed, str) else list(typed or ())
    if form is not None and form not in kinds:
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
        raise InputError(f"-o takes {endings}; got {name}: another name, or --format {'|'.join(kinds)}, says the kind")
    return kind
