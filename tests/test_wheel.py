"""The built wheel, installed in a fresh environment, run from another directory."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from twistarm import engine

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "build", "--wheel", "--outdir", str(folder), str(ROOT)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    (path,) = folder.glob("*.whl")
    return path


def test_the_wheel_holds_robots_lessons_and_the_page(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    assert {"twistarm/py.typed", "twistarm/robots/rover_arm/arm.toml", "twistarm/viewer/page/index.html"} <= names
    assert any(name.startswith("twistarm/examples/guide/") and name.endswith(".py") for name in names)
    assert any(name.startswith("twistarm/_core.") and name.endswith(".so") for name in names) == bool(engine.core())
    assert not any("/tests/" in name or name.startswith("tests/") for name in names)


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
    assert {file.name for file in elsewhere.iterdir()} == {"demo.html", "demo.csv"}
