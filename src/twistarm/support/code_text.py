"""Texts of other languages: templates in files of their own; names, numbers and texts as C and C++ write them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from string import Template

import numpy as np

_RESERVED = """
    alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t char32_t class
    co_await co_return co_yield compl concept const consteval constexpr constinit const_cast continue decltype default
    delete do double dynamic_cast else enum explicit export extern false float for friend goto i386 if inline int linux
    long main mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected public register
    reinterpret_cast requires return short signed sizeof static static_assert static_cast std struct switch template
    this thread_local throw true try twistarm typedef typeid typename union unix unsigned using virtual void volatile
    wchar_t while xor xor_eq
    abs acos asin atan BUFSIZ ceil clock close cos div EOF errno exit exp floor gamma index INFINITY j0 j1 jn link log
    M_PI NAN NULL open pipe pow raise read remove rename round select signal sin sqrt stderr stdin stdout tan time write
    y0 y1 yn
"""
"""What no namespace can be called: C++20's keywords, `main`, `std`, our own, the macros of GCC's dialects, and short
names of the C library."""

_PLAIN = re.compile(r"[A-Za-z0-9 _.,:;+\-=@#%&()\[\]<>{}|~^!$']")


def filled(template: Path, **values: object) -> str:
    """The text of a file, with a value in place of each `$name`. Every name needs one."""
    return Template(template.read_text(encoding="utf-8")).substitute(values)


def identifier_of(name: str, kind: str) -> str:
    """An identifier for a name: invalid characters become one underscore; a reserved word gets `kind` in front."""
    identifier = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_") or kind
    return f"{kind}_{identifier}" if identifier[0].isdigit() or identifier in _RESERVED.split() else identifier


def c_number(value: float) -> str:
    """A number that reads back as the same double; `infinite` is the text of infinity."""
    return repr(float(value)) if np.isfinite(value) else "-infinite" if value < 0 else "infinite"


def cpp_number(value: float) -> str:
    """A number of the template's type T."""
    return f"T({c_number(value)})"


def cpp_numbers(values: Iterable[float]) -> str:
    """Numbers of the template's type T, in braces."""
    return "{" + ", ".join(map(cpp_number, values)) + "}"


def c_string(text: str) -> str:
    """A C string of plain characters that cannot end a comment; others are octal escapes of their UTF-8."""
    octal = ("".join(f"\\{byte:03o}" for byte in c.encode("utf-8", "surrogatepass")) for c in text)
    return '"' + "".join(c if _PLAIN.fullmatch(c) else code for c, code in zip(text, octal, strict=True)) + '"'


def c_strings(texts: Iterable[str]) -> str:
    """C strings, one after the other."""
    return ", ".join(map(c_string, texts))
