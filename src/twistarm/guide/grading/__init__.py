"""The grader of the exercises: a reader's function or file against independent answers and typical mistakes."""

from __future__ import annotations

from .checking import check, check_file
from .running import IN_SANDBOX
from .verdict import Report, Verdict

__all__ = ["IN_SANDBOX", "Report", "Verdict", "check", "check_file"]
