"""Words, JSON and progress: everything that a command prints passes through here."""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.progress import Progress

from ..arm.arm import Arm
from ..description.findings import Finding
from ..support.errors import printable
from ..support.messages import Text
from ..support.path_redaction import without_places
from .wording import words

PIPED_WIDTH = 160
"""Columns without a terminal."""


def console(file: TextIO | None = None) -> Console:
    """A console on stdout, or on `file`. Pass names through `literal` before you print them as markup."""
    out = file or sys.stdout
    known = out.isatty() or "COLUMNS" in os.environ
    return Console(file=out, width=None if known else PIPED_WIDTH, highlight=False, emoji=False)


def literal(text: object) -> str:
    """Text for a console's markup, shown unchanged and in one line."""
    return escape(printable(str(text)))


def say(*lines: object, file: TextIO | None = None) -> None:
    """Print lines. Control characters in names do not reach the terminal."""
    print(*(printable(str(line)) for line in lines), sep="\n", file=file or sys.stdout, flush=True)


def warn(message: str, *, radians: bool = False) -> None:
    """Print a warning on stderr, in one line."""
    say(f"warning: {words(message, radians=radians)}", file=sys.stderr)


def note(message: str, *, radians: bool = False) -> None:
    """Print a note about an assumption on stderr, in one line."""
    say(f"note: {words(message, radians=radians)}", file=sys.stderr)


def print_json(content: Any) -> None:
    """Print one JSON document. Characters that are not printable are escaped, as JSON allows."""
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
            return plain(_finding(value))
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


def _finding(finding: Finding) -> dict[str, Any]:
    """A finding with its place in parts, without folders of this machine."""
    place = finding.place
    here = Path(place.file)
    return {
        "code": finding.code,
        "severity": finding.severity,
        "file": without_places(place.file, here),
        "line": place.line,
        "element": place.element,
        "name": place.name,
        "what": without_places(words(finding.what, radians=True), here),
        "remedy": without_places(words(finding.remedy, radians=True), here),
        "repaired": finding.repaired,
    }


@contextmanager
def progress_bar(label: str) -> Iterator[Callable[[float], object]]:
    """A progress bar on stderr, on a terminal only, as a callback with the fraction done."""
    with Progress(console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task(label, total=1.0)
        yield lambda fraction: bar.update(task, completed=fraction)
