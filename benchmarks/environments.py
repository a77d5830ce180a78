"""An environment for each peer with a requirements-<peer>.txt; the others run in this one."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

REQUIREMENTS = Path(__file__).parent
DEFAULT_FOLDER = Path(__file__).parent / ".environments"


class NotInstalled(Exception):  # noqa: N818
    """Why a peer cannot be installed here, in one line."""


def python_of(peer: str, folder: Path, say: Callable[[str], None], requirements: Path = REQUIREMENTS) -> Path:
    """The interpreter that runs a peer. Makes its environment in `folder` if it is missing or out of date."""
    file = requirements / f"requirements-{peer}.txt"
    if not file.exists():
        return Path(sys.executable)
    place = folder.absolute() / peer
    python = place / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    stamp, wanted = place / "installed.txt", f"Python {sys.version}\n{file.read_text()}"
    if not stamp.exists() or stamp.read_text() != wanted:
        say(f"installing {', '.join(file.read_text().split())} into {place} ...")
        _make(place, python, file)
        stamp.write_text(wanted)
    return python


def _make(place: Path, python: Path, requirements: Path) -> None:
    _run([sys.executable, "-m", "venv", "--clear", "--without-pip", str(place)])
    pip = [sys.executable, "-m", "pip", "--python", str(python), "--disable-pip-version-check"]
    _run([*pip, "install", "--quiet", "--requirement", str(requirements)])


def _run(command: list[str]) -> None:
    process = subprocess.run(command, capture_output=True, text=True, errors="replace")
    if process.returncode:
        lines = (process.stderr or process.stdout).strip().splitlines() or [f"{command[0]} failed"]
        raise NotInstalled(next((line for line in lines if line.startswith("ERROR")), lines[-1]))
