"""The arguments of a xacro file: which it declares, and which it uses."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path

_USED = re.compile(r"\$\(arg\s+([^)\s]+)\s*\)")


@dataclass
class Arguments:
    """Arguments of the files searched so far, with the first file that uses each."""

    declared: dict[str, str | None] = field(default_factory=dict)
    used: dict[str, Path] = field(default_factory=dict)

    def look_through(self, root: ET.Element, file: Path) -> None:
        """Add the arguments in the document of `file`."""
        for element in root.iter():
            if element.tag == "xacro:arg" and "name" in element.attrib:
                self.declared.setdefault(element.attrib["name"], element.get("default"))
            for text in (*element.attrib.values(), element.text or "", element.tail or ""):
                for name in _USED.findall(text) if "$(" in text else ():
                    self.used.setdefault(name, file)

    def all(self) -> dict[str, str | None]:
        """Every argument with its default, None if it is required or not declared."""
        return self.declared | {name: None for name in self.used if name not in self.declared}


def declared_arguments(file: Path, root: ET.Element) -> dict[str, str | None]:
    """Every argument that the document of `file` declares or uses, with its default or None, without its includes."""
    arguments = Arguments()
    arguments.look_through(root, file)
    return arguments.all()
