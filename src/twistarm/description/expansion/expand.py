"""xacro to URDF text without ROS: one file, with what it includes, at a time."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from pathlib import Path

from ..document import read_text
from ..findings import Finding
from ..packages import PackageIndex
from .errors import current_place, explain, package_finding, unknown_argument
from .hooks import Expansion
from .module import hooked, own_xacro

_LOCK = threading.Lock()
"""xacro keeps arguments, file stack and verbosity in module globals: one expansion at a time."""


def expand_xacro(
    path: Path, packages: PackageIndex, arguments: Mapping[str, object] | None = None
) -> tuple[str, tuple[Finding, ...]]:
    """The URDF text that `path` expands to, and what was noticed on the way.

    Nothing outside the packages is opened (`confinement`), expressions reach nothing but their own values
    (`expressions`), and the work is counted (`work`). A package that is not found fails only where an
    include or a YAML load needs it. Raises DescriptionError with the file, the cause and the remedy; a missing
    argument is answered with the list of all arguments.
    """
    text, expansion = _expanded(path, packages, arguments or {})
    known = expansion.found.all()
    for name in expansion.given:
        if name not in known:
            raise unknown_argument(name, path, known)
    return text, tuple(package_finding(path, name, packages) for name in sorted(expansion.unknown_packages))


def xacro_arguments(
    path: Path, packages: PackageIndex, arguments: Mapping[str, object] | None = None
) -> dict[str, str | None]:
    """Every argument that `path` takes, with what it includes: {name: default}, None where one must be given.

    What it includes may hang on `arguments`; those it does not take do no harm. Raises DescriptionError as
    `expand_xacro` does.
    """
    return _expanded(path, packages, arguments or {})[1].found.all()


def is_xacro(path: Path) -> bool:
    """Whether a file must be expanded first: by its name, or because a xacro element stands in it."""
    return path.suffix == ".xacro" or "<xacro:" in read_text(path)


def _expanded(path: Path, packages: PackageIndex, arguments: Mapping[str, object]) -> tuple[str, Expansion]:
    given = {name: _argument_text(value) for name, value in arguments.items()}
    with _LOCK:
        xacro = own_xacro()
        expansion = Expansion(xacro, path, packages, given)
        with (
            hooked(xacro, expansion.for_xacro()),
            hooked(xacro.substitution_args, expansion.for_substitution()),
        ):
            try:
                return str(xacro.process_file(str(path), mappings=dict(given), verbosity=0).toxml()), expansion
            except Exception as error:
                raise explain(error, expansion, current_place(xacro, path)) from error


def _argument_text(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
