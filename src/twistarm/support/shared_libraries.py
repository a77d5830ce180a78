"""A wheel's own shared libraries, loaded before the loader can find others of the same name."""

from __future__ import annotations

import ctypes
import mmap
import os
import re
import sys
from pathlib import Path

SEARCHED_FIRST = "DYLD_LIBRARY_PATH" if sys.platform == "darwin" else "LD_LIBRARY_PATH"
"""The variable that the loader obeys before a wheel's own run path."""

_PREFIX = "cmeel.prefix"
"""Wheels of C++ projects install themselves below this folder of site-packages, as below /usr."""

_NAME = re.compile(rb"lib[\w.+-]+(?=\0)")
"""A library's name as it stands in the string table of whatever is linked against it."""


def load_own(package: Path) -> None:
    """Load by absolute path what the wheel of `package` (its __init__.py) links against, where others stand before it.

    The loader takes a library that is loaded already, by its name, before it searches any folder. What another one
    needs is loaded first, or loading that one would fetch the stranger. macOS puts DYLD_LIBRARY_PATH before absolute
    paths too: there the import succeeds with what it finds, or it fails and `shadowed` names the cause.
    """
    if sys.platform != "darwin" and _strangers(package):
        for library in _linked(package):
            ctypes.CDLL(str(library))


def shadowed(package: Path) -> tuple[tuple[Path, Path], ...]:
    """(stranger, own) for each library of the wheel that the loader would find elsewhere first."""
    strangers = _strangers(package)
    return tuple((strangers[own.name], own) for own in _linked(package) if own.name in strangers) if strangers else ()


def is_own(package: Path) -> bool:
    """Whether `package` belongs to a wheel that brings its own shared libraries."""
    return _PREFIX in package.parts


def _strangers(package: Path) -> dict[str, Path]:
    """What the loader would find first for each name in the wheel's folder, where that is another file."""
    folders = _searched_first()
    if not folders or not is_own(package):
        return {}
    own, found = _names(_libraries(package)), dict[str, Path]()
    for folder in folders:
        for name in own & _names(folder):
            found.setdefault(name, folder / name)
    return {
        name: file
        for name, file in found.items()
        if os.path.realpath(file) != os.path.realpath(_libraries(package) / name)
    }


def _searched_first() -> list[Path]:
    """The variable's folders; an empty one is the current folder, as the loader has it."""
    value = os.environ.get(SEARCHED_FIRST, "")
    return [Path(folder or os.curdir) for folder in re.split("[:;]", value)] if value else []


def _names(folder: Path) -> set[str]:
    """The libraries in a folder."""
    try:
        return {name for name in os.listdir(folder) if name.startswith("lib")}
    except OSError:  # a folder that is not there, or is not ours to read, holds nothing
        return set()


def _libraries(package: Path) -> Path:
    """`<prefix>/lib` for `<prefix>/lib/python3.x/site-packages/<package>/__init__.py`."""
    return package.parents[3]


def _linked(package: Path) -> list[Path]:
    """Every library of the wheel that the package's extension modules link against, each after those it needs."""
    folder = _libraries(package)
    own = _names(folder)
    seen: set[str] = set()
    order: list[Path] = []

    def visit(file: Path) -> None:
        for name in sorted((_named_in(file) & own) - seen):
            if name not in seen:  # a deeper visit may have met it meanwhile
                seen.add(name)
                visit(folder / name)
                order.append(folder / name)

    for extension in sorted(package.parent.glob("*.so")):
        visit(extension)
    return order


def _named_in(file: Path) -> set[str]:
    with file.open("rb") as binary, mmap.mmap(binary.fileno(), 0, access=mmap.ACCESS_READ) as content:
        return {name.decode() for name in _NAME.findall(content)}
