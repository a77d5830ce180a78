"""Texts of other languages, kept in files of their own and filled with a value for each `$name`."""

from __future__ import annotations

from pathlib import Path
from string import Template


def filled(template: Path, **values: object) -> str:
    """The text of a file, with the values in place of their names. Every name needs one."""
    return Template(template.read_text(encoding="utf-8")).substitute(values)
