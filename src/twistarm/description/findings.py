"""What was noticed about a description: a stable code, how grave it is, where, what it means and the remedy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Severity = Literal["info", "warning", "error"]


@dataclass(frozen=True)
class Finding:
    """One observation about a description.

    `code` is stable and machine-readable; `where` names the file's element (and line); `what` says what is there and
    what it means; `remedy` what its owner can do. `repaired` tells whether twistarm already works on a mended copy.
    """

    code: str
    severity: Severity
    where: str
    what: str
    remedy: str
    repaired: bool = False

    def __str__(self) -> str:
        return f"{self.severity}: {self.where}: {self.what} ({self.remedy})"
