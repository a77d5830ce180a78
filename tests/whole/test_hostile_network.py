"""The view under attack: an honest page goes on and is answered while strangers do their worst."""

from __future__ import annotations

import os
import random
import re
import resource
import socket
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from hostile.strangers import STRANGERS
from hostile.target import POSE, Target, frame
from twistarm import Arm
from twistarm.control.stream import UdpSource

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="processes are weighed by /proc")

SECONDS = 3.0


@pytest.fixture(autouse=True)
def _many_descriptors() -> Iterator[None]:
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(4096, before[1]) if before[1] > 0 else 4096, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, before)


@contextmanager
def full_pipe() -> Iterator[int]:
    """What a program may have for stderr: a pipe that nobody reads."""
    end, begin = os.pipe()
    os.set_blocking(begin, False)
    try:
        while True:
            os.write(begin, b"x" * 4096)
    except BlockingIOError:
        os.set_blocking(begin, True)
        yield begin
    finally:
        os.close(end)
        os.close(begin)


@contextmanager
def served(errors: int) -> Iterator[tuple[int, int, str]]:
    """The rover's arm on show, by the command line: the process, the port, the token."""
    process = subprocess.Popen(
        [sys.executable, "-m", "twistarm", "view", "rover_arm", "--no-browser"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=errors,
        text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (1024, 1024)),
    )
    try:
        assert process.stdout is not None
        found = re.search(r"http://127\.0\.0\.1:(\d+)/([\w-]+)/", process.stdout.readline())
        assert found is not None
        yield process.pid, int(found[1]), found[2]
    finally:
        process.kill()
        process.communicate()


@dataclass
class Honest:
    """Seconds that a page took, for each load and for each round trip on its socket."""

    loads: list[float] = field(default_factory=list)
    trips: list[float] = field(default_factory=list)

    def goes_on(self, target: Target, page: socket.socket) -> None:
        began = time.monotonic()
        with suppress(OSError), target.open() as one:  # at times a stranger is there first
            one.sendall(target.head(Connection="close"))
            if _read(one).startswith(b"HTTP/1.1 200"):
                self.loads.append(time.monotonic() - began)
        began = time.monotonic()
        _ask(page)
        self.trips.append(time.monotonic() - began)


def _read(one: socket.socket) -> bytes:
    return b"".join(iter(lambda: one.recv(65536), b""))


def _ask(page: socket.socket) -> None:
    page.sendall(frame(POSE))
    rest = b""
    while b'"done"' not in rest:
        part = page.recv(1 << 20)
        assert part, "was closed"
        rest = rest[-20:] + part


def attacked(name: str, port: int, token: str, seconds: float) -> Honest:
    """What an honest page has beside an attack."""
    honest, target = Honest(), Target("127.0.0.1", port, token, 3600.0)
    stranger = Target("127.0.0.1", port, token if name.startswith("foreign") else "0" * 22, seconds)
    random.seed(name)
    attack = threading.Thread(target=STRANGERS[name], args=(stranger,))
    with target.upgrade() as page:
        _ask(page)
        attack.start()
        while attack.is_alive():
            honest.goes_on(target, page)
            time.sleep(0.05)
    for one in stranger.held:
        one.close()
    return honest


def test_a_stuck_terminal_does_not_stop_the_page() -> None:
    with full_pipe() as errors, served(errors) as (_, port, token):
        honest = attacked("slow_head", port, token, 1.5)
        assert len(honest.loads) >= 2
        assert statistics.median(honest.trips) < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("name", STRANGERS)
def test_the_honest_page_goes_on_whatever_is_done(name: str, tmp_path: Path) -> None:
    with (tmp_path / "stderr").open("wb") as errors, served(errors.fileno()) as (pid, port, token):
        before = megabytes(pid)
        honest = attacked(name, port, token, SECONDS)
        assert 0.0 < max(honest.loads, default=0.0) < 4.0
        assert statistics.median(honest.trips) < 0.5
        assert max(honest.trips) < 2.0
        assert megabytes(pid) < before + 100.0
        assert errors.tell() < 100_000


def megabytes(pid: int) -> float:
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


FLOODS = {
    "crumbs": b"x",
    "large": b"x" * 60_000,
    "deep": b'{"type":' + b"[" * 60_000,
    "numbers": b'{"theta":[' + b"0," * 30_000 + b"0]}",
    "names": b"{" + b",".join(b'"%d":0' % k for k in range(7000)) + b"}",
    "digits": b'{"theta":[1' + b"0" * 60_000 + b"]}",
    "bells": b"\x07" * 60_000,
}


@pytest.mark.slow
@pytest.mark.parametrize("flood", FLOODS)
def test_a_cycle_stays_short_while_datagrams_come_without_end(flood: str, rover: Arm) -> None:
    """At 100 Hz a cycle has 10 ms; what arrives may take half of them, in the processor's time."""
    with UdpSource(rover) as source, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        spent = []
        for _ in range(50):
            with suppress(BlockingIOError):
                for _ in range(200):
                    sender.sendto(FLOODS[flood], socket.MSG_DONTWAIT, source.address)
            begin = time.thread_time()
            reading = source.read(time.monotonic())
            spent.append(time.thread_time() - begin)
        assert reading.command is None
        assert statistics.median(spent) < 0.005
