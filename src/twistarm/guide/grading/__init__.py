"""The grader of the exercises: a reader's function or file against independent answers and typical mistakes."""

from __future__ import annotations

from .checking import check, check_file
from .verdict import Report, Verdict

__all__ = ["Report", "Verdict", "check", "check_file"]
