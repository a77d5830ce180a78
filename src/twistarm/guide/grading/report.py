"""A report on a file or a function: a verdict per exercise, or why there is none."""

from __future__ import annotations

from dataclasses import dataclass

from .verdict import Verdict

RIGHT, NOT_RIGHT, NOT_USABLE = 0, 1, 2
"""Exit codes: all right; something is not right, or not written yet; the file cannot be used."""

SHOWN_LINES, SHOWN_LETTERS = 12, 200
"""The most lines, and letters of a line, that are shown of what the reader's code printed."""

SIGNS = {"right": "✓", "wrong": "✗", "unwritten": "…", "unusable": "✗"}


@dataclass(frozen=True)
class Report:
    """The graded exercises and their verdicts.

    `problem` says in one sentence why the whole file cannot be used. For a syntax error, `excerpt` has its line and a
    caret below. `printed` is what the reader's code printed.
    """

    subject: str
    verdicts: tuple[Verdict, ...] = ()
    problem: str = ""
    excerpt: tuple[str, ...] = ()
    printed: str = ""

    @property
    def code(self) -> int:
        """The exit code of a program that was asked for this report."""
        if self.problem:
            return NOT_USABLE
        return RIGHT if self.ok else NOT_RIGHT

    @property
    def ok(self) -> bool:
        """Whether everything is right."""
        return not self.problem and all(each.ok for each in self.verdicts)

    @property
    def lines(self) -> list[str]:
        """The report in words, a line for each verdict."""
        if self.problem:
            return [f"{self.subject}: {self.problem}", *self.excerpt]
        return [f"{SIGNS[each.state]} {each.exercise}: {each.words}" for each in self.verdicts]

    @property
    def printed_lines(self) -> list[str]:
        """The beginning of what the reader's code printed, where something is not right."""
        if self.ok or not self.printed.strip():
            return []
        lines = self.printed.splitlines()
        cut = ["…"] if len(lines) > SHOWN_LINES else []
        return [*(line[:SHOWN_LETTERS] for line in lines[:SHOWN_LINES]), *cut]

    @property
    def told(self) -> list[str]:
        """The report for a terminal: its lines, and below them what was printed."""
        printed = [f"  {line}" for line in self.printed_lines]
        return [*self.lines, *(["", "your code printed:", *printed] if printed else [])]

    def __repr__(self) -> str:
        return "\n".join(self.lines)
