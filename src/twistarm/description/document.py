"""XML text to elements that know their line, and the context in which a description is read."""

from __future__ import annotations

import codecs
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from ..errors import DescriptionError
from .findings import Finding, Severity
from .packages import PackageIndex


@dataclass
class Reading:
    """What one reading of a description carries along: the elements' lines, the packages, the findings so far."""

    path: Path
    packages: PackageIndex
    lines: dict[ET.Element, int] = field(default_factory=dict)
    show_lines: bool = True
    findings: list[Finding] = field(default_factory=list)

    def where(self, element: ET.Element) -> str:
        """`robot.urdf:12: joint 'elbow'`; without the line where the text was expanded from xacro."""
        line = f":{self.lines[element]}" if self.show_lines and element in self.lines else ""
        name = element.get("name")
        return f"{self.path.name}{line}: {element.tag}" + (f" {name!r}" if name else "")

    def note(
        self, code: str, severity: Severity, where: str, what: str, remedy: str, *, repaired: bool = False
    ) -> None:
        """Add a finding."""
        self.findings.append(Finding(code, severity, where, what, remedy, repaired))

    def error(self, element: ET.Element, message: str) -> DescriptionError:
        """The error for something that cannot be repaired."""
        return DescriptionError(f"{self.where(element)}: {message}")


def read_text(path: Path) -> str:
    """The file's text: UTF-16 by its byte-order mark, UTF-8 with or without one, else Latin-1."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise DescriptionError(f"{path}: cannot be read: {error.strerror or error}") from error
    wide = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        return data.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def parse_xml(text: str, reading: Reading) -> ET.Element:
    """The root element of `text`; every element's line goes into `reading.lines`.

    Plain expat without namespaces: leftovers such as `xacro:` prefixes or `<gazebo>` blocks with undeclared ones do
    not matter. A document type (the door to entities and external files) is refused.
    """
    builder = ET.TreeBuilder()
    parser = expat.ParserCreate("utf-8")
    parser.buffer_text = True

    def start(tag: str, attributes: dict[str, str]) -> None:
        reading.lines[builder.start(tag, attributes)] = parser.CurrentLineNumber

    def refuse(name: str, *_: object) -> None:
        raise DescriptionError(f"{reading.path}: a document type (<!DOCTYPE {name}>) is not allowed; remove it")

    parser.StartElementHandler = start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.data
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(text.encode("utf-8", "surrogatepass"), True)
    except expat.ExpatError as error:
        raise DescriptionError(f"{reading.path}: not well-formed XML: {error}; is it a URDF or xacro file?") from error
    return builder.close()
