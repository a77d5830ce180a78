"""`check` and `doctor` over a folder, with one entry for each description."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rich.table import Table

from ..arm.arm import Arm
from ..checking.doctor.folder import descriptions_in
from ..description.findings import Finding
from ..support.messages import joined
from ..support.path_redaction import without_places
from .output import console, literal, print_json, progress_bar, say
from .wording import words, words_of

VERDICT = 24
"""Characters of a verdict on a line."""

PART = "no robot: macros only"
"""The verdict on a file that other files include."""


@dataclass(frozen=True)
class Line:
    """The result of one file. `good` is None for a part of other files."""

    verdict: str
    good: bool | None
    arm: Arm | None = None
    detail: str = ""
    more: Mapping[str, Any] = field(default_factory=dict)


def refused(said: str, found: Iterable[Finding] = (), /, **more: Any) -> Line:
    """The line of an unloadable file: its first error and the remedy, else `said`."""
    error = next((one for one in found if one.severity == "error"), None)
    why = said if error is None else joined("; ", filter(None, (error.what, error.remedy)))
    return Line("refused", False, detail=words(why), more=more)


def walk(folder: Path, title: str, look: Callable[[Path], Line], *, json: bool) -> int:
    """Look at every description below `folder`, print the results and return the exit code."""
    files = descriptions_in(folder)
    lines: dict[Path, Line] = {}
    with progress_bar(title) as progress:
        for done, path in enumerate(files, start=1):
            try:
                line = look(path)
            except Exception as error:
                why = words_of(error)
                line = Line("refused", False, detail=why, more={"error": without_places(why, path)})
            lines[path.relative_to(folder)] = line
            progress(done / len(files))
    good = all(line.good is not False for line in lines.values())
    if json:
        print_json({"folder": str(folder), "ok": good, "files": [_as_json(path, lines[path]) for path in lines]})
    else:
        _print(folder, title, lines)
    return 0 if good else 1


def _print(folder: Path, title: str, lines: Mapping[Path, Line]) -> None:
    page = Table.grid(padding=(0, 2, 0, 0))
    page.add_column(max_width=VERDICT)
    page.add_column(overflow="fold")
    judged = {path: line for path, line in lines.items() if line.good is not None}
    for path, line in judged.items():
        said = [literal(str(path)), f"[dim]{literal(_arm(line.arm))}[/dim]" if line.arm else "", literal(line.detail)]
        page.add_row(literal(line.verdict), "\n".join(part for part in said if part))
    console().print(f"[bold]{literal(str(folder))}: {title}[/bold]", page)
    apart = f" (beside {len(lines) - len(judged)} with macros only)" if len(judged) < len(lines) else ""
    say(f"{sum(bool(line.good) for line in judged.values())} of {len(judged)} good{apart}")


def _arm(arm: Arm) -> str:
    """The joints, base and tip of an arm, and whether twistarm chose the tip."""
    chosen = " (chosen)" if any(one.code == "several-tips" for one in arm.findings) else ""
    return f"{arm.n} joint{'s' * (arm.n != 1)} from {arm.base} to {arm.tip}{chosen}"


def _as_json(path: Path, line: Line) -> dict[str, Any]:
    arm = line.arm
    ends = {"n": arm and arm.n, "base": arm and arm.base, "tip": arm and arm.tip}
    return {"file": str(path), "verdict": line.verdict, **ends, "ok": line.good, **line.more}
