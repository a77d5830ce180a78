"""The arguments of a xacro file: which it declares, and which it uses."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path

_USED = re.compile(r"\$\(arg\s+([^)\s]+)\s*\)")
_PACKAGE = re.compile(r"\$\(find\s+([^)\s]+)\s*\)|package://([^/\s]+)")

_XACRO_TAGS = ("property", "macro", "arg", "include", "if", "unless")


@dataclass
class Arguments:
    """Arguments and packages of the files searched so far."""

    declared: dict[str, str | None] = field(default_factory=dict)
    used: dict[str, Path] = field(default_factory=dict)
    """The first file that uses each."""
    packages: dict[str, None] = field(default_factory=dict)
    unprefixed: set[str] = field(default_factory=set)
    """Names of properties and other elements without the prefix `xacro:`."""

    def look_through(self, root: ET.Element, file: Path) -> None:
        """Add the arguments and packages in the document of `file`."""
        for element in root.iter():
            if element.tag == "xacro:arg" and "name" in element.attrib:
                self.declared.setdefault(element.attrib["name"], element.get("default"))
            elif element.tag in _XACRO_TAGS:
                self.unprefixed.add(element.get("name", ""))
            for text in (*element.attrib.values(), element.text or "", element.tail or ""):
                for name in _USED.findall(text) if "$(" in text else ():
                    self.used.setdefault(name, file)
                for one, other in _PACKAGE.findall(text) if "$(" in text or "://" in text else ():
                    self.packages[one or other] = None

    def all(self) -> dict[str, str | None]:
        """Every argument with its default, None if it is required or not declared."""
        return self.declared | {name: None for name in self.used if name not in self.declared}


def declared_arguments(file: Path, root: ET.Element) -> dict[str, str | None]:
    """Every argument that the document of `file` declares or uses, with its default or None, without its includes."""
    arguments = Arguments()
    arguments.look_through(root, file)
    return arguments.all()
