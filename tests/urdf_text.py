"""Small URDF texts for tests: a two-joint arm, with any part replaced."""

from __future__ import annotations

from pathlib import Path


def joint(
    name: str,
    parent: str,
    child: str,
    kind: str = "revolute",
    inside: str = "",
    xyz: str = "0 0 0.5",
    rpy: str = "0 0 0",
) -> str:
    limit = '<limit lower="-1" upper="1" velocity="2" effort="3"/>' if kind in ("revolute", "prismatic") else ""
    axis = '<axis xyz="0 0 1"/>' if kind != "fixed" else ""
    for tag in ("limit", "axis"):
        if f"<{tag}" in inside:
            limit, axis = ("", axis) if tag == "limit" else (limit, "")
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/>{axis}{limit}{inside}</joint>'
    )


def robot(*parts: str, links: tuple[str, ...] = ("base_link", "upper", "tool0"), name: str = "tiny") -> str:
    bodies = "".join(f'<link name="{link}"/>' for link in links)
    return f'<?xml version="1.0"?>\n<robot name="{name}">{bodies}{"".join(parts)}</robot>'


def two_joints(**changes: str) -> str:
    """base_link —a→ upper —b→ tool0."""
    return robot(joint("a", "base_link", "upper", **changes), joint("b", "upper", "tool0"))


def write(folder: Path, text: str, name: str = "arm.urdf") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path
