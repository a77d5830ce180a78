"""xacro's raw errors in one line each: the cause, the place and the remedy."""

from __future__ import annotations

import re
from collections.abc import Iterator

from ...support.errors import DescriptionError, closest
from ...support.messages import Argument, Text, package_folder
from ..findings import refusal
from .confinement import Refused
from .expansion import MISSING_PACKAGE, Expansion

REMEDIES = {
    "Invalid parameter": "add it to the params= of the macro, or leave it out of the call",
    "is not defined": "define it by <xacro:property …>; without the prefix it is no property",
    "xacro:arg: missing attribute 'default'": 'write default="" and give the value when loading',
}
"""Remedies by a part of xacro's sentence."""


def explain(error: Exception, expansion: Expansion) -> DescriptionError:
    """The error to raise, at the file or the macro that xacro was expanding."""
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
    remedy = next((remedy for part, remedy in REMEDIES.items() if part in text), "")
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
    inside = {each: ... for each, value in values.items() if value and value in name}
    remedy = "correct the path, or put the file there"
    if inside:
        remedy = Text("correct the path, or pass {arguments}", arguments=Argument("xacro_args", inside))
    return refusal("xacro-failed", expansion.place, _shortened(f"xacro cannot expand it: {why}: {name}"), remedy)


def _missing_package(package: str, expansion: Expansion) -> DescriptionError:
    what = f"package {package!r} not found; searched {expansion.packages.searched()}"
    if far := expansion.packages.find_for_mesh_alone(package):
        what = (
            f"package {package!r} stands in {far}, which the arm.toml alone names: of packages that far from it meshes "
            "are drawn, and nothing is included"
        )
    near = closest(package, expansion.packages.names())
    remedy = Text(
        "{correct}pass {folder}, or where the arm can do without it (a sensor's, a gripper's, a simulator's) {without}",
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
