"""Wording of the doctor's findings: several parts in one, snippets for an arm.toml, and the list of all codes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...description.companions.toml_entries import toml_key
from ...description.findings import CODES, Finding, Place, Severity, finding
from ...description.tree import Description, Joint, Link
from ...support.errors import listed

_MEANS: dict[Severity, str] = {
    "error": "The arm cannot be loaded; nothing is guessed.",
    "warning": "The arm loads, but something is missing, repaired or hardly meant so.",
    "info": "Good to know; nothing needs to change.",
}

SHOWN = 6
"""Names in one finding before the rest is counted."""


def grouped(code: str, description: Description, parts: Sequence[Joint | Link], what: str, remedy: str) -> Finding:
    """One finding about several joints or links: at its place for one, else at the file with their names."""
    if len(parts) == 1:
        return finding(code, description.place(parts[0]), what, remedy)
    names = listed([part.name for part in parts], SHOWN)
    return finding(code, description.place(), f"{names}: {what}", remedy)


def place_of(description: Description | None, name: str) -> Place:
    """The file, or the arm's name without one."""
    return Place(name) if description is None else description.place()


def toml_table(header: str, values: Mapping[str, float]) -> str:
    """A table of an arm.toml, a line for each entry."""
    lines = [f"{toml_key(name)} = {value:.6g}" for name, value in values.items()]
    return "\n".join([f"[{header}]", *lines])


def codes_page() -> str:
    """The codes by severity in Markdown, each with what it means."""
    parts = ["# Findings", "", "Made by `twistarm doctor --codes`. The codes are stable: programs may rely on them."]
    for severity, meaning in _MEANS.items():
        rows = {f"`{code}`": known.meaning for code, known in CODES.items() if known.severity == severity}
        wide, long = max(map(len, rows)), max(map(len, rows.values()))
        parts += ["", f"## {severity}", "", meaning, ""]
        parts += [f"| {'code':{wide}} | {'what it means':{long}} |", f"|{'-' * (wide + 2)}|{'-' * (long + 2)}|"]
        parts += [f"| {code:{wide}} | {means:{long}} |" for code, means in rows.items()]
    return "\n".join(parts) + "\n"
