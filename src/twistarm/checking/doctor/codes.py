"""The list of every finding's code, from the table that findings are made with."""

from __future__ import annotations

from ...description.findings import CODES, Severity

_MEANS: dict[Severity, str] = {
    "error": "The arm cannot be loaded; nothing is guessed.",
    "warning": "The arm loads, but something is missing, repaired or hardly meant so.",
    "info": "Good to know; nothing needs to change.",
}


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
