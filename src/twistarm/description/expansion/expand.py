"""xacro to URDF text without ROS: files confined, expressions checked, arguments listed, every error in one line."""

from __future__ import annotations

import contextlib
import io
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ...errors import InputError, TwistarmError, closest
from ..document import read_text
from ..findings import Finding, Place, finding
from ..packages import PackageIndex
from .errors import current_place, explain
from .hooks import Expansion
from .module import import_xacro

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
    _refuse_unknown_arguments(expansion)
    return text, tuple(_package_finding(path, name, packages) for name in sorted(expansion.unknown_packages))


def xacro_arguments(
    path: Path, packages: PackageIndex, arguments: Mapping[str, object] | None = None
) -> dict[str, str | None]:
    """Every argument that `path` takes, with what it includes: {name: default}, None where one must be given.

    What it includes may hang on `arguments`; those it does not take do no harm. Raises DescriptionError as
    `expand_xacro` does.
    """
    return _expanded(path, packages, arguments or {})[1].found.all()


def _expanded(path: Path, packages: PackageIndex, arguments: Mapping[str, object]) -> tuple[str, Expansion]:
    xacro = import_xacro()
    given = {name: _argument_text(value) for name, value in arguments.items()}
    with _LOCK:
        expansion = Expansion(xacro, path, packages, given)
        with (
            _replaced(xacro, expansion.for_xacro()),
            _replaced(xacro.substitution_args, expansion.for_substitution()),
            contextlib.redirect_stderr(io.StringIO()),
        ):
            try:
                text = str(xacro.process_file(str(path), mappings=dict(given), verbosity=0).toxml())
            except Exception as error:
                raise explain(error, expansion, current_place(xacro, path)) from error
    return text, expansion


def is_xacro(path: Path) -> bool:
    """Whether a file must be expanded first: by its name, or because a xacro element stands in it."""
    return path.suffix == ".xacro" or "<xacro:" in read_text(path)


@contextlib.contextmanager
def _replaced(module: Any, values: Mapping[str, Any]) -> Iterator[None]:
    """The attributes of a module replaced while the context lasts; TwistarmError if it does not have them all."""
    missing = [name for name in values if not hasattr(module, name)]
    if missing:
        lacks = f"this xacro ({module.__file__}) has no {', '.join(missing)} and cannot be confined"
        raise TwistarmError(f"{lacks}; pip install xacro==2.1.1")
    original = {name: getattr(module, name) for name in values}
    try:
        for name, value in values.items():
            setattr(module, name, value)
        yield
    finally:
        for name, value in original.items():
            setattr(module, name, value)


def _argument_text(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _refuse_unknown_arguments(expansion: Expansion) -> None:
    known = expansion.found.all()
    for name in expansion.given:
        if name not in known:
            raise InputError(
                f"{expansion.path.name} has no xacro argument {name!r}{closest(name, known)} "
                f"(its arguments: {', '.join(known) or 'none'})"
            )


def _package_finding(path: Path, package: str, packages: PackageIndex) -> Finding:
    return finding(
        "package-not-found",
        Place(path.name),
        f"$(find {package}): package not found (searched {packages.searched()}); nothing the kinematics needs uses it",
        f"pass package_dirs=[folder that holds {package}] if its files matter",
    )
