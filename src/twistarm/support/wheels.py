"""The module of an installed wheel, not the one of the same name that a ROS shell puts before it."""

from __future__ import annotations

import importlib
import os
import re
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Any

from . import shared_libraries
from .errors import TwistarmError

_LOCK = threading.RLock()
"""sys.path belongs to the whole process: one import with another order at a time."""


@dataclass(frozen=True)
class Wheel:
    """A module, the distribution that installs it, and what twistarm asks of whatever answers to the module's name.

    `needs` are names inside the module, dotted where they stand in a submodule; `oldest` is the least version.
    """

    module: str
    distribution: str
    needs: tuple[str, ...]
    oldest: str

    @property
    def command(self) -> str:
        """What installs it."""
        return f"pip install '{self.distribution}>={self.oldest}'"


def load(wheel: Wheel) -> Any:
    """The wheel's module, whatever PYTHONPATH and LD_LIBRARY_PATH hold under its name.

    Of several modules of that name on sys.path the one that pip installed for `wheel.distribution` is imported, with
    the wheel's companions and shared libraries; sys.path is as before afterwards. Where pip installed none, the first
    on sys.path is taken, as Python would. One that the program has imported already is never replaced: it serves if
    it is new enough and has what is needed.

    Raises TwistarmError, in one line, where the module cannot serve: which file, what stands before what, and how to
    start.
    """
    with _LOCK:
        early = wheel.module in sys.modules
        module = importlib.import_module(wheel.module) if early else _import(wheel)
        fault = _fault(module, wheel)
        if fault:
            raise TwistarmError(_unfit(module, wheel, fault, early))
        return module


def _import(wheel: Wheel) -> Any:
    file = _chosen(wheel)
    with _first_on_path(file):
        try:
            if file is not None:
                shared_libraries.load_own(file)
            return importlib.import_module(wheel.module)
        except Exception as error:  # a foreign package may raise whatever it likes
            raise TwistarmError(_not_importable(wheel, file, error)) from error


def _chosen(wheel: Wheel) -> Path | None:
    """The file to import: pip's where there are several."""
    files = _on_path(wheel.module)
    return (_installed(wheel) if len(files) > 1 else None) or next(iter(files), None)


def _on_path(module: str) -> list[Path]:
    """Every file that would answer to `module`, in the order of sys.path."""
    specs = (PathFinder.find_spec(module, [entry]) for entry in sys.path)
    return list(dict.fromkeys(Path(spec.origin) for spec in specs if spec and spec.has_location and spec.origin))


def _installed(wheel: Wheel) -> Path | None:
    """The module's file in the first distribution on sys.path that pip installed and that is new enough."""
    from importlib.metadata import distributions  # 40 ms: only where there is something to decide

    for distribution in distributions(name=wheel.distribution):
        # Installers write a RECORD; what catkin, colcon or a Debian package leave behind has the name without one.
        if distribution.read_text("RECORD") is None or _version(distribution.version) < _version(wheel.oldest):
            continue
        for path in distribution.files or ():
            file = Path(str(distribution.locate_file(path)))
            if path.parts[-2:] == (wheel.module, "__init__.py") and file.is_file():
                return file
    return None


@contextmanager
def _first_on_path(package: Path | None) -> Iterator[None]:
    """The folder of a package stands first on sys.path while the context lasts, for its companions' sake."""
    if package is None or package.name != "__init__.py":
        yield
        return
    folder = str(package.parent.parent)
    sys.path.insert(0, folder)
    try:
        yield
    finally:
        with suppress(ValueError):  # whoever took it away meanwhile has done it
            sys.path.remove(folder)


def _fault(module: Any, wheel: Wheel) -> str:
    """What keeps the module from serving; empty where nothing does."""
    version = str(getattr(module, "__version__", wheel.oldest))
    if _version(version) < _version(wheel.oldest):
        return f"is version {version}, and twistarm needs {wheel.oldest}"
    missing = next((name for name in wheel.needs if not _has(module, name)), None)
    return f"has no {missing}: it is another project, or another version" if missing else ""


def _has(module: Any, dotted: str) -> bool:
    *parents, name = dotted.split(".")
    try:
        return hasattr(importlib.import_module(".".join([module.__name__, *parents])), name)
    except Exception:  # a submodule that cannot be imported has nothing
        return False


def _version(text: str) -> tuple[int, ...]:
    return tuple(int(number) for number in re.findall(r"\d+", text)[:3])


def _unfit(module: Any, wheel: Wheel, fault: str, early: bool) -> str:
    """The line about a module that was imported and cannot serve."""
    file = getattr(module, "__file__", None) or "an unknown place"
    uninstall = f"pip uninstall {wheel.module}" if _is_namesake_installed(wheel) else ""
    own = _installed(wheel)
    if not early or own is None:
        return f"{wheel.module} at {file} {fault}; {uninstall}{', then ' if uninstall else ''}{wheel.command}"
    remedy = _start_without(Path(file)) or uninstall or "take its folder off sys.path"
    return f"{wheel.module} at {file} {fault}; imported before {own}: load an arm before that import, or {remedy}"


def _not_importable(wheel: Wheel, file: Path | None, error: Exception) -> str:
    """The line about a module that cannot be imported."""
    if file is None:
        return f"{wheel.module} is not installed; {wheel.command}"
    cause = " ".join(str(error).split())[:200] or type(error).__name__
    remedy = wheel.command if _installed(wheel) is None else f"pip install --force-reinstall {wheel.distribution}"
    return f"{wheel.module} at {file} cannot be imported ({cause}); {_obstacle(file) or remedy}"


def _obstacle(package: Path) -> str:
    """What stands before what the package needs, and the remedy; empty where nothing is seen."""
    for own in sorted(package.parents[1].glob("*/__init__.py")) if shared_libraries.is_own(package) else ():
        stranger = getattr(sys.modules.get(own.parent.name), "__file__", None)
        if stranger and os.path.realpath(stranger) != os.path.realpath(own):
            remedy = _start_without(Path(stranger)) or f"start without {stranger}"
            return f"{stranger} was imported before {own}: load an arm before that import, or {remedy}"
    for library, own in shared_libraries.shadowed(package):
        return f"{library} ({shared_libraries.SEARCHED_FIRST}) stands before {own}: start with {_clean_command()}"
    return _old_numpy()


def _old_numpy() -> str:
    import numpy

    if _version(numpy.__version__) >= (2,):
        return ""
    remedy = _start_without(Path(numpy.__file__)) or "pip install 'numpy>=2'"
    return f"NumPy {numpy.__version__} at {numpy.__file__} is older than 2.0: {remedy}"


def _start_without(file: Path) -> str:
    """How to start without a file that PYTHONPATH brought; empty where something else did."""
    entries = (Path(entry).absolute() for entry in os.environ.get("PYTHONPATH", "").split(os.pathsep) if entry)
    return f"start with {_clean_command()}" if any(file.is_relative_to(entry) for entry in entries) else ""


def _clean_command() -> str:
    """How to run without the shell's paths: `env -u PYTHONPATH -u LD_LIBRARY_PATH twistarm …`."""
    variables = (name for name in ("PYTHONPATH", shared_libraries.SEARCHED_FIRST) if os.environ.get(name))
    program = "twistarm" if Path(sys.argv[0]).stem == "twistarm" else "python"
    return f"env {' '.join(f'-u {name}' for name in variables)} {program} …"


def _is_namesake_installed(wheel: Wheel) -> bool:
    """Whether pip installed another project under the module's name, as the registry has one named `pinocchio`."""
    from importlib.metadata import distributions

    others = distributions(name=wheel.module) if wheel.module != wheel.distribution else ()
    return any(other.read_text("RECORD") is not None for other in others)
