"""Everything printed in the README is executed."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text("utf-8")
BLOCKS = re.findall(r"(?:<!-- (?P<mark>[a-z ]+) -->\n)?```(?P<kind>\w+)\n(?P<text>.*?)```", README, flags=re.S)

PROGRAMS = [text for mark, kind, text in BLOCKS if kind == "python"]
COMMANDS = [
    line
    for mark, kind, text in BLOCKS
    if kind == "sh" and mark not in ("serves", "installs", "recurses")
    for line in text.splitlines()
    if line.strip() and not line.startswith("#")
]


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder as the tour has it: the reader's own arm in `my_arm/`, everything run in its order."""
    folder = tmp_path_factory.mktemp("tour")
    robot = ROOT / "robots" / "rover_arm"
    (folder / "my_arm").mkdir()
    for file in robot.glob("*.xacro"):
        name = "my_arm.urdf.xacro" if file.name == "rover_arm.urdf.xacro" else file.name
        (folder / "my_arm" / name).write_bytes(file.read_bytes())
    return folder


def test_the_readme_has_programs_and_commands() -> None:
    assert len(PROGRAMS) >= 2
    assert len(COMMANDS) >= 8


def test_every_command(workspace: Path) -> None:
    """In the order of the README, in one folder: later ones use what earlier ones wrote."""
    for line in COMMANDS:
        program, *arguments = shlex.split(line, comments=True)
        assert program == "twistarm", f"a command the tests do not know: {line}"
        path = Path(sys.executable).with_name("twistarm")
        done = subprocess.run(
            [path, *arguments], cwd=workspace, capture_output=True, text=True, timeout=120, check=False
        )
        assert done.returncode == 0, f"{line}\n{done.stdout}\n{done.stderr}"


def test_every_program(workspace: Path) -> None:
    for text in PROGRAMS:
        done = subprocess.run([sys.executable, "-c", text], cwd=workspace, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, f"{text}\n{done.stderr}"


def test_the_pictures_exist() -> None:
    for file in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", README):
        assert (ROOT / file).is_file(), file
