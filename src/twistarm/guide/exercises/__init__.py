"""The exercises of the lessons, a module for each lesson."""

from __future__ import annotations

from importlib import import_module

from ...support.errors import unknown_name
from ..course import LESSONS
from .exercise import Exercise, module_of

__all__ = ["LESSONS", "Exercise", "every_exercise", "exercises_of"]


def exercises_of(lesson: str) -> tuple[Exercise, ...]:
    """The exercises of a lesson, in their order on the page.

    Raises:
        UnknownNameError: There is no such lesson.
    """
    if lesson not in LESSONS:
        raise unknown_name("lesson", lesson, LESSONS, within="the guide", listing=f"{len(LESSONS)} lessons")
    exercises: tuple[Exercise, ...] = import_module(f".{module_of(lesson)}", __package__).EXERCISES
    return exercises


def every_exercise() -> dict[str, Exercise]:
    """The exercises of the course by name, in its order."""
    return {exercise.name: exercise for lesson in LESSONS for exercise in exercises_of(lesson)}
