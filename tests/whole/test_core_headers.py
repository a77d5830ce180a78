"""The core's headers by themselves: their C++ tests, compiled and run on every instruction set, with sanitizers too."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from needed import COMPILER, absent
from twistarm.arm import engine

TESTS = Path(__file__).parents[2] / "core" / "tests"

EVERY_SIZE = "1,2,3,4,5,6,7,8"

# What compiles in seconds unoptimised, and what the tests in Python do not see.
QUICK = "lanes elementary ldl ranges singular_directions motion_limits"


@pytest.fixture(scope="session")
def compiler() -> str:
    """A C++ compiler, and make; without them the tests skip, or fail where nothing may be skipped."""
    if not COMPILER or not shutil.which("make"):
        absent(f"no {'make' if COMPILER else 'C++ compiler'}: the core's own tests are not compiled")
    return COMPILER


def check(compiler: str, build: Path, *settings: str) -> None:
    """Compiles and runs the tests; what fails is told as the compiler and they told it."""
    command = ["make", "-s", "-j2", "-C", str(TESTS), "check", f"CXX={compiler}", f"BUILD={build}", *settings]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout[-4000:]}\n{done.stderr[-4000:]}"


def instruction_sets() -> list[str]:
    """Of the processor; the compiled core's names for them, but for its baseline, which here needs no flags."""
    core = engine.core()
    names = ["baseline"] if core is None else core.instruction_sets()
    return ["portable" if name == "baseline" else name for name in names]


def test_the_headers(compiler: str, tmp_path: Path) -> None:
    check(compiler, tmp_path, f"TESTS={QUICK}", "EXTRA=-O0")


@pytest.mark.slow
@pytest.mark.parametrize("instructions", ["portable", "avx2", "avx512"])
@pytest.mark.parametrize(("mode", "sizes"), [("quick", EVERY_SIZE), ("sanitized", "3")])
def test_the_headers_on(compiler: str, tmp_path: Path, instructions: str, mode: str, sizes: str) -> None:
    if instructions not in instruction_sets():
        pytest.skip(f"this processor has no {instructions}")
    check(compiler, tmp_path, f"SET={instructions}", f"MODE={mode}", f"SIZES={sizes}")
