"""Where hostile descriptions are tried: a secret that must stay unread, a command that must not run, few seconds."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

import pytest

from twistarm.description.expansion import expand
from twistarm.description.packages import package_index
from twistarm.support import worker_process
from twistarm.support.errors import DescriptionError

XMLNS = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
TOKEN = "canary-4711"

TOUCHED = 99
"""The exit code of a process that does what it must not."""

WATCH = f"""
import os, sys
def watch(event, details):
    ran = event in ("os.system", "subprocess.Popen", "os.exec", "os.posix_spawn", "os.fork", "socket.connect")
    if ran or event == "open" and "/outside" in os.fsdecode(details[0] if isinstance(details[0], (str, bytes)) else ""):
        os._exit({TOUCHED})
sys.addaudithook(watch)
"""
"""Ends the process that runs a command, or opens what lies outside."""


class Watched(worker_process.Shared):
    """The worker process under watch."""

    def process(self) -> worker_process.Process:
        with patch.object(worker_process, "PROGRAM", WATCH + worker_process.PROGRAM):
            return super().process()

    def touched(self) -> bool:
        """Whether the last process did what it must not."""
        return self._process is not None and self._process._popen.poll() == TOUCHED


watched = Watched()


@dataclass
class Sandbox:
    """`arm/` holds the description; `outside/` what it must not touch."""

    folder: Path
    seconds: float = expand.SECONDS
    """Processor time of an expansion."""

    @property
    def secret(self) -> Path:
        return self.folder / "outside" / "secret.yaml"

    @property
    def marker(self) -> Path:
        return self.folder / "outside" / "command_ran"

    def fill(self, text: str) -> str:
        """Placeholders for what lies outside."""
        return text.replace("@SECRET", str(self.secret)).replace("@MARKER", str(self.marker))

    def write(self, files: dict[str, str | bytes]) -> None:
        """Files of the description, by their path in `arm/`."""
        for name, content in files.items():
            path = self.folder / "arm" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(self.fill(content).encode() if isinstance(content, str) else content)

    def expand(self, inside: str, files: dict[str, str | bytes] | None = None) -> str:
        """What a robot with `inside` expands to."""
        self.write({"arm.xacro": f'<robot name="r" {XMLNS}>{inside}</robot>', **(files or {})})
        return self.expand_file()

    def expand_file(self) -> str:
        path = self.folder / "arm" / "arm.xacro"
        with patch.multiple(expand, shared=watched, SECONDS=self.seconds):
            return expand.expand_xacro(path, package_index(path))[0]

    def refuse(self, inside: str, files: dict[str, str | bytes] | None = None) -> str:
        """The message with which it is refused: one line, nothing read, nothing run."""
        with pytest.raises(DescriptionError) as caught:
            self.expand(inside, files)
        return self.check(caught.value)

    def check(self, error: DescriptionError) -> str:
        """The error's message, after nothing was found touched."""
        message = str(error)
        assert "\n" not in message
        assert len(message) < 2000
        assert error.findings, "a refusal is a finding too"
        assert TOKEN not in message
        self.untouched()
        return message

    def untouched(self) -> None:
        assert not watched.touched()
        assert not self.marker.exists()


def sandbox(folder: Path) -> Sandbox:
    """A fresh one."""
    made = Sandbox(folder)
    made.secret.parent.mkdir()
    (folder / "arm").mkdir()
    made.secret.write_text(f"key: {TOKEN}\n")
    (made.secret.parent / "secret.xacro").write_text(f'<robot {XMLNS}><link name="{TOKEN}"/></robot>')
    return made


@pytest.fixture
def place(tmp_path: Path) -> Sandbox:
    return sandbox(tmp_path)
