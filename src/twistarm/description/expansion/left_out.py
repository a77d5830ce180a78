"""Parts left out with the packages in `ignore_packages`, each with a finding."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

from ...support.errors import DescriptionError, closest, listed
from ...support.messages import Argument, Text, joined, package_folder
from ..findings import Finding, Place, finding

LEFT_OUT = "package-left-out"

NEEDED = (
    *("robot", "link", "joint", "parent", "child", "origin", "axis", "limit", "mimic"),
    *("inertial", "mass", "inertia"),
)
"""Elements that the arm is read from. Any other is left out if it needs something that is left out."""


MAY_LACK = (
    *("xacro-failed", "xacro-arguments", "no-robot", "link-undefined", "not-a-tree", "mimic-unusable"),
    *("no-chain", "no-tip"),
)
"""Errors that a part left out may cause."""


SHOWN = 3
"""Most parts left out that an error names."""


@dataclass
class LeftOut:
    """The packages done without, and the parts left out so far."""

    packages: tuple[str, ...]
    file: Path
    _parts: dict[str, Finding] = field(default_factory=dict)
    _folders: dict[Path, str] = field(default_factory=dict)
    _used: set[str] = field(default_factory=set)

    def __bool__(self) -> bool:
        return bool(self._parts)

    def learn(self, package: str, folder: str) -> None:
        """Remember where `$(find package)` leads."""
        if package in self.packages:
            self._folders[Path(folder)] = package

    def package_of(self, name: str) -> str | None:
        """The package done without that holds a file, by the folder found for it or by a folder of its name."""
        file = Path(name)
        found = (package for folder, package in self._folders.items() if file.is_relative_to(folder))
        way = Path(os.path.relpath(file, self.file.parent)).parts if self.packages else ()
        return next(found, None) or next((package for package in self.packages if package in way), None)

    def leave_out(self, place: Place, what: str, package: str = "") -> None:
        """Note a part that is left out, as `what` tells in words, and the package that it belongs to."""
        self._used.add(package)
        remedy = Text(
            "if it matters, pass {folder} instead of {without}",
            folder=package_folder(listed(self.packages)),
            without=Argument("ignore_packages", None),
        )
        short = replace(place, file=os.path.basename(place.file))
        self._parts.setdefault(what, finding(LEFT_OUT, short, what, remedy))

    def findings(self, named: Iterable[str]) -> tuple[Finding, ...]:
        """One for each part left out and for each package without any. `named` are the packages that the files name."""
        idle = (package for package in self.packages if package not in self._used)
        return (*self._parts.values(), *(not_used(package, self.file, named) for package in idle))


def not_used(package: str, file: Path, named: Iterable[str]) -> Finding:
    """The finding for a package without which nothing is left out."""
    names = [name for name in named if name != package]
    what = (
        f"nothing is left out without {package!r}: no file of it is opened; packages named: {listed(names) or 'none'}"
    )
    remedy = Text(
        "correct the name{near}, or take it out of {without}",
        near=closest(package, names),
        without=Argument("ignore_packages", None),
    )
    return finding("package-not-used", Place(file.name), what, remedy)


def blamed(error: DescriptionError, noted: Iterable[Finding]) -> DescriptionError:
    """The error, with what has been left out if that may be what is missing."""
    parts = [one.what for one in noted if one.code == LEFT_OUT]
    if not parts or not any(one.code in MAY_LACK for one in error.findings):
        return error
    more = f" (and {len(parts) - SHOWN} more)" if len(parts) > SHOWN else ""
    missing = f"this may be what is missing: {'; '.join(parts[:SHOWN])}{more}"
    told = joined("; ", [error.message, missing])
    return DescriptionError(told, tuple(dict.fromkeys([*error.findings, *noted])))


@contextmanager
def blaming(noted: Iterable[Finding]) -> Iterator[None]:
    """Raise a DescriptionError within as `blamed`."""
    try:
        yield
    except DescriptionError as error:
        told = blamed(error, noted)
        if told is error:
            raise
        raise told from error
