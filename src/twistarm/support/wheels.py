"""Modules of wheels. If another one hides it, as in a ROS shell, one line gives the remedy."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from .errors import MissingExtraError, TwistarmError

_PATHS = ("PYTHONPATH", "LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH")
"""Variables by which a shell puts other modules and libraries before those of wheels."""


@dataclass(frozen=True)
class Wheel:
    """A module, its distribution, a name that no namesake has, and the oldest version."""

    module: str
    distribution: str
    has: str
    oldest: str


def load(wheel: Wheel) -> Any:
    """The module. MissingExtraError if it is not installed; TwistarmError with its file and the remedy if unusable."""
    try:
        with _installed_modules():
            module = import_module(wheel.module)
    except Exception as error:  # a foreign package may raise whatever it likes
        if isinstance(error, ModuleNotFoundError) and error.name == wheel.module:
            raise MissingExtraError(f"{wheel.module} is not installed; {_install(wheel)}") from error
        spec = find_spec(wheel.module)
        cause = " ".join(str(error).split())[:200] or type(error).__name__
        raise _unfit(wheel, spec.origin if spec else None, f"cannot be imported ({cause})") from error
    fault = _fault(module, wheel)
    if fault:
        raise _unfit(wheel, getattr(module, "__file__", None), fault)
    return module


@contextmanager
def _installed_modules() -> Iterator[None]:
    """Leave the current folder out of the module path: a stranger's archive may hold modules."""
    before, here = sys.path[:], os.path.realpath(".")
    sys.path[:] = [folder for folder in before if os.path.realpath(folder) != here]
    try:
        yield
    finally:
        sys.path[:] = before


def _fault(module: Any, wheel: Wheel) -> str:
    version = str(getattr(module, "__version__", wheel.oldest))
    if _numbers(version) < _numbers(wheel.oldest):
        return f"is version {version}, and twistarm needs {wheel.oldest}"
    return "" if hasattr(module, wheel.has) else f"has no {wheel.has}: it is another project"


def _numbers(version: str) -> list[int]:
    return [int(number) for number in re.findall(r"\d+", version)[:3]]


def _unfit(wheel: Wheel, file: str | None, fault: str) -> TwistarmError:
    """The error, with the shell's variables to start without where it has any."""
    program = "twistarm" if Path(sys.argv[0]).stem == "twistarm" else "python"
    unset = " ".join(f"-u {name}" for name in _PATHS if os.environ.get(name))
    start = f"start with env {unset} {program} …, or " if unset else ""
    namesake = f"pip uninstall {wheel.module}, then " if wheel.module != wheel.distribution else ""
    return TwistarmError(f"{wheel.module} at {file or 'an unknown place'} {fault}; {start}{namesake}{_install(wheel)}")


def _install(wheel: Wheel) -> str:
    return f"pip install '{wheel.distribution}>={wheel.oldest}'"
