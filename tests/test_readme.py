"""Everything printed in the README is executed."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from twistarm.cli import application

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text("utf-8")
BLOCKS = re.findall(r"(?:<!-- (?P<mark>[a-z_./ ]+) -->\n)?```(?P<kind>\w+)\n(?P<text>.*?)```", README, flags=re.S)

PROGRAMS = [text for mark, kind, text in BLOCKS if kind == "python"]
COMMANDS = [
    line
    for mark, kind, text in BLOCKS
    if kind == "sh" and mark not in ("serves", "installs", "recurses")
    for line in text.splitlines()
    if line.strip() and not line.startswith("#")
]
FILES = {mark.removeprefix("file "): text for mark, _, text in BLOCKS if mark.startswith("file ")}
PRINTED = [text for mark, _, text in BLOCKS if mark == "output"]


def laid_out(folder: Path) -> Path:
    """A folder as the tour begins with: the reader's own arm in `my_arm/`, and the files that are shown."""
    robot = ROOT / "robots" / "rover_arm"
    (folder / "my_arm").mkdir()
    for file in robot.glob("*.xacro"):
        name = "my_arm.urdf.xacro" if file.name == "rover_arm.urdf.xacro" else file.name
        (folder / "my_arm" / name).write_bytes(file.read_bytes())
    for file, text in FILES.items():
        (folder / file).write_text(text, "utf-8")
    return folder


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder as the tour has it, in which everything is run in its order."""
    return laid_out(tmp_path_factory.mktemp("tour"))


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the tour's golden file and header are written: tests may run apart from each other."""
    folder = laid_out(tmp_path_factory.mktemp("kept"))
    for line in COMMANDS:
        if arguments_of(line)[0] in ("freeze", "bake"):
            assert run(line, folder).returncode == 0, line
    return folder


def arguments_of(line: str) -> list[str]:
    program, *arguments = shlex.split(line, comments=True)
    assert program == "twistarm", f"a command the tests do not know: {line}"
    return arguments


def run(line: str, folder: Path) -> subprocess.CompletedProcess[str]:
    command = [Path(sys.executable).with_name("twistarm"), *arguments_of(line)]
    # As this process sees it: readline, which pytest loads, tells children alone of a terminal 80 columns wide.
    environment = dict(os.environ)
    return subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=120, check=False, env=environment
    )


def test_the_readme_has_programs_and_commands() -> None:
    assert len(PROGRAMS) >= 2
    assert len(COMMANDS) >= 8


def test_every_command(workspace: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """In the order of the README, in one folder: later ones use what earlier ones wrote.

    In this process, because to start one takes longer than the command; the other tests here start it.
    """
    monkeypatch.chdir(workspace)
    for line in COMMANDS:
        code, printed = application.run(arguments_of(line)), capsys.readouterr()
        assert code == 0, f"{line}\n{printed.out}\n{printed.err}"


def test_what_is_printed_is_what_is_shown(workspace: Path) -> None:
    assert PRINTED
    for text in PRINTED:
        command, _, shown = text.partition("\n")
        printed = run(command.removeprefix("$ "), workspace).stdout
        assert [line.rstrip() for line in printed.splitlines()] == shown.splitlines()


def test_an_arm_file_with_everything_in_it(workspace: Path) -> None:
    done = run("twistarm info my_arm/our_arm.toml", workspace)
    assert done.returncode == 0, done.stderr
    assert "our_arm: 4 degrees of freedom from base_link to pen" in done.stdout
    assert "4096" in done.stdout


def test_every_program(kept: Path) -> None:
    for text in PROGRAMS:
        done = subprocess.run([sys.executable, "-c", text], cwd=kept, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, f"{text}\n{done.stderr}"


def test_the_program_in_cpp(kept: Path) -> None:
    """Written by the commands of the README, which leave the header there."""
    compiler = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    if compiler is None:
        if os.environ.get("TWISTARM_REQUIRE_ALL"):
            pytest.fail("no C++ compiler, and TWISTARM_REQUIRE_ALL is set")
        pytest.skip("no C++ compiler")
    done = run("twistarm bake my_arm/my_arm.urdf.xacro -o my_arm.hpp --force", kept)
    folder = done.stdout.split("-I ")[1].strip()
    command = [compiler, "-std=c++17", "-O1", "-I", folder, "main.cpp", "-o", "main"]
    built = subprocess.run(command, cwd=kept, capture_output=True, text=True, timeout=300, check=False)
    assert built.returncode == 0, built.stderr
    assert subprocess.run(["./main"], cwd=kept, timeout=60, check=False).returncode == 0


def test_the_pictures_exist() -> None:
    for file in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", README):
        assert (ROOT / file).is_file(), file
