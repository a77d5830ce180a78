"""The answer to a request for an expansion, in the worker process."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from ...support.errors import TwistarmError
from ...support.worker import limit_memory, limit_time
from ..document import MAX_BYTES, noted_files
from ..packages import PackageIndex
from .errors import explain, package_finding, unknown_argument
from .hooks import HERE, PACKAGE, Expansion
from .left_out import blamed
from .refused import Refused

_DECLARATION = '<?xml version="1.0" ?>'


def answer(
    seconds: float, memory: int, environment: Mapping[str, str], folder: str | None, *request: Any
) -> tuple[set[Path], PackageIndex, Any]:
    """The files that were looked for, the packages found, and the fields of `Expanded` or the error to raise.

    `environment` and `folder` are those of the program that asks, `request` the other arguments of `Expansion`.
    """
    limit_time(time.process_time() + seconds)
    limit_memory(memory)
    os.environ.clear()
    os.environ.update(environment)
    with suppress(OSError):
        os.chdir(folder or "/")
    try:
        with noted_files() as files:
            expansion = Expansion(folder, *request)
            return files, expansion.packages, _expanded(expansion)
    except TwistarmError as error:
        return files, request[1], error
    finally:
        os.chdir("/")


def _expanded(expansion: Expansion) -> tuple[Any, ...]:
    try:
        text = _portable(expansion.run())
    except Exception as error:
        raise blamed(explain(error, expansion, expansion.place), expansion.left_out.findings(())) from error
    known = expansion.found.all()
    for name in expansion.given:
        if name not in known:
            raise unknown_argument(name, expansion.path, known)
    unknown = (package_finding(expansion.path, name) for name in sorted(expansion.unknown_packages))
    noted = (*unknown, *expansion.environment.findings(), *expansion.left_out.findings(expansion.found.packages))
    return text, noted, known


def _portable(robot: str) -> str:
    """The text without xacro's banner, which shows the file's folder, with paths that any reader of URDF takes.

    `file://$(find arm)/…` is the package's file. Paths beside the description are relative to it.
    """
    if len(robot) > MAX_BYTES:
        what = f"it expands to {len(robot):,} characters; at most {MAX_BYTES:,} are read"
        raise Refused("xacro-too-large", what, "leave out what the arm does not need")
    return _DECLARATION + robot.replace(f"file://{PACKAGE}", PACKAGE).replace(HERE, "")
