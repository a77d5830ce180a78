"""A report on a file or a function: a verdict for each exercise, or why there is none."""

from __future__ import annotations

from dataclasses import dataclass

from .verdict import Verdict

RIGHT, NOT_RIGHT, NOT_USABLE = 0, 1, 2
"""Exit codes: all right; something is not right, or not written yet; the file cannot be used."""

SIGNS = {"right": "✓", "wrong": "✗", "unwritten": "…", "unusable": "✗"}


@dataclass(frozen=True)
class Report:
    """What was graded, and how.

    `problem` says in one sentence why the file as a whole cannot be used, and `excerpt` are its line and a caret
    below where that is a matter of spelling. `printed` is what the reader's code printed.
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

    def __repr__(self) -> str:
        return "\n".join(self.lines)

    def _repr_markdown_(self) -> str:
        """The report in a notebook."""
        return "\n".join(f"- {line.replace('*', '&ast;')}" for line in self.lines)
