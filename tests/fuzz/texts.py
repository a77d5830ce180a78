"""Mutations of a text or its bytes: encodings, truncation, lines, document types, xacro expressions, TOML, YAML."""

from __future__ import annotations

import re
from collections.abc import Sequence
from random import Random

from . import hostile

DECLARED = ("utf-8", "UTF-16", "latin-1", "ascii", "cp1252", "utf-7", "nonsense", "", "utf-8\n", "EBCDIC-CP-US")

ENTRIES = ("[tool]", "[poses.ready]", "[limits]", "[locked_joints]", "locked = {}", "tool = 1", "name = 1", "tip = ''",
           "[[limits]]", "[a.b]")  # fmt: skip


def _declared(text: str, encoding: str) -> str:
    body = re.sub(r"^\s*<\?xml[^>]*\?>\s*", "", text)
    return f'<?xml version="1.0" encoding="{encoding}"?>\n{body}'


def _anywhere(text: str, rng: Random) -> int:
    return rng.randrange(len(text) + 1)


def _exchanged(text: str, rng: Random, pattern: str, news: Sequence[str]) -> bytes:
    """With one of `news` in the place of one match; as it is where nothing matches."""
    places = list(re.finditer(pattern, text))
    start, end = rng.choice(places).span() if places else (0, 0)
    return (text[:start] + rng.choice(news) * bool(places) + text[end:]).encode()


# -- encodings ---------------------------------------------------------------------------------------------------------


def another_encoding(text: str, rng: Random) -> bytes:
    encoding = rng.choice(
        ("utf-16", "utf-16-le", "utf-16-be", "utf-32", "utf-8-sig", "latin-1", "cp1252", "utf-7", "cp037")
    )
    text = text.replace("_link", rng.choice(("_link", "_l\u00efnk")))
    return text.encode(encoding, "replace")


def declaration(text: str, rng: Random) -> bytes:
    encoding = rng.choice(("utf-8", "utf-16", "latin-1"))
    return _declared(text.replace("_link", "_l\u00efnk"), rng.choice(DECLARED)).encode(encoding, "replace")


def line_ends(text: str, rng: Random) -> bytes:
    return text.replace("\n", rng.choice(("\r\n", "\r", "\n\r", "\x85", "\u2028", " ", ""))).encode()


# -- truncation, bytes and lines ---------------------------------------------------------------------------------------


def truncate(text: str, rng: Random) -> bytes:
    data = text.encode()
    return data[: rng.choice((0, 1, rng.randrange(len(data) + 1), rng.randrange(len(data) + 1), len(data) - 1))]


def flip(text: str, rng: Random) -> bytes:
    data = bytearray(text.encode())
    for _ in range(rng.choice((1, 1, 2, 5, 30)) if data else 0):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(data)


def delete_lines(text: str, rng: Random) -> bytes:
    lines = text.split("\n")
    at = rng.randrange(len(lines))
    return "\n".join(lines[:at] + lines[at + rng.choice((1, 1, 3, 10)) :]).encode()


# -- markup: document types, entities, depth ---------------------------------------------------------------------------


def document_type(text: str, rng: Random) -> bytes:
    body = re.sub(r"^\s*<\?xml[^>]*\?>\s*", "", text)
    return (rng.choice(hostile.DOCUMENT_TYPES) + body.replace("0.", rng.choice(("0.", "&e;")), 1)).encode()


def entity(text: str, rng: Random) -> bytes:
    places = [match.end() for match in re.finditer(r'="', text)]
    at = rng.choice(places) if places and rng.random() < 0.8 else _anywhere(text, rng)
    return (text[:at] + rng.choice(hostile.ENTITIES) + text[at:]).encode()


def deep(text: str, rng: Random) -> bytes:
    """Elements nested without end, in some element."""
    places = [match.end() for match in re.finditer(r"<(?:robot|link|joint|limit)[^>]*[^/]>", text)]
    at = rng.choice(places) if places else 0
    depth = rng.choice((101, 1000, 20000))
    return (text[:at] + "<a>" * depth + "</a>" * depth + text[at:]).encode()


# -- xacro -------------------------------------------------------------------------------------------------------------


def expression(text: str, rng: Random) -> bytes:
    """An expression, or the value of some attribute, exchanged."""
    computed = r"\$\{[^}]*\}|\$\([^)]*\)"
    pattern = computed if rng.random() < 0.7 and re.search(computed, text) else r'(?<==")[^"]*(?=")'
    news = [new.replace("<", "&lt;").replace("\n", "&#10;") for new in hostile.EXPRESSIONS]
    return _exchanged(text, rng, pattern, news)


def inside_an_expression(text: str, rng: Random) -> bytes:
    places = list(re.finditer(r"\$\{[^}]+\}", text))
    if not places:
        return text.encode()
    start, end = rng.choice(places).span()
    at = rng.randrange(start + 2, end)
    piece = rng.choice(("", "+", "*", "(", ")", ".", "'", " ", "0", "**", "[", "{", "//", "__", "not ", "\\"))
    return (text[:at] + piece + text[at + rng.randrange(2) :]).encode()


def xacro_element(text: str, rng: Random) -> bytes:
    places = [match.end() for match in re.finditer(r"<robot[^>]*>|/>|</(?:link|joint|xacro:macro)>", text)]
    at = rng.choice(places) if places else 0
    return (text[:at] + rng.choice(hostile.ELEMENTS) + text[at:]).encode()


def namespace(text: str, rng: Random) -> bytes:
    return re.sub(
        r'xmlns:xacro="[^"]*"', rng.choice(("", 'xmlns:xacro=""', 'xmlns:xacro="http://x"', 'xmlns="http://x"')), text
    ).encode()


# -- TOML and YAML -----------------------------------------------------------------------------------------------------


def value(text: str, rng: Random) -> bytes:
    """What stands after an equals sign or a colon, exchanged."""
    return _exchanged(text, rng, r"(?<=[=:] )[^\s#,}\]]+", hostile.TABLE_VALUES)


def key(text: str, rng: Random) -> bytes:
    pattern = r"[A-Za-z_]\w*(?=[\w.]*\s*[=:\]])"
    others = ('""', '"a b"', "x", "__class__", "a.b.c", "\u00e4")
    return _exchanged(text, rng, pattern, (*re.findall(pattern, text), *others))


def entry(text: str, rng: Random) -> bytes:
    line = rng.choice(ENTRIES)
    lines = text.split("\n")
    more = rng.choice(("", f"x = {rng.choice(hostile.TABLE_VALUES)}"))
    lines.insert(rng.randrange(len(lines) + 1), f"{line}\n{more}")
    return "\n".join(lines).encode()


ENCODINGS = (another_encoding, declaration, line_ends)
TRUNCATION = (truncate, flip, delete_lines)
MARKUP = (document_type, document_type, entity, entity, entity, deep)
XACRO = (expression, inside_an_expression, xacro_element, namespace)
TABLES = (value, key, entry, value)
