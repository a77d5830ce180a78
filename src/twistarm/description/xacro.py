"""xacro to URDF text without ROS: our own `$(find)`, arguments checked, every error in one line."""

from __future__ import annotations

import contextlib
import io
import re
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.parsers.expat import ExpatError

from ..errors import DescriptionError, InputError, closest
from .document import read_text
from .findings import Finding, Place, finding
from .packages import PackageIndex

_LOCK = threading.Lock()
"""xacro keeps arguments, file stack and verbosity in module globals: one expansion at a time."""

_MISSING = "/package-not-found/"
"""Stands for the folder of an unknown package; harmless in texts nobody opens, recognised where a file is opened."""

_ARGUMENT = re.compile(r"<xacro:arg\b[^>]*?\bname\s*=\s*[\"']([^\"']+)[\"'][^>]*>")
_DEFAULT = re.compile(r"\bdefault\s*=\s*([\"'])(.*?)\1")
_USED = re.compile(r"\$\(arg\s+([^)\s]+)\s*\)")


def expand_xacro(
    path: Path, packages: PackageIndex, arguments: Mapping[str, object] | None = None
) -> tuple[str, tuple[Finding, ...]]:
    """The URDF text that `path` expands to, and what was noticed on the way.

    A package that is not found fails only where an include or a YAML load needs it. Raises DescriptionError with
    the file, the cause and the remedy; a missing argument is answered with the list of all arguments.
    """
    import xacro  # type: ignore[import-untyped,unused-ignore]

    given = {name: _argument_text(value) for name, value in (arguments or {}).items()}
    unknown: set[str] = set()
    with _LOCK, _own_find(packages, unknown):
        xacro.all_includes.clear()
        try:
            document = xacro.process_file(str(path), mappings=dict(given), verbosity=0)
            text = str(document.toxml())
        except Exception as error:
            files = [path, *(Path(str(name)) for name in xacro.all_includes)]
            raise DescriptionError(f"{path}: {_explain(error, packages, files, given)}") from error
        files = [path, *(Path(str(name)) for name in xacro.all_includes)]
    _refuse_unknown_arguments(path, files, given)
    return text, tuple(_package_finding(path, name, packages) for name in sorted(unknown))


def is_xacro(path: Path) -> bool:
    """Whether a file must be expanded first: by its name, or because a xacro element stands in it."""
    return path.suffix == ".xacro" or "<xacro:" in read_text(path)


@contextlib.contextmanager
def _own_find(packages: PackageIndex, unknown: set[str]) -> Iterator[None]:
    """xacro's `$(find)` answered by our index, and its chatter on stderr kept away, while the context lasts."""
    from xacro import substitution_args

    def find(package: str) -> str:
        folder = packages.find(package)
        if folder is None:
            unknown.add(package)
            return _MISSING + package
        return str(folder)

    original = substitution_args._eval_find
    substitution_args._eval_find = find
    substitution_args._eval_dict["find"] = find
    try:
        with contextlib.redirect_stderr(io.StringIO()):
            yield
    finally:
        substitution_args._eval_find = original
        substitution_args._eval_dict["find"] = original


def _argument_text(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _declared(files: list[Path]) -> dict[str, str | None]:
    """Arguments declared in `files` with their default, and those used without being declared (None)."""
    arguments: dict[str, str | None] = {}
    for text in _texts(files):
        for match in _ARGUMENT.finditer(text):
            default = _DEFAULT.search(match.group(0))
            arguments.setdefault(match.group(1), default.group(2) if default else None)
    for text in _texts(files):
        for name in _USED.findall(text):
            arguments.setdefault(name, None)
    return arguments


def _texts(files: list[Path]) -> list[str]:
    existing = [file for file in dict.fromkeys(files) if file.is_file()]
    return [re.sub(r"<!--.*?-->", "", file.read_text("utf-8", "replace"), flags=re.S) for file in existing]


def _refuse_unknown_arguments(path: Path, files: list[Path], given: Mapping[str, str]) -> None:
    declared = _declared(files)
    for name in given:
        if name not in declared:
            listing = ", ".join(declared) or "none"
            raise InputError(
                f"{path.name} has no xacro argument {name!r}{closest(name, declared)} (its arguments: {listing})"
            )


def _explain(error: Exception, packages: PackageIndex, files: list[Path], given: Mapping[str, str]) -> str:
    """One line: what went wrong, and what to do about it."""
    chain = list(_causes(error))
    text = _without_echo(" ".join(str(error).split()))
    undefined = re.search(r"Undefined substitution argument (\S+)", text)
    if undefined:
        return _missing_argument(undefined.group(1), files, given)
    missing = re.search(re.escape(_MISSING) + r"([^/\s'\"]+)", text)
    if missing:
        return (
            f"package {missing.group(1)!r} not found; searched {packages.searched()}; "
            "pass package_dirs=[folder that holds it]"
        )
    if any(isinstance(cause, RecursionError) for cause in chain):
        return "a macro, a property or an included file refers to itself without end"
    if any(isinstance(cause, UnicodeDecodeError) for cause in chain):
        return f"it is not UTF-8{_where(files)}; save it as UTF-8"
    if text == "xacro:arg: missing attribute 'default'":
        return 'a <xacro:arg> has no default=, which xacro demands; write default="" and give the value when loading'
    if any(isinstance(cause, ExpatError) for cause in chain):
        return _malformed(text)
    return f"xacro cannot expand it: {text}{_where(files)}"


def _without_echo(text: str) -> str:
    """Without Python's own text of a missing file where xacro has named the file already."""
    echo = re.search(r" ?\[Errno \d+\][^:]*: '([^']*)'", text)
    return text.replace(echo.group(0), "") if echo and text.count(echo.group(1)) > 1 else text


def _malformed(text: str) -> str:
    if "unbound prefix" in text:
        return 'a tag\'s prefix is not declared: add xmlns:xacro="http://www.ros.org/wiki/xacro" to <robot>'
    return f"not well-formed XML: {text}"


def _where(files: list[Path]) -> str:
    return f" (last file opened: {files[-1].name})" if len(files) > 1 else ""


def _missing_argument(undefined: str, files: list[Path], given: Mapping[str, str]) -> str:
    """Every argument, its default and the missing ones; `undefined` may have a default that comes too late."""
    declared = _declared(files)
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
    remedy = f"pass xacro_args={{{', '.join(f'{name!r}: …' for name in missing)}}}"
    return f"missing xacro argument{'s' * (len(missing) > 1)} {', '.join(missing)}; all arguments: {listing}; {remedy}"


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


def _package_finding(path: Path, package: str, packages: PackageIndex) -> Finding:
    return finding(
        "package-not-found",
        Place(path.name),
        f"$(find {package}): package not found (searched {packages.searched()}); nothing the kinematics needs uses it",
        f"pass package_dirs=[folder that holds {package}] if its files matter",
    )
