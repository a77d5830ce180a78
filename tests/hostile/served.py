"""A view that is served while it is attacked: in a process of its own, on scales, with an honest page that goes on."""

from __future__ import annotations

import os
import re
import resource
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

from .target import POSE, TEXT, Target, frame

TICK = os.sysconf("SC_CLK_TCK")
PAGE = os.sysconf("SC_PAGE_SIZE")
WAIT = 20.0

TESTS = Path(__file__).parent.parent


@dataclass(frozen=True)
class Served:
    """A process that shows an arm, by the command line."""

    process: subprocess.Popen[str]
    target: tuple[str, int, str]
    said: Path

    def cpu(self) -> float:
        """Seconds of processor time until now."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / TICK

    def megabytes(self) -> float:
        return int(Path(f"/proc/{self.process.pid}/statm").read_text().split()[1]) * PAGE / 1e6

    def descriptors(self) -> int:
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def log(self) -> str:
        """What it wrote to stderr."""
        with self.said.open("rb") as file:
            return file.read(1_000_000).decode("utf-8", "replace")


@contextmanager
def served(
    host: str = "127.0.0.1", descriptors: int = 1024, errors: int | None = None, warm: bool = True
) -> Iterator[Served]:
    """The rover's arm on show. errors: where its stderr goes, a file unless given. warm: as memory shall be weighed."""

    def few() -> None:
        resource.setrlimit(resource.RLIMIT_NOFILE, (descriptors, descriptors))

    with tempfile.TemporaryDirectory() as folder:
        said = Path(folder, "stderr")
        command = [sys.executable, "-m", "twistarm", "view", "rover_arm", "--no-browser", "--host", host]
        with said.open("w") as file:
            process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True, preexec_fn=few,
                stderr=file if errors is None else errors,
            )  # fmt: skip
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            found = re.search(r"http://127\.0\.0\.1:(\d+)/([\w-]+)/", line)
            assert found is not None, line + said.read_text()
            view = Served(process, ("127.0.0.1", int(found[1]), found[2]), said)
            if warm:
                _warm(view)
            yield view
        finally:
            process.terminate()
            try:
                process.wait(WAIT)
            except subprocess.TimeoutExpired:
                process.kill()
            process.communicate()


def _warm(view: Served) -> None:
    """Let a page stay for a while and the doctor look, which takes memory of its own once and for all."""
    with HonestPage(view.target):
        before, since = view.megabytes(), time.monotonic()
        while time.monotonic() - since < 1.5:
            time.sleep(0.1)
            if view.megabytes() > before + 2.0:
                before, since = view.megabytes(), time.monotonic()


class HonestPage:
    """A page of this computer's: its files loaded anew again and again, a socket whose round trips are timed."""

    def __init__(self, target: tuple[str, int, str]) -> None:
        self.target = Target(*target, seconds=3600.0)
        self._socket = self._begun()
        self.trips: list[float] = []
        self.loads: list[float] = []
        self.failures: list[str] = []
        self._stopped = threading.Event()
        self._threads = [threading.Thread(target=each, daemon=True) for each in (self._load, self._talk)]

    def __enter__(self) -> HonestPage:
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._stopped.set()
        for thread in self._threads:
            thread.join(WAIT)

    def _begun(self) -> socket.socket:
        """Its socket, once it has been told all that is on show."""
        one = self.target.upgrade()
        one.settimeout(5.0)
        one.sendall(frame(TEXT, POSE))
        self._until_done(one)
        return one

    def _load(self) -> None:
        while not self._stopped.wait(0.15):
            begin = time.monotonic()
            try:
                for name in ("", "main.js"):
                    self._fetch(name)
                self.target.upgrade().close()
            except (OSError, AssertionError) as error:
                self.failures.append(f"loading: {error or type(error).__name__}")
            else:
                self.loads.append(time.monotonic() - begin)

    def _fetch(self, name: str) -> None:
        with self.target.open() as one:
            one.settimeout(5.0)
            one.sendall(self.target.head(name, Connection="close"))
            answer = b""
            while part := one.recv(65536):
                answer += part
            assert answer.startswith(b"HTTP/1.1 200"), f"{name}: {answer[:60]!r}"

    def _talk(self) -> None:
        try:
            with self._socket as one:
                while not self._stopped.wait(0.02):
                    begin = time.monotonic()
                    one.sendall(frame(TEXT, POSE))
                    self._until_done(one)
                    self.trips.append(time.monotonic() - begin)
        except (OSError, AssertionError) as error:
            self.failures.append(f"its socket: {error or type(error).__name__}")

    def _until_done(self, one: socket.socket) -> None:
        rest = b""
        while b'"done"' not in rest:
            part = one.recv(1 << 20)
            assert part, "was closed"
            rest = rest[-20:] + part


@dataclass(frozen=True)
class Result:
    """What an attack came to, for the honest page and for the process."""

    name: str
    loads: int
    failures: list[str]
    slowest_load: float
    median: float
    worst: float
    cpu: float
    grown: float
    log: int
    descriptors: int

    def fault(self, silent: bool) -> str:
        """What the honest page or its user had to suffer, in words."""
        wrong = [each for each in dict.fromkeys(self.failures) if not each.startswith("loading")][:2]
        wrong += [f"{self.loads} loads"] if self.loads < 1 else []
        wrong += [f"load {self.slowest_load:.1f} s"] if self.slowest_load > 4.0 else []
        wrong += [f"round trip {1e3 * self.median:.0f} ms"] if self.median > 0.5 else []
        wrong += [f"worst round trip {1e3 * self.worst:.0f} ms"] if self.worst > 2.0 else []
        wrong += [f"{self.cpu:.0%} CPU"] if silent and self.cpu > 0.5 else []
        wrong += [f"{self.grown:.0f} MB"] if self.grown > 50 else []
        wrong += [f"{self.log / 1000:.0f} kB of log"] if self.log > 100_000 else []
        return "; ".join(wrong)

    def __str__(self) -> str:
        return (
            f"{self.name:26} {self.loads:3d} loads, {1e3 * self.slowest_load:5.0f} ms; trip {1e3 * self.median:5.1f} / "
            f"{1e3 * self.worst:5.0f} ms; {self.cpu:4.0%} CPU {self.grown:+6.1f} MB {self.log / 1000:7.1f} kB log "
            f"{self.descriptors:4d} fds"
        )


@dataclass
class Trouble:
    """A served view and the attacks on it, one after the other."""

    victim: Served
    results: list[Result] = field(default_factory=list)

    def attack(self, name: str, seconds: float) -> Result:
        """Run the attack in a process of its own beside an honest page, and weigh the server."""
        host, port, token = self.victim.target
        known = token if name.startswith("foreign") else "0" * 22
        command = [sys.executable, "-m", "hostile.network", name, host, str(port), known, str(seconds)]
        cpu, memory, log = self.victim.cpu(), self.victim.megabytes(), len(self.victim.log())
        page = HonestPage(self.victim.target)
        begin = time.monotonic()
        attacker = subprocess.Popen(command, cwd=TESTS, stderr=subprocess.PIPE, text=True)
        try:
            with page:
                most, descriptors = 0.0, 0
                while attacker.poll() is None and time.monotonic() - begin < seconds + WAIT:
                    most = max(most, self.victim.megabytes())
                    descriptors = max(descriptors, self.victim.descriptors())
                    time.sleep(0.1)
        finally:
            attacker.kill()
            _, wrong = attacker.communicate()
        assert not wrong, wrong
        took = time.monotonic() - begin
        trips = page.trips or [99.0]
        result = Result(
            name, len(page.loads), page.failures, max(page.loads, default=99.0), statistics.median(trips), max(trips),
            (self.victim.cpu() - cpu) / took, most - memory, len(self.victim.log()) - log, descriptors,
        )  # fmt: skip
        self.results.append(result)
        return result


def quiet(victim: Served, at_most: int) -> float:
    """Seconds until the server holds no more than so many descriptors; 99 where it keeps them."""
    begin = time.monotonic()
    with suppress(OSError):
        while time.monotonic() - begin < 2 * WAIT:
            if victim.descriptors() <= at_most:
                return time.monotonic() - begin
            time.sleep(0.1)
    return 99.0
