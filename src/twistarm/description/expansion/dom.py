"""A file's elements as the document that xacro works on, and its nodes exchanged at the cost of their number."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import Any
from xml.dom import XML_NAMESPACE, XMLNS_NAMESPACE, minidom

from ..document import Reading

_DECLARATION = "xmlns:"

XACRO = "http://www.ros.org/wiki/xacro"

Namespaces = Mapping[str, str]
"""The address behind each prefix that is declared."""


def xacro_document(root: ET.Element, reading: Reading) -> minidom.Document:
    """Elements, attributes and texts; comments and processing instructions stay behind with the file.

    Raises DescriptionError for a prefix that is not declared, as XML's readers do.
    """
    document = minidom.Document()
    _append(document, root, {"xml": XML_NAMESPACE, "xmlns": XMLNS_NAMESPACE}, document, reading)
    return document


def _append(parent: Any, source: ET.Element, known: Namespaces, document: Any, reading: Reading) -> None:
    declared = {n[len(_DECLARATION) :]: address for n, address in source.attrib.items() if n.startswith(_DECLARATION)}
    known = {**known, **declared} if declared else known
    for name in (source.tag, *source.attrib):
        if ":" in name and name.partition(":")[0] not in known:
            prefix = name.partition(":")[0]
            address = XACRO if prefix == "xacro" else "…"
            what = f"the prefix of {name!r} is not declared"
            raise reading.error(source, "xml-malformed", what, f'add xmlns:{prefix}="{address}" to <robot>')
    element = document.createElement(source.tag)
    prefixed = False
    for name, value in source.attrib.items():
        # minidom holds attributes by namespace and local name: without one, cad:xyz would take the place of xyz.
        if ":" in name:
            element.setAttributeNS(known[name.partition(":")[0]], name, value)
            prefixed = True
        else:
            element.setAttribute(name, value)
    if prefixed and len(element.attributes) != len(source.attrib):
        what = "an attribute is given twice, by two prefixes of one namespace"
        raise reading.error(source, "xml-malformed", what, "keep one of them")
    parent.appendChild(element)
    if source.text:
        element.appendChild(document.createTextNode(source.text))
    for child in source:
        _append(element, child, known, document, reading)
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
