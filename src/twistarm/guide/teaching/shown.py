"""Things that a lesson shows, as plain data: text, tables, figures, scenes, sliders, predictions and exercises."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ...model.arm import Arm
from ...planning.trajectory import Trajectory
from ...support.checks import Array
from ..grading.report import Report
from . import scenes, stills, svg


@dataclass(frozen=True)
class Text:
    """Markdown with formulae between dollars."""

    markdown: str

    def plain(self) -> str:
        """The markdown."""
        return self.markdown

    def data(self, folder: Path | None) -> dict[str, Any]:
        """The markdown."""
        return {"kind": "text", **asdict(self)}


@dataclass(frozen=True)
class Table:
    """Rows of cells under a head; cells are markdown."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""

    def plain(self) -> str:
        """Columns as wide as they need to be."""
        lines = [list(self.head), *map(list, self.rows)]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        text = ["  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True)) for line in lines]
        return "\n".join([*([self.caption] if self.caption else []), *text])

    def data(self, folder: Path | None) -> dict[str, Any]:
        """Head, rows and caption."""
        return {"kind": "table", **asdict(self)}


@dataclass(frozen=True)
class Figure:
    """A figure of matplotlib, drawn as SVG when a page asks for it."""

    figure: Any
    alt: str
    caption: str = ""

    def plain(self) -> str:
        """What the figure shows, in words."""
        return f"[figure] {self.alt}"

    def data(self, folder: Path | None) -> dict[str, Any]:
        """The SVG, its words and its caption."""
        return {"kind": "figure", "svg": svg.of(self.figure), "alt": self.alt, "caption": self.caption}


@dataclass(frozen=True)
class Scene:
    """An arm to look at from all sides: a stand-alone page in a frame, and a drawing for paper."""

    arm: Arm
    theta: Array
    trajectory: Trajectory | None
    caption: str
    screws: bool

    def plain(self) -> str:
        """What there is to see, in words."""
        return f"[scene] {self.alt}"

    @property
    def alt(self) -> str:
        """What there is to see, in words."""
        return f"{self.arm.name}, an arm of {self.arm.n} joints, to be turned and moved"

    def data(self, folder: Path | None) -> dict[str, Any]:
        """The names of the page and its scripts in `folder`, or the page whole, and the drawing."""
        place = {"page": scenes.whole(self)} if folder is None else {"files": scenes.saved(self, folder)}
        still = svg.of(stills.arm(self.arm, self.theta))
        return {"kind": "scene", **place, "still": still, "alt": self.alt, "caption": self.caption}


@dataclass(frozen=True)
class Slider:
    """Something to move by hand in the page, with a question whose answer it shows."""

    name: str
    question: str
    answer: str
    numbers: Mapping[str, Any]

    def plain(self) -> str:
        """Question and answer."""
        return f"Question: {self.question}\nAnswer: {self.answer}"

    def data(self, folder: Path | None) -> dict[str, Any]:
        """Name, numbers, question, answer, and the drawing for paper."""
        figure, alt = stills.slider(self.name, self.numbers)
        words = {"question": self.question, "answer": self.answer, "alt": alt}
        return {"kind": "slider", "name": self.name, "numbers": dict(self.numbers), "still": svg.of(figure), **words}


@dataclass(frozen=True)
class Prediction:
    """A question for the reader to answer before the answer is unfolded."""

    question: str
    answer: str

    def plain(self) -> str:
        """Question and answer."""
        return f"Question: {self.question}\nAnswer: {self.answer}"

    def data(self, folder: Path | None) -> dict[str, Any]:
        """Both, as markdown."""
        return {"kind": "prediction", **asdict(self)}


@dataclass(frozen=True)
class Exercises:
    """The exercises of a lesson: prompt, signature and model solution of each."""

    lesson: str
    entries: Sequence[Mapping[str, str]]

    def plain(self) -> str:
        """Prompts and signatures, and how to check."""
        texts = [
            f"Exercise {k}: {entry['name']}\n\n{entry['prompt']}\n\n{entry['signature']}\n"
            for k, entry in enumerate(self.entries, start=1)
        ]
        return "\n".join([*texts, f"To check: twistarm guide check guide_exercises/{self.lesson}.py"])

    def data(self, folder: Path | None) -> dict[str, Any]:
        """The entries."""
        return {"kind": "exercises", "lesson": self.lesson, "entries": [dict(entry) for entry in self.entries]}


@dataclass(frozen=True, repr=False)
class Graded(Report):
    """A report that is shown when it is made."""

    def plain(self) -> str:
        """Its lines, and what the reader's code printed where something is not right."""
        return "\n".join(self.told)

    def data(self, folder: Path | None) -> dict[str, Any]:
        """The same, apart."""
        return {"kind": "report", "lines": self.lines, "printed": self.printed_lines}

    def _ipython_display_(self) -> None:
        """Not shown again as the value of a notebook's cell."""
