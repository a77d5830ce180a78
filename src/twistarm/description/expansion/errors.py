"""xacro's raw errors in one line each: the cause, the place and the remedy."""

from __future__ import annotations

import re
from pathlib import Path

from ...support.errors import DescriptionError, InputError, closest
from ...support.messages import Argument, Text, package_folder
from ..findings import Place, refusal
from .confinement import Refused, causes
from .expansion import MISSING_PACKAGE, Expansion, NotSetError


def explain(error: Exception, expansion: Expansion, place: Place) -> DescriptionError:
    """The error to raise. `place` is the file or the macro that xacro was expanding."""
    chain, text = list(causes(error)), " ".join(str(error).split())
    for cause in chain:
        if isinstance(cause, DescriptionError):
            return cause
        if isinstance(cause, Refused):
            expression = re.search(r"when evaluating expression '(.*)'", text)
            where = f" (in ${{{_shortened(expression[1], 120)}}})" if expression else ""
            return refusal(cause.code, place, _shortened(cause.what) + where, cause.remedy)
    if any(isinstance(cause, RecursionError) for cause in chain):
        what = "a macro, a property or an included file refers to itself without end"
        return refusal("xacro-failed", place, what)
    if undefined := re.search(r"Undefined substitution argument (\S+)", text):
        return _missing_argument(undefined[1], expansion)
    if missing := re.search(re.escape(MISSING_PACKAGE) + r"([^/\s'\"]+)", text):
        return _missing_package(missing[1], expansion, place)
    for cause in chain:
        if isinstance(cause, OSError):
            failed = _shortened(f"xacro cannot expand it: {cause.strerror}: {cause.filename}")
            return refusal("xacro-failed", place, failed, _wrong_path(str(cause.filename), expansion))
        if isinstance(cause, NotSetError):
            remedy = Text("pass {allowed} if it may know it, and set it", allowed=Argument("env_vars", [...]))
            return refusal("xacro-failed", place, f"xacro cannot expand it: {cause}", remedy)
    if text == "xacro:arg: missing attribute 'default'":
        without = "a <xacro:arg> has no default=, which xacro demands"
        return refusal("xacro-failed", place, without, 'write default="" and give the value when loading')
    return refusal("xacro-failed", place, f"xacro cannot expand it: {_shortened(text)}", _hint(text))


def unknown_argument(name: str, path: Path, known: dict[str, str | None]) -> InputError:
    """The error for a given argument that the file does not take."""
    allowed = f"its arguments: {', '.join(known) or 'none'}"
    return InputError(f"{path.name} has no xacro argument {name!r}{closest(name, known)} ({allowed})")


def _missing_package(package: str, expansion: Expansion, place: Place) -> DescriptionError:
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
    return refusal("package-needed-not-found", place, _shortened(what), remedy)


def _wrong_path(name: str, expansion: Expansion) -> str:
    """The remedy for a file that is not there, with the arguments that may have made its path."""
    values = {**expansion.found.all(), **expansion.given}
    inside = {each: ... for each, value in values.items() if value and value in name}
    if not inside:
        return "correct the path, or put the file there"
    return Text("correct the path, or pass {arguments}", arguments=Argument("xacro_args", inside))


def _missing_argument(undefined: str, expansion: Expansion) -> DescriptionError:
    """The error for an argument without a value, or with a default that comes too late. Lists others without one."""
    declared, given = expansion.found.all(), expansion.given
    used_in = expansion.found.used.get(undefined, expansion.path).name
    absent = {name: ... for name, default in declared.items() if default is None and name not in given}
    late = declared.get(undefined)
    missing = {undefined: late if late and "$" not in late else ...} | absent
    what = f"missing xacro arguments {', '.join(missing)}: {used_in} uses {undefined}"
    if late is not None:
        what += f" above the line that gives it its default, {late!r}, and xacro reads from top to bottom"
    else:
        others = {name: given.get(name, default) for name, default in declared.items() if name not in missing}
        values = ", ".join(f"{name} ({value!r})" for name, value in others.items())
        what += f", which has no default; the others have values: {values}" if others else ", which has no default"
    remedy = Text("pass {arguments}", arguments=Argument("xacro_args", missing))
    return refusal("xacro-arguments", Place(str(expansion.path)), _shortened(what), remedy)


def _hint(text: str) -> str:
    if "Invalid parameter" in text:
        return "add it to the params= of the macro, or leave it out of the call"
    if re.search(r"name '[^']*' is not defined", text):
        return "define it by <xacro:property …>; without the prefix it is no property"
    return ""


def _shortened(text: str, length: int = 700) -> str:
    """The text on one line, cut at `length`."""
    line = " ".join(text.split())
    return line if len(line) <= length else f"{line[:length]}…"
