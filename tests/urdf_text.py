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


BRANCHED = """<robot name="branched">
  <link name="root"/><link name="mast"/><link name="base_link"/><link name="upper"/><link name="rod"/>
  <link name="tool0"/><link name="left"/><link name="right"/><link name="bogie"/>
  <joint name="lift" type="prismatic"><parent link="root"/><child link="mast"/><origin xyz="0.1 0 0.2" rpy="0.1 0.2 0"/>
    <axis xyz="0 0 1"/><limit lower="0" upper="0.5" velocity="1" effort="1"/></joint>
  <joint name="turn" type="continuous"><parent link="mast"/><child link="base_link"/>
    <origin xyz="0 0.1 0" rpy="0 0 0.4"/><axis xyz="0 1 0"/></joint>
  <joint name="a" type="revolute"><parent link="base_link"/><child link="upper"/><origin xyz="0 0 0.3" rpy="0 0.7 0"/>
    <axis xyz="0.6 0 0.8"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="b" type="revolute"><parent link="upper"/><child link="rod"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/><mimic joint="a" multiplier="-0.5" offset="0.3"/></joint>
  <joint name="c" type="prismatic"><parent link="rod"/><child link="tool0"/><origin xyz="0.2 0 0"/><axis xyz="1 0 0"/>
    <limit lower="0.1" upper="0.6" velocity="1" effort="1"/></joint>
  <joint name="finger" type="prismatic"><parent link="tool0"/><child link="left"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.04" velocity="1" effort="1"/></joint>
  <joint name="follower" type="prismatic"><parent link="tool0"/><child link="right"/><axis xyz="0 -1 0"/>
    <limit lower="0" upper="0.04" velocity="1" effort="1"/><mimic joint="finger"/></joint>
  <joint name="wheel" type="continuous"><parent link="root"/><child link="bogie"/><origin xyz="0 0 -0.1"/>
    <axis xyz="0 1 0"/></joint>
</robot>"""
