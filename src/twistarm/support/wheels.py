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
from typing import Any

from .errors import MissingExtraError, TwistarmError

# Variables by which a shell puts other modules and libraries before those of wheels.
_PATHS = ("PYTHONPATH", "LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH")


@dataclass(frozen=True)
class Wheel:
    """A module, its distribution, a name that no namesake has, and the oldest version."""

    module: str
    distribution: str
    has: str
    oldest: str


def load(wheel: Wheel) -> Any:
    """The module. MissingExtraError if it is not installed. TwistarmError with its file and the remedy if unusable."""
    install = f"pip install '{wheel.distribution}>={wheel.oldest}'"
    try:
        with _installed_modules():
            module = import_module(wheel.module)
    except Exception as error:  # a foreign package may raise whatever it likes
        if isinstance(error, ModuleNotFoundError) and error.name == wheel.module:
            raise MissingExtraError(f"{wheel.module} is not installed; {install}") from error
        spec = find_spec(wheel.module)
        cause = " ".join(str(error).split())[:200] or type(error).__name__
        file, fault = spec and spec.origin, f"cannot be imported ({cause})"
    else:
        file, version = getattr(module, "__file__", None), str(getattr(module, "__version__", wheel.oldest))
        if hasattr(module, wheel.has) and _numbers(version) >= _numbers(wheel.oldest):
            return module
        too_old = f"is version {version}, and twistarm needs {wheel.oldest}"
        fault = too_old if hasattr(module, wheel.has) else f"has no {wheel.has}: it is another project"
    unset = " ".join(f"-u {name}" for name in _PATHS if os.environ.get(name))
    start = f"start with env {unset} twistarm …, or " if unset else ""
    namesake = f"pip uninstall {wheel.module}, then " if wheel.module != wheel.distribution else ""
    raise TwistarmError(f"{wheel.module} at {file or 'an unknown place'} {fault}; {start}{namesake}{install}")


@contextmanager
def _installed_modules() -> Iterator[None]:
    """Leave the current folder out of the module path: a stranger's archive may hold modules."""
    before, here = sys.path[:], os.path.realpath(".")
    sys.path[:] = [folder for folder in before if os.path.realpath(folder) != here]
    try:
        yield
    finally:
        sys.path[:] = before


def _numbers(version: str) -> list[int]:
    return [int(number) for number in re.findall(r"\d+", version)[:3]]
