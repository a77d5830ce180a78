"""xacro to URDF text without ROS, one file with its includes at a time, and its errors in one line each."""

from __future__ import annotations

import functools
import re
import sys
import threading
import traceback
from collections.abc import Iterable, Iterator, Mapping
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any, NamedTuple

from ...support.errors import DescriptionError, InputError, TwistarmError, closest
from ...support.interrupts import ending_at_once
from ...support.messages import Argument, Text, package_folder
from ...support.wheels import Wheel, load
from ..document import Refused, read_text
from ..findings import Finding, refusal
from ..packages import PackageIndex
from .expansion import HERE, MISSING_PACKAGE, PACKAGE, PLACE, REPLACED, Expansion

# ROS 2's is the same code and serves; ROS 1's lacks what `Expansion` replaces.
_WHEEL = Wheel("xacro", "xacro", has="process_file", oldest="2.1")

_NAME = f"{__package__}._xacro"

# xacro keeps arguments, file stack and verbosity in module globals: one expansion at a time.
_LOCK = threading.Lock()


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

    It reads files of its package and of packages found by their name (`document.read_inside`), and only the environment
    variables in `env_vars`. Its expressions only compute (`expressions`). A missing package is an error only if an
    include or a YAML load needs it. Includes, YAML and macros of the packages in `ignore_packages` are left out.
    Ctrl-C ends the process meanwhile, because one operation of an expression may take any time.

    Raises DescriptionError with the file, the cause and the remedy. Raises InputError for an argument that the file
    does not take.
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


REMEDIES = {
    "Invalid parameter": "add it to the params= of the macro, or leave it out of the call",
    "is not defined": "define it by <xacro:property …>; without the prefix it is no property",
    r"expression '[^']*\$\{": "write one ${…} round the whole expression: they do not nest",
    "xacro:arg: missing attribute 'default'": 'write default="" and give the value when loading',
}
"""Remedies by a pattern in xacro's sentence."""


def explain(error: Exception, expansion: Expansion) -> DescriptionError:
    """The error to raise, at the element, in the file or the macro that xacro was expanding."""
    for frame, _ in traceback.walk_tb(error.__traceback__):  # xacro's errors do not name the element
        node: Any = frame.f_locals.get("node")
        while hasattr(node, "getUserData") and node.getUserData(PLACE) is None:  # a text
            node = node.parentNode
        if hasattr(node, "getUserData"):
            expansion.failed = node.getUserData(PLACE)
    text = " ".join(str(error).split())
    for cause in _causes(error, set()):
        if isinstance(cause, DescriptionError):
            return cause
        if isinstance(cause, Refused):
            expression = re.search(r"when evaluating expression '(.*)'", text)
            where = f" (in ${{{_shortened(expression[1], 120)}}})" if expression else ""
            return refusal(cause.code, expansion.place, _shortened(cause.what) + where, cause.remedy)
        if isinstance(cause, RecursionError):
            what = "it nests without end: a macro, a property or an included file refers to itself, or YAML is too deep"
            return refusal("xacro-failed", expansion.place, what)
        if isinstance(cause, OSError):
            return _missing_file(str(cause.filename), cause.strerror or "", expansion)
    if undefined := re.search(r"Undefined substitution argument (\S+)", text):
        return _missing_argument(undefined[1], expansion)
    remedy = next((remedy for part, remedy in REMEDIES.items() if re.search(part, text)), "")
    return refusal("xacro-failed", expansion.place, f"xacro cannot expand it: {_shortened(text)}", remedy)


def _causes(error: BaseException | None, seen: set[int]) -> Iterator[BaseException]:
    """The error and all that it wraps: xacro keeps the original in `.exc`, Python in `__cause__`/`__context__`."""
    if isinstance(error, BaseException) and id(error) not in seen:
        seen.add(id(error))
        yield error
        for wrapped in (getattr(error, "exc", None), error.__cause__, error.__context__):
            yield from _causes(wrapped, seen)


def _missing_file(name: str, why: str, expansion: Expansion) -> DescriptionError:
    """The error for a file that is not there, perhaps for an argument in its path, or for want of its package."""
    if name.startswith(MISSING_PACKAGE):
        return _missing_package(name.removeprefix(MISSING_PACKAGE).partition("/")[0], expansion)
    values = {**expansion.arguments, **expansion.given}
    empty = {argument: ... for argument, value in values.items() if not value and argument in name}
    inside = empty or {argument: ... for argument, value in values.items() if value and value in name}
    remedy = "correct the path, or put the file there"
    if inside:
        remedy = Text("correct the path, or pass {arguments}", arguments=Argument("xacro_args", inside))
    return refusal("xacro-failed", expansion.place, _shortened(f"xacro cannot expand it: {why}: {name}"), remedy)


def _missing_package(package: str, expansion: Expansion) -> DescriptionError:
    what = f"package {package!r} not found; searched {expansion.packages.searched()}"
    if far := expansion.packages.in_mesh_dirs.get(package):
        what = (
            f"package {package!r} is in {far}. Only the arm.toml names this folder, so its meshes are drawn "
            "and its files are not included"
        )
    near = closest(package, expansion.packages.names())
    remedy = Text(
        "{correct}pass {folder}; if the arm does not need it (sensor, gripper, simulator), pass {without}",
        correct=f"correct the name{near}, or " if near else "",
        folder=package_folder("it"),
        without=Argument("ignore_packages", [package]),
    )
    return refusal("package-needed-not-found", expansion.place, _shortened(what), remedy)


def _missing_argument(name: str, expansion: Expansion) -> DescriptionError:
    """The error for an argument without a value, or with a default that comes too late. It names all without one."""
    late = expansion.arguments.get(name)
    what = f"the xacro argument {name!r} has no value"
    if late is not None:
        what += f" here: its default, {late!r}, comes in a later line, and xacro reads from top to bottom"
    missing = {name: late if late and "$" not in late else ...}
    for other, default in expansion.arguments.items():
        if default is None and other not in expansion.given:
            missing.setdefault(other, ...)
    remedy = Text("pass {arguments}", arguments=Argument("xacro_args", missing))
    return refusal("xacro-arguments", expansion.place, _shortened(what), remedy)


def _shortened(text: str, length: int = 700) -> str:
    """The text on one line, cut at `length`."""
    line = " ".join(text.split())
    return line if len(line) <= length else f"{line[:length]}…"
