"""What a command answers: on standard output, as text or JSON, and in the files of `-o FILE`.

The ending of a file gives its kind, and `-` is standard output.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TextIO

import typer
from rich.console import RenderableType

from ..support.errors import InputError
from ..support.files import writable, write_whole
from .output import console, print_json, say
from .tables import Table
from .wording import words

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

Contents = Mapping[str, Callable[[], str | bytes]]
"""What makes the content of a file, by its kind."""


@dataclass(frozen=True)
class Outputs:
    """How a command answers, and the files that it writes, as kind and name, checked before it begins."""

    files: tuple[tuple[str, str], ...] = ()
    over_description: bool = False
    json: bool = False
    radians: bool = False

    @property
    def words(self) -> TextIO:
        """The stream for people: stderr if standard output is JSON or one of the files."""
        taken = self.json or any(name == STDOUT for _, name in self.files)
        return sys.stderr if taken else sys.stdout

    def show(
        self,
        data: Mapping[str, Any],
        *parts: Table | str | RenderableType,
        files: Contents | None = None,
        written: Sequence[str] | None = None,
    ) -> None:
        """Write the files, then print the answer: `data` and the tables as JSON, or the parts for people.

        `written` names files that the command has written itself. JSON lists the names as "written".
        """
        names = written if files is None else self.write(files)
        if self.json:
            document = dict(data)
            for each in parts:
                document |= each.entries() if isinstance(each, Table) else {}
            print_json(document if names is None else document | {"written": names})
            return
        for part in parts:
            if isinstance(part, Table):
                part.print_on(console(self.words), self.radians)
            elif isinstance(part, str):
                say(words(part, radians=self.radians), file=self.words)
            else:
                console(self.words).print(part)
        self.say(names or ())

    def lines(self, text: str) -> list[str]:
        """The lines of a text that has several, as parts of `show`."""
        return words(text, radians=self.radians).splitlines()

    def write(self, contents: Contents) -> list[str]:
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
    radians: bool = False,
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
    files = tuple((_kind(name, kinds, form), name) for name in names)
    return Outputs(files, over_description, json, radians)


def _kind(name: str, kinds: Kinds, form: str | None) -> str:
    named = next((kind for kind, endings in kinds.items() if name.lower().endswith(endings)), None)
    if named and form and named != form:
        raise InputError(f"{name} is named like a file of kind {named}, and --format says {form}")
    kind = named or form or (next(iter(kinds)) if name == STDOUT or len(kinds) == 1 else None)
    if kind is None:
        endings = " or ".join(f"*{endings[0]}" for endings in kinds.values())
        option = f", or --format {'|'.join(kinds)}," if form is None else ""
        raise InputError(f"-o takes {endings}; got {name}: another name{option} says the kind")
    return kind
