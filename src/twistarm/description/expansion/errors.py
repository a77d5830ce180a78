"""xacro's raw errors in one line each: what went wrong, where, and what to do about it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ...errors import DescriptionError, InputError, closest
from ..findings import Finding, Place, finding, refusal
from ..packages import PackageIndex
from .hooks import MISSING_PACKAGE, Expansion
from .work import Refused


def explain(error: Exception, expansion: Expansion, place: Place) -> DescriptionError:
    """The error to raise; `place`: the file, or the macro, that was being expanded."""
    chain = list(_causes(error))
    text = " ".join(str(error).split())
    for cause in chain:
        if isinstance(cause, DescriptionError):
            return cause
        if isinstance(cause, Refused):
            where = f" (in {_shortened(cause.expression, 120)})" if cause.expression else ""
            return refusal(cause.code, place, _shortened(cause.what) + where, cause.remedy)
    if any(isinstance(cause, RecursionError) for cause in chain):
        what = "a macro, a property or an included file refers to itself without end"
        return refusal("xacro-recursion", place, what)
    undefined = re.search(r"Undefined substitution argument (\S+)", text)
    if undefined:
        return missing_argument(undefined.group(1), expansion)
    missing = re.search(re.escape(MISSING_PACKAGE) + r"([^/\s'\"]+)", text)
    if missing:
        what = f"package {missing.group(1)!r} not found; searched {expansion.packages.searched()}"
        return refusal("package-needed-not-found", place, _shortened(what), "pass package_dirs=[folder that holds it]")
    return refusal("xacro-failed", place, *_reworded(text, expansion))


def missing_argument(undefined: str, expansion: Expansion) -> DescriptionError:
    """Every argument, its default and the missing ones; `undefined` may have a default that comes too late."""
    declared, given = expansion.found.all(), expansion.given
    absent = [name for name, default in declared.items() if default is None and name not in given]
    missing = list(dict.fromkeys([undefined, *absent]))
    listing = ", ".join(
        f"{name} (given: {given[name]})"
        if name in given
        else f"{name} (default {default!r})"
        if default is not None
        else f"{name} (required)"
        for name, default in declared.items()
    )
    what = f"missing xacro argument{'s' * (len(missing) > 1)} {', '.join(missing)}; all arguments: {listing or 'none'}"
    remedy = f"pass xacro_args={{{', '.join(f'{name!r}: …' for name in missing)}}}"
    return refusal("xacro-argument-missing", Place(str(expansion.path)), _shortened(what), _shortened(remedy))


def unknown_argument(name: str, path: Path, known: Mapping[str, str | None]) -> InputError:
    """A name among the arguments that the file does not take."""
    allowed = f"its arguments: {', '.join(known) or 'none'}"
    return InputError(f"{path.name} has no xacro argument {name!r}{closest(name, known)} ({allowed})")


def package_finding(path: Path, package: str, packages: PackageIndex) -> Finding:
    """A package that is nowhere, and that nothing needed which was opened."""
    return finding(
        "package-not-found",
        Place(path.name),
        f"$(find {package}): package not found (searched {packages.searched()}); nothing the kinematics needs uses it",
        f"pass package_dirs=[folder that holds {package}] if its files matter",
    )


def current_place(xacro: Any, path: Path) -> Place:
    """The macro being expanded and the file that defines it, else the file."""
    if xacro.macrostack:
        macro = xacro.macrostack[-1]
        file, name = str(macro.history[-1][-1] or path), macro.body.getAttribute("name")
        return Place(_shortened(file), element="macro", name=_shortened(name, 120))
    return Place(_shortened(str(xacro.filestack[-1] if xacro.filestack else path)))


def _reworded(text: str, expansion: Expansion) -> tuple[str, str]:
    """What happened and the remedy, for the errors of xacro whose own text does not help."""
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
    """On one line, and no longer than a person reads."""
    line = " ".join(text.split())
    return line if len(line) <= length else f"{line[:length]}…"


def _causes(error: BaseException) -> Iterator[Any]:
    """The error and whatever it wraps: xacro keeps the original in `.exc`, Python in `__cause__`/`__context__`."""
    seen: set[int] = set()
    stack: list[BaseException | None] = [error]
    while stack:
        current = stack.pop()
        if isinstance(current, BaseException) and id(current) not in seen:
            seen.add(id(current))
            yield current
            stack += [getattr(current, "exc", None), current.__cause__, current.__context__]
