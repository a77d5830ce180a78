"""xacro to URDF text without ROS, by the worker process within limits of time and memory."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from ...support.errors import TwistarmError
from ...support.worker_process import shared, working_folder
from ..document import note_file, read_text
from ..findings import Finding, Place, refusal
from ..packages import PackageIndex

WORKER = f"{__package__}.worker"

SECONDS, MEMORY = 6.0, 400_000_000
"""Processor time and bytes of an expansion. A six-joint arm with its parameters in YAML takes 0.1 s and 10 MB."""


class Expanded(NamedTuple):
    """The URDF text, findings, and every argument that the file and its includes take, {name: default}.

    A required argument has the default None.
    """

    text: str
    findings: tuple[Finding, ...]
    arguments: dict[str, str | None]


def begin_expansion() -> None:
    """Start the process if possible, and return at once."""
    with suppress(TwistarmError):
        shared.process().prepare(WORKER)


def expand_xacro(
    path: Path,
    packages: PackageIndex,
    arguments: Mapping[str, object] | None = None,
    ignore_packages: Iterable[str] = (),
    env_vars: Iterable[str] = (),
) -> Expanded:
    """Expand the file at `path`.

    Files outside the packages stay closed (`confinement`). Expressions only compute (`expressions`). They read only the
    environment variables in `env_vars` (`environment`). A missing package is an error only if an include or a YAML load
    needs it. Parts of the packages in `ignore_packages` are left out (`left_out`). Raises DescriptionError with the
    file, the cause and the remedy, also for a file that takes more than SECONDS or MEMORY.
    """
    given = {name: _argument_text(value) for name, value in (arguments or {}).items()}
    context = SECONDS, MEMORY, dict(os.environ), working_folder()
    note_file(path)
    request = path, packages, given, tuple(ignore_packages), tuple(env_vars)
    try:
        with shared.turn:
            files, found, answer = shared.process().ask(WORKER, (*context, *request), SECONDS)
    except (TimeoutError, MemoryError, EOFError) as error:
        limits = {TimeoutError: f"{SECONDS:.0f} s", MemoryError: f"{MEMORY / 1e6:.0f} MB"}
        most = limits.get(type(error))
        what = f"expanding it takes more work than any robot's description needs: more than {most}"
        what = what if most else "the process that expands it broke down"
        remedy = "look for a macro, a list or a text that multiplies itself"
        raise refusal("xacro-too-large", Place(str(path)), what, remedy) from error
    for file in files:
        note_file(file)
    packages.learn(found)
    if isinstance(answer, TwistarmError):
        raise answer
    return Expanded(*answer)


def is_xacro(path: Path) -> bool:
    """Whether a file needs expansion, by its name or by a xacro element in it."""
    return path.suffix == ".xacro" or "<xacro:" in read_text(path)


def _argument_text(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
