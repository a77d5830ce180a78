"""xacro to URDF text without ROS, one file with its includes at a time."""

from __future__ import annotations

import functools
import sys
import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any, NamedTuple

from ...support.errors import TwistarmError
from ...support.wheels import Wheel, load
from ..document import read_text
from ..findings import Finding
from ..packages import PackageIndex
from .errors import explain, package_finding, unknown_argument
from .hooks import HERE, PACKAGE, Expansion
from .left_out import blamed

_DECLARATION = '<?xml version="1.0" ?>'

_WHEEL = Wheel("xacro", "xacro", has="process_file", oldest="2.1")
"""ROS 2's is the same code and serves; ROS 1's lacks what `hooked` replaces."""

_NAME = f"{__package__}._xacro"

_LOCK = threading.Lock()
"""xacro keeps arguments, file stack and verbosity in module globals: one expansion at a time."""


class Expanded(NamedTuple):
    """The URDF text, findings, and every argument that the file and its includes take, {name: default}.

    A required argument has the default None.
    """

    text: str
    findings: tuple[Finding, ...]
    arguments: dict[str, str | None]


def expand_xacro(
    path: Path,
    packages: PackageIndex,
    arguments: Mapping[str, object] | None = None,
    ignore_packages: Iterable[str] = (),
    env_vars: Iterable[str] = (),
) -> Expanded:
    """Expand the file at `path`.

    Files outside the packages stay closed (`confinement`). Expressions only compute (`expressions`). They read only the
    environment variables in `env_vars` (`evaluation`). The work is counted (`work`). A missing package is an error
    only if an include or a YAML load needs it. Parts of the packages in `ignore_packages` are left out (`left_out`).
    Raises DescriptionError with the file, the cause and the remedy.
    """
    given = {name: _argument_text(value) for name, value in (arguments or {}).items()}
    with _LOCK:
        xacro = own_xacro()
        expansion = Expansion(xacro, path, packages, given, ignore_packages, env_vars)
        with hooked(xacro, expansion.for_xacro()):
            try:
                document = xacro.process_file(str(path), mappings=dict(given), verbosity=0)
                text = _portable(document.documentElement.toxml())
            except Exception as error:
                explained = explain(error, expansion, expansion.place)
                raise blamed(explained, expansion.left_out.findings(())) from error
    known = expansion.found.all()
    for name in given:
        if name not in known:
            raise unknown_argument(name, path, known)
    unknown = (package_finding(path, name) for name in sorted(expansion.unknown_packages))
    noted = (*unknown, *expansion.environment.findings(), *expansion.left_out.findings(expansion.found.packages))
    return Expanded(text, noted, known)


def is_xacro(path: Path) -> bool:
    """Whether a file needs expansion, by its name or by a xacro element in it."""
    return path.suffix == ".xacro" or "<xacro:" in read_text(path)


def _portable(robot: str) -> str:
    """The text without xacro's banner, which shows the file's folder, with paths that any reader of URDF takes.

    `file://$(find arm)/…` is the package's file. Paths beside the description are relative to it.
    """
    return _DECLARATION + robot.replace(f"file://{PACKAGE}", PACKAGE).replace(HERE, "")


def _argument_text(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


@functools.cache
def own_xacro() -> Any:
    """A private copy of PyPI's xacro, also in a ROS shell with another one, loaded once.

    xacro keeps its state in module globals, and the confinement replaces functions of it. The program's `xacro` stays
    unchanged. Raises TwistarmError in one line, with the remedy, if xacro cannot be used.
    """
    file = Path(load(_WHEEL).__file__)
    spec = spec_from_file_location(_NAME, file, submodule_search_locations=[str(file.parent)])
    if spec is None or spec.loader is None:
        raise TwistarmError(f"{file} cannot be loaded; pip install xacro==2.1.1")
    copy = sys.modules[_NAME] = module_from_spec(spec)  # where its own imports look for it
    spec.loader.exec_module(copy)
    import_module(f"{_NAME}.substitution_args")
    return copy


@contextmanager
def hooked(module: Any, values: Mapping[str, Any]) -> Iterator[None]:
    """Replace attributes of a module of the copy for a while. Raises TwistarmError if one is missing."""
    missing = [name for name in values if not hasattr(module, name)]
    if missing:
        lacks = f"this xacro ({module.__file__}) has no {', '.join(missing)} and cannot be confined"
        raise TwistarmError(f"{lacks}; pip install xacro==2.1.1")
    original = {name: getattr(module, name) for name in values}
    vars(module).update(values)
    try:
        yield
    finally:
        vars(module).update(original)
