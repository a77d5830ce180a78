"""The nodes of Meshcat's scene: one for each thing that moves."""

from __future__ import annotations

from urllib.parse import quote


def link_path(name: str) -> str:
    """The node of a link. Slashes in names are escaped, because Meshcat splits paths there."""
    return f"/arm/link:{quote(name, safe='')}"


def drawn_path(name: str) -> str:
    """The node of what a program draws by this name."""
    return f"/drawn/name:{quote(name, safe='')}"


def screw_path(i: int) -> str:
    """The node of moving joint i's screw."""
    return f"/screws/screw:{i}"


def rod_path(i: int) -> str:
    """The node of what moves with joint i, where there are no links."""
    return f"/arm/rod:{i}"
