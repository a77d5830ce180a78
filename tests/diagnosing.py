"""The doctor's findings by their codes."""

from __future__ import annotations

from pathlib import Path

from finding_cases import Case
from test_finding_codes import found
from twistarm import diagnose
from twistarm.description.findings import Finding


def codes(source: object, **load: object) -> list[str]:
    return [one.code for one in diagnose(source, **load)]  # type: ignore[arg-type]


def only(case: Case, folder: Path, code: str) -> Finding:
    (one,) = [one for one in found(case, folder) if one.code == code]
    return one
