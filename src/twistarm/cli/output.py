"""Everything that a command prints or writes: words, tables, JSON, progress, and the files of `-o FILE`.

The ending of a file gives its kind, and `-` is standard output.
"""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, is_dataclass, replace
from enum import Enum
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from rich.console import Console, RenderableType
from rich.progress import Progress

from ..arm.arm import Arm
from ..description.findings import Finding
from ..support.errors import InputError, printable, without_places
from ..support.files import writable, write_folder, write_whole
from ..support.messages import Text
from .tables import Table
from .wording import words

PIPED_WIDTH = 160  # Columns without a terminal.

STDOUT = "-"

Kinds = Mapping[str, tuple[str, ...]]  # The kinds of files that a command can write, with their endings.
FOLDER = "/"  # The ending of a folder.

# What makes the content of a file, or of the files in a folder, by its kind.
Contents = Mapping[str, Callable[[], str | bytes | Mapping[str, str | bytes]]]


def say(*lines: object, file: TextIO | None = None) -> None:
    """Print lines. Control characters in names do not reach the terminal."""
    print(*(printable(str(line)) for line in lines), sep="\n", file=file or sys.stdout, flush=True)


def warn(message: str, *, radians: bool = False) -> None:
    """Print a warning on stderr, in one line."""
    say(f"warning: {words(message, radians=radians)}", file=sys.stderr)


def note(message: str, *, radians: bool = False) -> None:
    """Print a note about an assumption on stderr, in one line."""
    say(f"note: {words(message, radians=radians)}", file=sys.stderr)


def refuse(wrong: Mapping[str, object]) -> None:
    """Raise InputError with the first of the sentences that is true of the typed options."""
    for sentence, is_so in wrong.items():
        if is_so:
            raise InputError(sentence)


def print_json(content: Any) -> None:
    """Print one JSON document. Characters that are not printable are escaped, as JSON allows."""
    # No NaN: JSON has none, and most parsers refuse it. `plain` has made null of it.
    text = json.dumps(plain(content), allow_nan=False, indent=2, ensure_ascii=False)
    print(re.sub(r"[^\n -~]", lambda c: c[0] if c[0].isprintable() else json.dumps(c[0])[1:-1], text))


def plain(value: Any) -> Any:
    """A result as JSON holds it: lists, numbers, texts and null. Infinities become null."""
    match value:
        case Text():
            return words(value, radians=True)
        case Enum():
            return value.name
        case float() | np.floating():
            return float(value) if np.isfinite(value) else None
        case np.ndarray() | np.generic():
            return plain(value.tolist())
        case Mapping():
            return {str(plain(key)): plain(item) for key, item in value.items()}
        case Finding():
            place, here = value.place, Path(value.place.file)
            what, remedy = (without_places(words(text, radians=True), here) for text in (value.what, value.remedy))
            of_place = {"file": without_places(place.file, here)} | entries(place, "line element name")
            found = entries(value, "code severity") | of_place | {"what": what, "remedy": remedy}
            return plain(found)
        case Arm():
            return value.name
        case tuple() if hasattr(value, "_asdict"):
            return plain(value._asdict())
        case list() | tuple():
            return [plain(item) for item in value]
        case set() | frozenset():
            return sorted(map(plain, value))
        case Path():
            return str(value)
        case _ if is_dataclass(value):
            return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    return value


def entries(result: object, names: str) -> dict[str, Any]:
    """The attributes `names` of a result, for JSON."""
    return {name: getattr(result, name) for name in names.split()}


@contextmanager
def progress_bar(label: str) -> Iterator[Callable[[float], object]]:
    """A progress bar on stderr, on a terminal only, as a callback with the fraction done."""
    with Progress(console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task(label, total=1.0)
        yield lambda fraction: bar.update(task, completed=fraction)


@dataclass(frozen=True)
class Outputs:
    """How a command answers, and the files that it writes, as kind and name. `named` checks them before it begins."""

    files: tuple[tuple[str, str], ...] = ()
    json: bool = False
    radians: bool = False
    kinds: Kinds = field(default_factory=dict)
    form: str | None = ""
    force: bool = False
    over_description: bool = False

    def named(self, *names: str) -> Outputs:
        """The outputs with these files. InputError for one that cannot be written or would replace another.

        The ending gives the kind, else `form`, else the only one of `kinds`. Standard output takes the first of
        `kinds`. `form` is "" in a command without `--format`.
        """
        if self.form and self.form not in self.kinds:
            raise InputError(f"--format is one of {', '.join(self.kinds)}; got {self.form!r}")
        if names.count(STDOUT) + self.json > 1:
            raise InputError("-o - gives standard output to one file: leave out --json or the other -o -")
        files = tuple((self._kind(name), name) for name in names)
        for kind, name in files:
            if name == STDOUT:
                continue
            folder = FOLDER in self.kinds.get(kind, ())
            target = writable(name, over_description=self.over_description, folder=folder)
            kept = any(target.iterdir()) if target.is_dir() else target.exists()
            if kept and not self.force:
                replaced = "files of the same names" if folder else "it"
                raise InputError(f"{name} exists; --force replaces {replaced}, another name keeps it")
        return replace(self, files=files)

    def _kind(self, name: str) -> str:
        kinds, form = self.kinds, self.form
        ending = f"{name}{FOLDER}" if os.path.isdir(name) and any(FOLDER in ends for ends in kinds.values()) else name
        named = next((kind for kind, endings in kinds.items() if ending.lower().endswith(endings)), None)
        if named and form and named != form:
            raise InputError(f"{name} is named like a file of kind {named}, and --format says {form}")
        kind = named or form or (next(iter(kinds)) if name == STDOUT or len(kinds) == 1 else None)
        if name == STDOUT and FOLDER in kinds.get(kind or "", ()):
            raise InputError(f"a {kind} is a folder, which standard output cannot hold; give -o FOLDER/")
        if kind is None:
            endings = " or ".join("FOLDER/" if FOLDER in ends else f"*{ends[0]}" for ends in kinds.values())
            option = f", or --format {'|'.join(kinds)}" if form is None else ""
            raise InputError(f"-o takes {endings}; got {name}: choose another name{option}")
        return kind

    @property
    def words(self) -> TextIO:
        """The stream for people: stderr if standard output is JSON or one of the files."""
        stdout_used = self.json or any(name == STDOUT for _, name in self.files)
        return sys.stderr if stdout_used else sys.stdout

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
            for part in parts:
                document |= part.entries() if isinstance(part, Table) else {}
            print_json(document if names is None else document | {"written": names})
            return
        for part in parts:
            if isinstance(part, str):
                say(words(part, radians=self.radians), file=self.words)
                continue
            known = self.words.isatty() or "COLUMNS" in os.environ  # else Rich assumes 80 columns and folds text
            console = Console(file=self.words, width=None if known else PIPED_WIDTH, highlight=False, emoji=False)
            if isinstance(part, Table):
                part.print_on(console, self.radians)
            else:
                console.print(part)
        self.say(names or ())

    def lines(self, text: str) -> list[str]:
        """The lines of a text that has several, as parts of `show`."""
        return words(text, radians=self.radians).splitlines()

    def write(self, contents: Contents) -> list[str]:
        """Write every file with the result of the function of its kind. Return the names."""
        # All contents before the first file: an error in one of them must not leave the others behind.
        made = [(name, contents[kind]()) for kind, name in self.files]
        for name, content in made:
            if isinstance(content, Mapping):
                write_folder(name, content)
            elif name != STDOUT:
                write_whole(name, content, over_description=self.over_description)
            elif isinstance(content, str) and sys.stdout.isatty():
                say(*content.splitlines())
            else:
                # As bytes, because Windows would turn \n into \r\n.
                sys.stdout.buffer.write(content.encode() if isinstance(content, str) else content)
        return [name for name, _ in made]

    def say(self, written: Sequence[str]) -> None:
        """Tell a person which files were written."""
        for name in written:
            if name != STDOUT:
                say(f"written: {name}", file=self.words)
