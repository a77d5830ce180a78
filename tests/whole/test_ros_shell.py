"""Inside a ROS shell that puts its own modules and libraries first, one line says how to start, and so it starts."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from stub_packages import package

COMMAND = "import sys; sys.argv[0] = 'twistarm'; from twistarm.cli import main; main()"
FK = ("fk", "rover_arm", "--theta", "zero", "--json")


def run(program: str = COMMAND, **shell: str) -> subprocess.CompletedProcess[str]:
    """twistarm in a fresh interpreter, with the shell's variables."""
    return subprocess.run(
        [sys.executable, "-c", program, *FK],
        capture_output=True,
        text=True,
        timeout=60,
        env=os.environ | shell,
        check=False,
    )


def assert_the_remedy_works(**shell: str) -> None:
    done = run(**shell)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    remedy = re.search(r"start with env ((-u \w+ ?)+)twistarm …", done.stderr)
    assert remedy, done.stderr
    unset = remedy[1].replace("-u", "").split()
    assert set(shell) <= set(unset)
    clean = {name: value for name, value in os.environ.items() if name not in unset}
    again = subprocess.run([sys.executable, "-c", COMMAND, *FK], capture_output=True, timeout=60, env=clean)
    assert again.returncode == 0


NO_LIBRARY = "raise ImportError('libboost_python310.so.1.74.0: cannot open shared object file')\n"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("pinocchio", ""),
        pytest.param("pinocchio", NO_LIBRARY, marks=pytest.mark.slow),
        pytest.param("xacro", "", marks=pytest.mark.slow),
    ],
    ids=["another project", "no library", "another xacro"],
)
def test_a_foreign_module(tmp_path: Path, name: str, text: str) -> None:
    assert_the_remedy_works(PYTHONPATH=str(package(tmp_path, name, text)))


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "darwin", reason="macOS takes DYLD_LIBRARY_PATH from what it starts")
def test_foreign_libraries(tmp_path: Path) -> None:
    import pinocchio

    libraries = Path(pinocchio.__file__).parents[3]
    shutil.copy(next(libraries.glob("libqhull*.so")), tmp_path / "libeigenpy.so")
    assert_the_remedy_works(LD_LIBRARY_PATH=str(tmp_path))


@pytest.mark.slow
def test_ros_2s_xacro_serves(tmp_path: Path) -> None:
    """It is the registry's code, at another place."""
    import xacro

    shutil.copytree(Path(xacro.__file__).parent, tmp_path / "xacro")
    program = f"import xacro; assert xacro.__file__.startswith({str(tmp_path)!r}); {COMMAND}"
    done = run(program, PYTHONPATH=str(tmp_path))
    assert (done.returncode, done.stderr) == (0, "")
