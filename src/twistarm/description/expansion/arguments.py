"""The arguments of a xacro file: which it declares, and which it uses."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

_USED = re.compile(r"\$\(arg\s+([^)\s]+)\s*\)")


def arguments_in(root: ET.Element) -> dict[str, str | None]:
    """Every argument that a document declares or uses, with its default; None if it is required or not declared."""
    declared: dict[str, str | None] = {}
    used: dict[str, None] = {}
    for element in root.iter():
        if element.tag == "xacro:arg" and "name" in element.attrib:
            declared.setdefault(element.attrib["name"], element.get("default"))
        for text in (*element.attrib.values(), element.text or "", element.tail or ""):
            used |= dict.fromkeys(_USED.findall(text) if "$(" in text else ())
    return declared | {name: None for name in used if name not in declared}
