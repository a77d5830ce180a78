"""A file's elements as the document that xacro works on, and its nodes exchanged at the cost of their number."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from itertools import pairwise
from typing import Any
from xml.dom import minidom

from ..document import Reading

_DECLARATION = "xmlns:"


def xacro_document(root: ET.Element, reading: Reading) -> minidom.Document:
    """Elements, attributes and texts; comments and processing instructions stay behind with the file.

    Raises DescriptionError for a prefix that is not declared, as XML's readers do.
    """
    document = minidom.Document()
    _append(document, root, frozenset({"xml", "xmlns"}), document, reading)
    return document


def _append(parent: Any, source: ET.Element, prefixes: frozenset[str], document: Any, reading: Reading) -> None:
    declared = [name[len(_DECLARATION) :] for name in source.attrib if name.startswith(_DECLARATION)]
    prefixes = prefixes.union(declared) if declared else prefixes
    element = document.createElement(source.tag)
    for name, value in source.attrib.items():
        element.setAttribute(name, value)
    for name in (source.tag, *source.attrib):
        if ":" in name and name.partition(":")[0] not in prefixes:
            what = 'a tag\'s prefix is not declared: add xmlns:xacro="http://www.ros.org/wiki/xacro" to <robot>'
            raise reading.error(source, "xml-malformed", what)
    parent.appendChild(element)
    if source.text:
        element.appendChild(document.createTextNode(source.text))
    for child in source:
        _append(element, child, prefixes, document, reading)
        if child.tail:
            element.appendChild(document.createTextNode(child.tail))


def replace(node: Any, new: Iterable[Any], content_only: bool) -> None:
    """Put the nodes `new`, or only what they hold, in the place of `node`.

    xacro's own `replace_node` looks through all siblings for each node that it moves.
    """
    parent = node.parentNode
    moved = [child for part in new for child in (list(part.childNodes) if content_only else [part])]
    for part in new:
        if content_only:
            del part.childNodes[:]
        elif part.parentNode is not None:
            part.parentNode.removeChild(part)
    siblings = parent.childNodes
    place = siblings.index(node)
    before, after = node.previousSibling, node.nextSibling
    siblings[place : place + 1] = moved
    row = [before, *moved, after]
    for left, right in pairwise(row):
        if left is not None:
            left.nextSibling = right
        if right is not None:
            right.previousSibling = left
    for child in moved:
        child.parentNode = parent
    node.parentNode = node.previousSibling = node.nextSibling = None
