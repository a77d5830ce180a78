"""Where hostile descriptions are tried: a secret that must stay unread, a command that must not run, a clock."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from unittest.mock import patch

import pytest

from twistarm.description.expansion import hooks
from twistarm.description.expansion.expand import expand_xacro
from twistarm.description.expansion.work import MAX_WORK, Work
from twistarm.description.packages import package_index
from twistarm.support.errors import DescriptionError

XMLNS = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
CPU_LIMIT = 5.0
WALL_LIMIT = 60.0
TOKEN = "canary-4711"

_watching: list[list[str]] = []


def _note(event: str, details: tuple[object, ...]) -> None:
    if _watching and event in ("open", "os.system", "subprocess.Popen", "os.exec", "os.posix_spawn", "os.fork"):
        _watching[-1].append(f"{event} {os.fspath(details[0]) if isinstance(details[0], (str, Path)) else details[0]}")


sys.addaudithook(_note)


@dataclass
class Sandbox:
    """`arm/` holds the description; `outside/` what it must not touch."""

    folder: Path
    work: int = MAX_WORK // 10
    """A tenth of what is allowed, so that refusing takes a tenth of the time."""
    spent: int = 0
    """Units that the last expansion took."""
    events: list[str] = field(default_factory=list)

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
        work = Work(self.work)
        try:
            with self.watched(), _within(CPU_LIMIT), patch.object(hooks, "Work", lambda: work):
                return expand_xacro(path, package_index(path))[0]
        finally:
            self.spent = self.work - work.left

    @contextmanager
    def watched(self) -> Iterator[None]:
        """Files opened and commands run go into `events`."""
        _watching.append(self.events)
        try:
            yield
        finally:
            _watching.pop()

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
        assert not [event for event in self.events if str(self.folder / "outside") in event]
        assert not [event for event in self.events if not event.startswith("open")]
        assert not self.marker.exists()


@contextmanager
def _within(seconds: float) -> Iterator[None]:
    """Fails after so much processor time, or a minute on the clock for what only waits."""

    def late(number: int, frame: FrameType | None) -> None:
        raise TimeoutError(f"still busy after {seconds} s")

    before = signal.signal(signal.SIGPROF, late), signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    signal.setitimer(signal.ITIMER_REAL, WALL_LIMIT)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGPROF, before[0])
        signal.signal(signal.SIGALRM, before[1])


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
