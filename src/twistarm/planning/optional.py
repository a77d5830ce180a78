"""SciPy, which planning needs and the rest of twistarm does not."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from ..support.errors import missing_extra


def scipy(part: str) -> Any:
    """The module of SciPy of that name, such as "linalg". Raises MissingExtraError without SciPy."""
    try:
        return import_module(f"scipy.{part}")
    except ImportError as error:
        raise missing_extra("planning", "SciPy", "plan") from error
