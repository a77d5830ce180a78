"""The mutators by kind, and a mutant from a seed: the same seed gives the same bytes."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import PurePath
from random import Random

from . import texts, trees

ET.register_namespace("xacro", "http://www.ros.org/wiki/xacro")

TREES: dict[str, tuple[Callable[[ET.Element, Random], None], ...]] = {
    "structure": trees.STRUCTURE,
    "numbers": trees.NUMBERS,
    "names": trees.NAMES,
}
TEXTS: dict[str, tuple[Callable[[str, Random], bytes], ...]] = {
    "encodings": texts.ENCODINGS,
    "truncation": texts.TRUNCATION,
    "markup": texts.MARKUP,
    "xacro": texts.XACRO,
    "tables": texts.TABLES,
}

KINDS: dict[str, tuple[tuple[str, int], ...]] = {
    ".urdf": (("structure", 6), ("numbers", 5), ("names", 3), ("encodings", 2), ("truncation", 3), ("markup", 1)),
    ".xacro": (("structure", 4), ("numbers", 3), ("names", 2), ("encodings", 1), ("truncation", 2), ("markup", 1),
               ("xacro", 6)),
}  # fmt: skip
KINDS[".srdf"] = KINDS[".urdf"]  # Kinds of mutation by kind of file, each with how often it is drawn.
TABLES = (("tables", 6), ("encodings", 1), ("truncation", 3))  # The same for TOML and YAML.


def mutate(data: bytes, file: PurePath, rng: Random) -> tuple[str, bytes]:
    """The kind of mutation and the mutant of a file's bytes: one mutation mostly, several at times."""
    kinds = dict(KINDS.get(file.suffix, TABLES))
    (kind,) = rng.choices(list(kinds), list(kinds.values()))
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        data = once(data, kind, rng)
    if rng.random() < 0.15:
        (second,) = rng.choices(list(kinds), list(kinds.values()))
        data = once(data, second, rng)
    return kind, data.replace(b"@FILE@", file.name.encode())


def once(data: bytes, kind: str, rng: Random) -> bytes:
    """The data after one mutation of a kind."""
    if kind in TEXTS:
        return rng.choice(TEXTS[kind])(data.decode("utf-8", "replace"), rng)
    try:
        root = ET.fromstring(data)
        rng.choice(TREES[kind])(root, rng)
        # Control characters that XML forbids stand in it as they are.
        text = ET.tostring(root, encoding="unicode")
        return b'<?xml version="1.0"?>\n' + text.encode("utf-8", "surrogatepass")
    except (ET.ParseError, ValueError, LookupError, RecursionError):
        return data  # no tree any more, after a mutation before
