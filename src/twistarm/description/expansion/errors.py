"""xacro's raw errors in one line each: the cause, the place and the remedy."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from types import EllipsisType

from ...support.errors import DescriptionError, InputError, closest, listed
from ...support.messages import Argument, Text, package_folder
from ..findings import Finding, Place, finding, refusal
from .evaluation import NotSetError
from .hooks import MISSING_PACKAGE, Expansion
from .work import Refused, causes

MOST_NEIGHBOURS = 8
"""Most names of a folder in a message about a missing one."""


def explain(error: Exception, expansion: Expansion, place: Place) -> DescriptionError:
    """The error to raise. `place` is the file or the macro that xacro was expanding."""
    chain = list(causes(error))
    text = " ".join(str(error).split())
    for cause in chain:
        if isinstance(cause, DescriptionError):
            return cause
        if isinstance(cause, Refused):
            where = f" (in {_shortened(cause.expression, 120)})" if cause.expression else ""
            return refusal(cause.code, place, _shortened(cause.what) + where, cause.remedy)
    if any(isinstance(cause, RecursionError) for cause in chain):
        what = "a macro, a property or an included file refers to itself without end"
        return refusal("xacro-failed", place, what)
    undefined = re.search(r"Undefined substitution argument (\S+)", text)
    if undefined:
        return missing_argument(undefined.group(1), expansion)
    missing = re.search(re.escape(MISSING_PACKAGE) + r"([^/\s'\"]+)/*([^\s'\"]*)", text)
    if missing:
        return _missing_package(missing.group(1), Path(missing.group(2)), expansion, place)
    for cause in chain:
        if isinstance(cause, OSError):
            return refusal("xacro-failed", place, *_missing_file(cause, expansion))
        if isinstance(cause, NotSetError):
            remedy = Text("pass {allowed} if it may know it, and set it", allowed=Argument("env_vars", [...]))
            return refusal("xacro-failed", place, f"xacro cannot expand it: {cause}", remedy)
    return refusal("xacro-failed", place, *_reworded(text, expansion))


def _missing_package(package: str, wanted: Path, expansion: Expansion, place: Place) -> DescriptionError:
    """The error for a missing package. `wanted` is the file to open in it."""
    what = f"package {package!r} not found; searched {expansion.packages.searched()}"
    remedy = Text(
        "pass {folder}, or where the arm can do without it (a sensor's, a gripper's, a simulator's) {without}",
        folder=package_folder("it"),
        without=Argument("ignore_packages", [package]),
    )
    if near_names := closest(package, expansion.packages.names()):
        remedy = Text("correct the name{near}, or {other}", near=near_names, other=remedy)
    if far := expansion.packages.find_for_mesh_alone(package):
        what = (
            f"package {package!r} stands in {far}, which the arm.toml alone names: of packages that far from it meshes "
            "are drawn, and nothing is included"
        )
    elif near := _folder_with(wanted, expansion):
        what += f"; the requested file, {wanted}, stands in {near}"
        remedy = Text("if that folder is the package, name it {package}; else {other}", package=package, other=remedy)
    elif (beside := expansion.path.parent / wanted.name).is_file():
        what += f"; the requested file stands at {beside}"
        remedy = Text(
            "copy the package with its folders: there it is {package}/{wanted}; else {other}",
            package=package,
            wanted=wanted,
            other=remedy,
        )
    return refusal("package-needed-not-found", place, _shortened(what), remedy)


def _folder_with(wanted: Path, expansion: Expansion) -> Path | None:
    """A folder near the description, or of the user, with the wanted file of a package."""
    if not wanted.name or ".." in wanted.parts:
        return None
    return next((folder for folder in expansion.packages.near if (folder / wanted).is_file()), None)


def _missing_file(error: OSError, expansion: Expansion) -> tuple[str, str]:
    """Cause and remedy for a file that cannot be opened, with names nearby and arguments that may be wrong."""
    what = f"xacro cannot expand it: {error.strerror}: {error.filename}"
    path = Path(str(error.filename))
    if not isinstance(error, FileNotFoundError) or not path.is_absolute():
        return _shortened(what), "correct the path"
    folder = next(parent for parent in path.parents if parent.is_dir())
    absent = path.relative_to(folder).parts[0]
    if there := expansion.neighbours(folder, path):
        what += f"; there is no {absent!r} in {folder}, but {listed(there, MOST_NEIGHBOURS)}"
    told = _behind(absent, expansion)
    if not told:
        return _shortened(what), "correct the path, or put the file there"
    named = ", ".join(f"{name} ({value!r})" for name, value in told.items())
    return _shortened(f"{what}; it may come from the xacro argument {named}"), _pass(dict.fromkeys(told, ...))


def _behind(part: str, expansion: Expansion) -> dict[str, str]:
    """The arguments that a part of a path seems to contain: by the longest values, or by names of empty ones."""
    values = {**expansion.found.all(), **expansion.given}
    inside = {name: value for name, value in values.items() if value is not None and (value or name) in part}
    longest = max((len(value or name) for name, value in inside.items()), default=0)
    return {name: value for name, value in inside.items() if len(value or name) == longest > 1}


def missing_argument(undefined: str, expansion: Expansion) -> DescriptionError:
    """The error for an argument without a value, or with a default that comes too late. Lists others without one."""
    declared, given = expansion.found.all(), expansion.given
    used_in = expansion.found.used.get(undefined, expansion.path).name
    absent = {name: ... for name, default in declared.items() if default is None and name not in given}
    late = declared.get(undefined)
    missing = {undefined: late if late and "$" not in late else ...} | absent
    plural = "s" * (len(missing) > 1)
    what = f"missing xacro argument{plural} {', '.join(missing)}: {used_in} uses {undefined}"
    if late is not None:
        what += f" above the line that gives it its default, {late!r}, and xacro reads from top to bottom"
    else:
        others = {name: given.get(name, default) for name, default in declared.items() if name not in missing}
        what += ", which has no default"
        if others:
            what += f"; the others have values: {', '.join(f'{name} ({value!r})' for name, value in others.items())}"
    return refusal("xacro-arguments", Place(str(expansion.path)), _shortened(what), _shortened(_pass(missing)))


def _pass(arguments: Mapping[str, str | EllipsisType]) -> str:
    """The remedy `pass xacro_args={'dof': '7'}`, with an ellipsis for a value that only the user knows."""
    return Text("pass {arguments}", arguments=Argument("xacro_args", arguments))


def unknown_argument(name: str, path: Path, known: Mapping[str, str | None]) -> InputError:
    """The error for a given argument that the file does not take."""
    allowed = f"its arguments: {', '.join(known) or 'none'}"
    return InputError(f"{path.name} has no xacro argument {name!r}{closest(name, known)} ({allowed})")


def package_finding(path: Path, package: str) -> Finding:
    """The finding for a missing package that no opened file needed."""
    what = f"$(find {package}): package not found; nothing the kinematics needs uses it"
    return finding(
        "package-not-found",
        Place(path.name),
        what,
        Text("pass {folder} if its files matter", folder=package_folder(package)),
    )


def _reworded(text: str, expansion: Expansion) -> tuple[str, str]:
    """Cause and remedy for errors of xacro with a text that does not help."""
    if text == "xacro:arg: missing attribute 'default'":
        remedy = 'write default="" and give the value when loading'
        return "a <xacro:arg> has no default=, which xacro demands", remedy
    parameter = re.search(r'Invalid parameter "([^"]*)"', text)
    if parameter:
        what = f'Invalid parameter "{_shortened(parameter.group(1), 120)}": the macro has none of that name'
        return f"xacro cannot expand it: {what}", "add it to the params= of the macro, or leave it out of the call"
    undefined = re.search(r"name '([^']*)' is not defined", text)
    if undefined and undefined.group(1) in expansion.found.unprefixed:
        remedy = f'write <xacro:property name="{undefined.group(1)}" …>: without the prefix it is no property'
        return f"xacro cannot expand it: {_shortened(text)}", remedy
    return f"xacro cannot expand it: {_shortened(text)}", ""


def _shortened(text: str, length: int = 700) -> str:
    """The text on one line, cut at `length`."""
    line = " ".join(text.split())
    return text if line == text and len(line) <= length else line if len(line) <= length else f"{line[:length]}…"
