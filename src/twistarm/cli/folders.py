"""`check` and `doctor` over a folder: every description in turn, a line each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from textwrap import shorten
from typing import Any

from ..arm import Arm
from ..doctor.folder import descriptions_in
from .output import console, print_json, progress_bar, table
from .wording import as_typed

LONGEST = 80
"""Characters of a reason in a folder's table: twistarm doctor FILE tells the rest."""

PART = "no robot: macros only"
"""The verdict on a file that others include."""


@dataclass(frozen=True)
class Line:
    """What became of one file; `good` is False where the exit code must tell, None for a part of other files."""

    verdict: str
    good: bool | None
    arm: Arm | None = None
    detail: str = ""
    more: Mapping[str, Any] = field(default_factory=dict)


def refused(why: str, **more: Any) -> Line:
    """The line of a file that cannot be loaded."""
    return Line("refused", False, detail=shorten(as_typed(why), LONGEST, placeholder=" …"), more=more)


def walk(folder: Path, title: str, look: Callable[[Path], Line], *, json: bool) -> int:
    """Look at every description below `folder`, print what became of each, and return the exit code."""
    files = descriptions_in(folder)
    lines: dict[Path, Line] = {}
    with progress_bar(title) as progress:
        for done, path in enumerate(files, start=1):
            lines[path.relative_to(folder)] = look(path)
            progress(done / len(files))
    good = all(line.good is not False for line in lines.values())
    if json:
        print_json({"folder": str(folder), "ok": good, "files": [_as_json(path, lines[path]) for path in lines]})
    else:
        _print(folder, title, lines)
    return 0 if good else 1


def _print(folder: Path, title: str, lines: Mapping[Path, Line]) -> None:
    columns = ["file", "verdict", "joints", "tip", "detail"]
    rows = [[str(path), line.verdict, *_arm(line.arm), line.detail] for path, line in lines.items()]
    console().print(table(f"{folder}: {title}", columns, rows, text=["verdict", "tip", "detail"]))
    judged = [line.good for line in lines.values() if line.good is not None]
    apart = f" (beside {len(lines) - len(judged)} with macros only)" if len(judged) < len(lines) else ""
    print(f"{sum(judged)} of {len(judged)} good{apart}")


def _arm(arm: Arm | None) -> tuple[object, str]:
    """How many joints, and the tip; whether it was chosen for want of anybody who says which."""
    if arm is None:
        return "", ""
    return arm.n, f"{arm.tip} (chosen)" if any(one.code == "several-tips" for one in arm.findings) else arm.tip


def _as_json(path: Path, line: Line) -> dict[str, Any]:
    arm = line.arm
    ends = {"n": arm and arm.n, "base": arm and arm.base, "tip": arm and arm.tip}
    return {"file": str(path), "verdict": line.verdict, **ends, "ok": line.good, **line.more}
