"""An exercise: a function to write, an independent answer, instances, and known mistakes."""

from __future__ import annotations
import __future__

import ast
import inspect
import re
import sys
import textwrap
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ..course import LESSONS


def module_of(lesson: str) -> str:
    """The module of a lesson's exercises: its name without the numbers."""
    return re.sub(r"^[\d_]+", "", lesson)


@dataclass(frozen=True)
class Slip:
    """A mistake known by its results.

    `edits` {text of the model solution: its replacement} make it. `words` say what was done, its effect, and the
    remedy, with terms of the language in braces (`words.PYTHON`).
    """

    name: str
    words: str
    edits: Mapping[str, str]


def whole(answer: Any, *_: Any) -> Any:
    """An unchanged answer."""
    return answer


@dataclass(frozen=True)
class Exercise:
    """A function for the reader to write.

    `model` is the model solution, named as the exercise, with the prompt as docstring. `reference` gives the right
    answer from an independent source. `instances(rng, arm)` yields tuples of arguments: numbers, texts and arrays.
    `seen(answer, *arguments)` is the graded part if several answers are right, as the rotation of a quaternion.
    `tolerance` is relative to the largest expected number, at least 1.
    """

    model: Callable[..., Any]
    reference: Callable[..., Any]
    instances: Callable[[np.random.Generator, Arm], Iterable[tuple[Any, ...]]]
    slips: tuple[Slip, ...]
    tolerance: float = 1e-6
    seen: Callable[..., Any] = whole

    @property
    def name(self) -> str:
        """The function's name, unique in the course."""
        return self.model.__name__

    @property
    def lesson(self) -> str:
        """The lesson that it belongs to."""
        return next(lesson for lesson in LESSONS if module_of(lesson) == self.model.__module__.rpartition(".")[2])

    @property
    def prompt(self) -> str:
        """The task, as markdown."""
        return inspect.getdoc(self.model) or ""

    @property
    def parameters(self) -> tuple[str, ...]:
        """The names of the function's arguments."""
        return tuple(inspect.signature(self.model).parameters)

    @cached_property
    def solution(self) -> str:
        """The source of the model solution, without the prompt."""
        lines = inspect.getsource(self.model).splitlines()
        body = _definition(lines).body
        kept = [*lines[: body[0].lineno - 1], *lines[body[1].lineno - 1 :]]
        return re.sub(r"  # type: ignore.*", "", "\n".join(kept)) + "\n"

    @cached_property
    def signature(self) -> str:
        """`def rotation_z(alpha: float) -> Array:`"""
        lines = inspect.getsource(self.model).splitlines()
        return "\n".join(lines[: _definition(lines).body[0].lineno - 1])

    @property
    def template(self) -> str:
        """The function to fill in: signature, prompt as docstring, and a "not written" error."""
        prompt = textwrap.indent(self.prompt, "    ", lambda line: bool(line.strip()))
        return f'{self.signature}\n    """{prompt.lstrip()}\n    """\n    raise NotImplementedError\n'

    @property
    def matlab(self) -> str | None:
        """The model solution for Octave and MATLAB, or None."""
        path = Path(__file__).with_name("octave") / f"{self.name}.m"
        return path.read_text("utf-8") if path.is_file() else None

    def wrong(self, slip: Slip) -> Callable[..., Any]:
        """The function of a reader who made that slip."""
        text = self.solution
        for old, new in slip.edits.items():
            if old not in text:
                raise LookupError(f"{self.name}, {slip.name}: the solution has no {old!r}")
            text = text.replace(old, new)
        names = dict(vars(sys.modules[self.model.__module__]))
        # Of a text of our own: what its module would compile, with one thing wrong.
        exec(compile(text, f"<{slip.name}>", "exec", __future__.annotations.compiler_flag), names)
        made: Callable[..., Any] = names[self.name]
        return made


def _definition(lines: list[str]) -> ast.FunctionDef:
    found = ast.parse("\n".join(lines)).body[0]
    assert isinstance(found, ast.FunctionDef)
    return found
