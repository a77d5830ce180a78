"""The grader of the exercises: a reader's function or file against independent answers and typical mistakes."""

from __future__ import annotations

from .checking import check, check_file
from .report import Report
from .verdict import Verdict

__all__ = ["Report", "Verdict", "check", "check_file"]
