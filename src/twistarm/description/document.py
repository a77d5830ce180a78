"""Files of a description: their texts, XML with lines, the numbers in it, and the context of reading."""

from __future__ import annotations

import errno
import json
import os
import xml.etree.ElementTree as ET
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from pathlib import Path
from xml.parsers import expat
from xml.parsers.expat import errors

from ..support.checks import number_in
from ..support.errors import DescriptionError, InputError
from ..support.files import as_path, kind_of, read_bounded, why_no_file
from ..support.messages import Text, package_folder
from .findings import Finding, Place, finding, refusal, refused
from .packages import PackageIndex

# Far above any length, angle, mass or multiplier of a robot. Products of larger numbers overflow.
LARGEST = 1e9
MAX_BYTES = 20_000_000  # A whole humanoid's URDF has some 200 kB, a robot cell's a few MB.

MAX_NESTING = 100  # No description nests deeper. Python's XML writer recurses.


def floats(text: str, count: int) -> list[float]:
    """Exactly `count` numbers of at most LARGEST in size; InputError, a ValueError, for anything else."""
    words = text.split(maxsplit=count)
    if len(words) != count:
        raise InputError(f"{count} numbers are wanted; got {text[:60]!r}")
    return [number_in(word, "it", -LARGEST, LARGEST) for word in words]


@dataclass
class Reading:
    """The context of one reading: the elements' lines, the packages, the findings so far."""

    path: Path
    packages: PackageIndex
    lines: dict[ET.Element, int] = field(default_factory=dict)
    show_lines: bool = True
    findings: list[Finding] = field(default_factory=list)

    def place(self, element: ET.Element | None = None) -> Place:
        """The place of an element: file, line, tag and name. Without an element, the file."""
        if element is None:
            return Place(self.path.name)
        return Place(self.path.name, self.line(element), element.tag, element.get("name", ""))

    def line(self, element: ET.Element) -> int | None:
        """The element's line in the file. None if the text was expanded from xacro."""
        return self.lines.get(element) if self.show_lines else None

    @property
    def whole(self) -> Place:
        """The file itself, by its full path."""
        return Place(str(self.path))

    def note(self, code: str, at: Place | ET.Element | None, what: str, remedy: str) -> None:
        """Add a finding about an element, another place, or the file as a whole."""
        place = at if isinstance(at, Place) else self.place(at)
        self.findings.append(finding(code, place, what, remedy))

    def error(self, element: ET.Element, code: str, what: str, remedy: str = "") -> DescriptionError:
        """The error for an element that cannot be repaired."""
        return refusal(code, self.place(element), what, remedy)

    @contextmanager
    def numbers_of(self, element: ET.Element, before: str, remedy: str = "") -> Generator[None]:
        """Errors about numbers as those of an element, with words before them."""
        try:
            yield
        except ValueError as error:
            raise self.error(element, "number-malformed", f"{before}{error}", remedy) from error

    def require_usable(self) -> None:
        """Raise DescriptionError if anything noted so far is an error."""
        if any(noted.severity == "error" for noted in self.findings):
            raise refused(self.findings)


_NOTED: ContextVar[set[Path] | None] = ContextVar("noted", default=None)


@contextmanager
def noted_files() -> Iterator[set[Path]]:
    """Collect the files of descriptions that this thread reads inside, also missing ones."""
    files: set[Path] = set()
    before = _NOTED.set(files)
    try:
        yield files
    finally:
        _NOTED.reset(before)


def note_file(path: Path) -> None:
    """Note that `path` is being looked for."""
    noted = _NOTED.get()
    if noted is not None:
        noted.add(path.absolute())


def existing_file(path: str | os.PathLike[str], wanted: str) -> Path:
    """The path of a regular file. DescriptionError, with the `wanted` kind, if it is not one."""
    file = as_path(path)
    if why := why_no_file(file):
        raise refusal("file-unreadable", Place(str(file)), why, f"give {wanted}")
    return file


def read_text(path: Path, most: int = MAX_BYTES) -> str:
    """The file's text, by `decoded`.

    Raises DescriptionError for a file of more than `most` bytes or an unreadable one.
    """
    note_file(path)
    try:
        data = read_bounded(path, most)
    except (OSError, ValueError) as error:
        large = getattr(error, "errno", None) == errno.EFBIG
        remedy = "is it the right file?" if large else "give the path of a readable file"
        raise refusal("file-unreadable", Place(str(path)), why_no_file(path, error), remedy) from error
    if other := kind_of(data):
        raise refusal("file-unreadable", Place(str(path)), f"it is {other[0]}", other[1])
    return decoded(data)


def decoded(data: bytes) -> str:
    """Decode bytes: UTF-8, UTF-16 or UTF-32, each with or without a byte-order mark, else Latin-1."""
    try:
        return data.decode(json.detect_encoding(data))
    except UnicodeDecodeError:
        return data.decode("latin-1")


def parse_xml(text: str, reading: Reading) -> ET.Element:
    """The root element of `text`. Each element's line goes into `reading.lines`.

    The parser ignores namespaces, so undeclared prefixes, as in `<gazebo>` blocks, do not matter. A document type is
    refused, because it may bring entities and external files.
    """
    builder = ET.TreeBuilder()
    parser = expat.ParserCreate("utf-8")
    parser.buffer_text = True

    open_tags: list[str] = []

    def refused_here(what: str, remedy: str) -> DescriptionError:
        return refusal("xml-malformed", replace(reading.whole, line=parser.CurrentLineNumber), what, remedy)

    def start(tag: str, attributes: dict[str, str]) -> None:
        open_tags.append(tag)
        if len(open_tags) > MAX_NESTING:
            raise refused_here(f"elements are nested more than {MAX_NESTING} deep", "is it a robot's description?")
        reading.lines[builder.start(tag, attributes)] = parser.CurrentLineNumber

    def end(tag: str) -> None:
        open_tags.pop()
        builder.end(tag)

    def refuse(name: str, *_: object) -> None:
        raise refused_here(f"a document type (<!DOCTYPE {name}>) is not allowed", "remove it")

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CharacterDataHandler = builder.data
    parser.StartDoctypeDeclHandler = refuse
    try:
        # With the mark: without it expat takes a text with a null character for UTF-16, and swallows parts of it.
        parser.Parse(text.encode("utf-8-sig", "surrogatepass"), True)
    except expat.ExpatError as error:
        what = f"not well-formed XML: {expat.ErrorString(error.code)}" if text.strip() else "the file is empty"
        place = replace(reading.whole, line=error.lineno if reading.show_lines else None)
        remedy = "is it a URDF, xacro or MJCF file, and whole?"
        if open_tags and error.code == errors.codes[errors.XML_ERROR_NO_ELEMENTS]:
            what, remedy = f"the file ends inside <{open_tags[-1]}>", "add the end tags, or the part that is lost"
        elif text.lstrip().startswith("<"):
            remedy = "write one root element, &amp; for & and &lt; for < in values, and quotes round these"
        raise refusal("xml-malformed", place, what, remedy) from error
    return builder.close()


class Refused(Exception):  # noqa: N818 - it is no error yet: its place is not known here
    """What a description may not do."""

    def __init__(self, code: str, what: str, remedy: str = "") -> None:
        super().__init__(what)
        self.code, self.what, self.remedy = code, what, remedy


def read_inside(name: str, packages: PackageIndex) -> tuple[Path, str]:
    """The real path and the text of the regular file `name`.

    Refused outside the folders, whether or not there is a file. OSError if there is none inside.
    """
    try:
        note_file(Path(name))
        real = real_inside(name, packages)  # a device is not even opened
        data = read_bounded(real, MAX_BYTES)
        if other := kind_of(data):
            raise Refused("file-unreadable", f"{name}: it is {other[0]}", other[1])
        return real, decoded(data)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.EFBIG):
            raise
        what, remedy = f"{name}: {error.strerror}", "include regular files of a description"
        raise Refused("file-unreadable", what, remedy) from error


def real_inside(name: str | Path, packages: PackageIndex) -> Path:
    """The path without links. Refused if it lies outside the folders."""
    real = Path(os.path.realpath(name))
    if not packages.allows(real):
        what = f"{real} lies outside the folders that may be read: its own package, and those found by their name"
        raise Refused("file-outside-packages", what, Text("pass {folder}", folder=package_folder("its package")))
    return real
