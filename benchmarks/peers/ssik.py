"""ssik: the artifact that it builds for the arm, asked for the solution nearest to the start."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from . import Unfit


class Solver:
    settings = "the artifact of `ssik build`: solve(g, q_seed=start, max_solutions=1)"
    distributions = ("ssik",)

    def __init__(self, robot: dict[str, Any]) -> None:
        self.artifact = _built(robot)

    def solve(self, g: np.ndarray, start: np.ndarray) -> tuple[np.ndarray | None, bool]:
        solutions = self.artifact.solve(g, q_seed=start, max_solutions=1)
        return (solutions[0].q, True) if solutions else (None, False)


def _built(robot: dict[str, Any]) -> Any:
    file = Path(robot["urdf"]).with_name(f"{robot['name']}_ik.py")
    command = [sys.executable, "-c", "from ssik.cli import main; main()", "build", robot["urdf"]]
    command += ["--base", robot["base"], "--ee", robot["tip"], "--out", str(file)]
    build = subprocess.run(command, capture_output=True, text=True)
    if not file.exists():
        raise Unfit((build.stderr.strip().splitlines() or ["ssik build gave no artifact"])[-1])
    specification = importlib.util.spec_from_file_location(file.stem, file)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module
