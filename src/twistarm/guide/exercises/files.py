"""The reader's files: Python for each lesson, and tasks for Octave and MATLAB."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ...arm.arm import Arm
from ...support.errors import InputError
from ...support.files import write_whole
from . import LESSONS, exercises_of
from .octave_files import octave_files

HERE = Path("guide_exercises")
"""The folder where nobody names another."""

HEAD = '''"""Exercises of the lesson {lesson}.

Fill in the functions, and have them graded:

    twistarm guide check {file}

Angles are in radians, twists are (v, ω), poses are 4 × 4 arrays. What an earlier lesson had you write you may take
from twistarm: `from twistarm import screws`, and then screws.exp, say. A function counts if it is defined in this file.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
'''


def python_text(lesson: str, folder: Path = HERE) -> str:
    """The Python file of a lesson in the folder, its functions to be filled in."""
    head = HEAD.format(lesson=lesson, file=folder / f"{lesson}.py")
    return "\n\n".join([head, *(exercise.template for exercise in exercises_of(lesson))])


def exercise_files(arm: Arm, folder: Path) -> Iterator[tuple[str, str]]:
    """Name and text of every file in the folder. Those for Octave and MATLAB hold instances of the arm."""
    for lesson in LESSONS:
        yield f"{lesson}.py", python_text(lesson, folder)
    for name, text in octave_files(arm):
        yield f"octave/{name}", text


def write_exercises(folder: Path, arm: Arm) -> tuple[list[str], list[str]]:
    """Write the files into a folder, which is made if needed.

    Existing files stay.

    Args:
        folder: Where to.
        arm: The arm with the screws among the instances for Octave and MATLAB.

    Returns:
        The names of the files written, and of those that stayed.

    Raises:
        InputError: The folder cannot be made, or written to.
    """
    written, stayed = [], []
    try:
        (folder / "octave").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {folder}: {error.strerror or error}") from error
    for name, text in exercise_files(arm, folder):
        if (folder / name).exists() or (folder / name).is_symlink():
            stayed.append(name)
        else:
            write_whole(folder / name, text)
            written.append(name)
    return written, stayed
