"""xacro to URDF text without ROS, one file with its includes at a time."""

from __future__ import annotations

import functools
import sys
import threading
from collections.abc import Iterable, Mapping
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any, NamedTuple

from ...support.errors import InputError, TwistarmError, closest
from ...support.interrupts import ending_at_once
from ...support.wheels import Wheel, load
from ..document import read_text
from ..findings import Finding
from ..packages import PackageIndex
from .errors import explain
from .expansion import HERE, PACKAGE, REPLACED, Expansion

_WHEEL = Wheel("xacro", "xacro", has="process_file", oldest="2.1")
"""ROS 2's is the same code and serves; ROS 1's lacks what `Expansion` replaces."""

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

    It reads files of its package and of packages found by their name (`confinement`), and only the environment
    variables in `env_vars`. Its expressions only compute (`expressions`). A missing package is an error only if an
    include or a YAML load needs it. Includes, YAML and macros of the packages in `ignore_packages` are left out.
    Ctrl-C ends the process meanwhile, because one operation of an expression may take any time.

    Raises DescriptionError with the file, the cause and the remedy, and InputError for an argument that the file does
    not take.
    """
    given = {
        name: str(value).lower() if isinstance(value, bool) else str(value) for name, value in (arguments or {}).items()
    }
    with _LOCK:
        xacro = own_xacro()
        expansion = Expansion(xacro, path, packages, given, ignore_packages, env_vars)
        vars(xacro).update(xacro.original | expansion.attributes())
        try:
            with ending_at_once():
                robot = xacro.process_file(str(path), mappings=dict(given), verbosity=0).documentElement.toxml()
        except Exception as error:
            raise explain(error, expansion) from error
    known = expansion.arguments
    for name in given:
        if name not in known:
            allowed = f"its arguments: {', '.join(known) or 'none'}"
            raise InputError(f"{path.name} has no xacro argument {name!r}{closest(name, known)} ({allowed})")
    # Without xacro's banner, which shows the file's folder, and with paths that any reader of URDF takes: those of a
    # package, and for files beside the description relative ones.
    text = '<?xml version="1.0" ?>' + robot.replace(f"file://{PACKAGE}", PACKAGE).replace(HERE, "")
    return Expanded(text, expansion.findings(), known)


def is_xacro(path: Path) -> bool:
    """Whether a file needs expansion, by its name or by a xacro element in it."""
    return path.suffix == ".xacro" or "<xacro:" in read_text(path)


@functools.cache
def own_xacro() -> Any:
    """A private copy of PyPI's xacro, also in a ROS shell with another one, loaded once.

    xacro keeps its state in module globals, and an expansion replaces functions of it. The program's `xacro` stays
    unchanged. Raises TwistarmError in one line, with the remedy, if xacro cannot be used.
    """
    file = Path(load(_WHEEL).__file__)
    spec = spec_from_file_location(_NAME, file, submodule_search_locations=[str(file.parent)])
    if spec is None or spec.loader is None:
        raise TwistarmError(f"{file} cannot be loaded; pip install xacro==2.1.1")
    copy: Any = module_from_spec(spec)
    sys.modules[_NAME] = copy  # where its own imports look for it
    spec.loader.exec_module(copy)
    import_module(f"{_NAME}.substitution_args")
    if missing := [name for name in REPLACED if not hasattr(copy, name)]:
        lacks = f"this xacro ({file}) has no {', '.join(missing)} and cannot be confined"
        raise TwistarmError(f"{lacks}; pip install xacro==2.1.1")
    copy.original = {name: getattr(copy, name) for name in REPLACED}
    return copy
