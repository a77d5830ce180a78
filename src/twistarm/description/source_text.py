"""A description's text with the place of each element, for edits that keep comments and formatting."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from typing import NamedTuple
from xml.parsers import expat

_START_TAG = re.compile(rb"<(?:[^>\"']|\"[^\"]*\"|'[^']*')*>")  # A start tag. A > may stand inside quotes.


class Span(NamedTuple):
    """Byte offsets of an element: its first, the end of its start tag, and its end."""

    start: int
    opened: int
    end: int


class SourceText:
    """A well-formed XML text, its elements, and edits to it.

    `robot` is the root element before any edit. `edited` makes all collected edits at once. Each element takes one
    change of its start tag.
    """

    def __init__(self, text: str) -> None:
        self._data = text.encode("utf-8", "surrogatepass")
        self._spans: dict[ET.Element, Span] = {}
        self._edits: dict[tuple[int, int], bytes] = {}
        self.robot = self._parse()

    def set(self, element: ET.Element, **attributes: str | None) -> None:
        """Give the element these attributes; None removes one. The others stay as written."""
        span = self._spans[element]
        tag = self._data[span.start : span.opened].decode("utf-8")
        for name, value in attributes.items():
            tag = _with_attribute(tag, name, value)
        self._edits[span.start, span.opened] = tag.encode("utf-8")

    def insert(self, element: ET.Element, text: str) -> None:
        """Put a text behind the start tag of an element that has an end tag."""
        opened = self._spans[element].opened
        self._edits[opened, opened] = text.encode("utf-8")

    def remove(self, element: ET.Element) -> None:
        """Take the element out, with the line it stands on alone."""
        start, _, end = self._spans[element]
        before = re.search(rb"\n[ \t]*\Z", self._data[:start])
        after = re.match(rb"[ \t\r]*(?=\n)", self._data[end:])
        if before and after:
            start, end = before.start(), end + after.end()
        self._edits[start, end] = b""

    def edited(self) -> str:
        """The text with every edit made, declared as UTF-8."""
        data = self._data
        for (start, end), replacement in sorted(self._edits.items(), reverse=True):
            data = data[:start] + replacement + data[end:]
        text = data.decode("utf-8", "surrogatepass")
        return re.sub(r"\A(\s*<\?xml[^>]*?encoding\s*=\s*)([\"'])[^\"']*\2", r"\1\2utf-8\2", text)

    def _parse(self) -> ET.Element:
        builder = ET.TreeBuilder()
        parser = expat.ParserCreate("utf-8")
        opened: list[tuple[ET.Element, int, int]] = []

        def start(tag: str, attributes: dict[str, str]) -> None:
            at = parser.CurrentByteIndex
            written = _START_TAG.match(self._data, at)
            assert written is not None, "expat has read it"
            opened.append((builder.start(tag, attributes), at, written.end()))

        def end(tag: str) -> None:
            element, at, tag_end = opened.pop()
            empty = self._data[tag_end - 2 : tag_end] == b"/>"
            close = tag_end if empty else self._data.index(b">", parser.CurrentByteIndex) + 1
            self._spans[element] = Span(at, tag_end, close)
            builder.end(tag)

        parser.StartElementHandler = start
        parser.EndElementHandler = end
        parser.CharacterDataHandler = builder.data
        parser.Parse(self._data, True)
        return builder.close()


def _with_attribute(tag: str, name: str, value: str | None) -> str:
    from xml.sax.saxutils import escape  # brings urllib and http with it: 15 ms of every start

    pattern = re.compile(rf"(\s+){re.escape(name)}\s*=\s*(?:\"[^\"]*\"|'[^']*')")
    if value is None:
        return pattern.sub("", tag, count=1)
    given = f'{name}="{escape(value, {chr(34): "&quot;"})}"'
    if pattern.search(tag):
        return pattern.sub(lambda found: found.group(1) + given, tag, count=1)
    body, closing = (tag[:-2], "/>") if tag.endswith("/>") else (tag[:-1], ">")
    return f"{body.rstrip()} {given}{closing}"
