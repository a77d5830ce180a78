"""The built wheel, installed in a fresh environment, run from another directory.

`make test` builds the one without the core, which its own installation has just compiled; `make test-all` both.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from twistarm.arm import engine

ROOT = Path(__file__).parents[2]


# Folders of the checkout, and where they are in the package.
FOLDERS = {"src/twistarm": "", "robots": "robots/", "core/include": "include/"}


@pytest.fixture(scope="module", params=["pure", pytest.param("compiled", marks=pytest.mark.slow)])
def wheel(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The compiled one has the core if it could be compiled for this installation."""
    folder = tmp_path_factory.mktemp("dist")
    environment = {**os.environ, **({"TWISTARM_PURE_PYTHON": "1"} if request.param == "pure" else {})}
    command = [sys.executable, "-m", "build", "--wheel", "--outdir", str(folder), str(ROOT)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    (path,) = folder.glob("*.whl")
    assert path.name.endswith("-py3-none-any.whl") == (request.param == "pure" or engine.core() is None)
    return path


def test_the_wheel_holds_the_package_and_nothing_else(wheel: Path) -> None:
    names = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    core = {name for name in names if name.startswith("twistarm/_core.") and name.endswith(".so")}
    assert len(core) == (0 if wheel.name.endswith("-py3-none-any.whl") else 1)
    assert names - core == {
        f"twistarm/{place}{file.relative_to(ROOT / folder)}"
        for folder, place in FOLDERS.items()
        for file in (ROOT / folder).rglob("*")
        if file.is_file() and file.suffix not in (".pyc", ".so")
    }
    assert {
        "twistarm/py.typed",
        "twistarm/robots/rover_arm/arm.toml",
        "twistarm/include/twistarm/twistarm.hpp",
    } <= names


@pytest.mark.slow
def test_the_installed_wheel_runs_from_another_directory(wheel: Path, tmp_path: Path) -> None:
    """The wheel alone on a path of its own; its dependencies come from the environment of the tests.

    -S: without `site`, because the import hook of an editable installation would answer before any path.
    """
    target = tmp_path / "site"
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", str(target), str(wheel)]
    subprocess.run(command, check=True, capture_output=True, timeout=300)
    program = (
        "import json, twistarm; arm = twistarm.load_arm('rover_arm'); "
        "print(json.dumps([twistarm.__file__, arm.n, str(arm.description.path)]))"
    )
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(target), *filter(None, sys.path)])}
    done = subprocess.run(
        [sys.executable, "-S", "-c", program],
        cwd=elsewhere,
        env=environment,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    where, n, description = json.loads(done.stdout)
    assert where.startswith(str(target))
    assert description.startswith(str(target))
    assert n == 5
    demo = [sys.executable, "-S", "-c", "from twistarm.cli import main; main()", "demo", "--no-view"]
    done = subprocess.run(demo, cwd=elsewhere, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
