"""The view under attack: an honest page goes on and is answered while strangers do their worst."""

from __future__ import annotations

import os
import re
import resource
import socket
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from hostile.target import HANDSHAKE, POSE, Target, frame
from twistarm import Arm
from twistarm.control.stream import UdpSource

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="processes are weighed by /proc")

SECONDS = 2.0


@pytest.fixture(autouse=True)
def _many_descriptors() -> Iterator[None]:
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(4096, before[1]) if before[1] > 0 else 4096, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, before)


@contextmanager
def served() -> Iterator[tuple[int, int, str]]:
    """The rover's arm on show, by the command line: the process, the port, the token."""
    process = subprocess.Popen(
        [sys.executable, "-m", "twistarm.cli", "view", "rover_arm", "--no-browser"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
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


def crumbs(target: Target) -> None:
    """Heads of which a byte comes at a time, and refusals that nobody reads."""
    held = [target.open(receive=4096) for _ in range(30)]
    while target.on():
        for one in held:
            with suppress(OSError):
                one.send(b"a", socket.MSG_DONTWAIT)
    for one in held:
        one.close()


def asking(head: Callable[[Target], bytes]) -> Callable[[Target], None]:
    """The same request over and over, as fast as it goes."""

    def ask(target: Target) -> None:
        while target.on():
            with suppress(OSError), target.open() as one:
                one.sendall(head(target))
                one.recv(4096)

    return ask


STRANGERS: dict[str, Callable[[Target], None]] = {
    "crumbs": crumbs,
    "a huge head": asking(lambda target: b"GET / HTTP/1.1\r\nX: " + b"a" * 2_000_000),
    "pipelined requests": asking(lambda target: target.head("/stranger/") * 1000),
    "frames before the answer": asking(
        lambda target: target.head("/stranger/socket", **HANDSHAKE) + frame(POSE) * 1000
    ),
}


@pytest.mark.parametrize(
    "name", [name if name == "crumbs" else pytest.param(name, marks=pytest.mark.slow) for name in STRANGERS]
)
def test_the_honest_page_goes_on_whatever_is_done(name: str) -> None:
    honest = Honest()
    with served() as (pid, port, token):
        target, stranger = Target("127.0.0.1", port, token, 3600.0), Target("127.0.0.1", port, "0" * 22, SECONDS)
        before = megabytes(pid)
        attack = threading.Thread(target=STRANGERS[name], args=(stranger,))
        with target.upgrade() as page:
            _ask(page)
            attack.start()
            while attack.is_alive():
                honest.goes_on(target, page)
                time.sleep(0.05)
        assert 0.0 < max(honest.loads, default=0.0) < 4.0
        assert statistics.median(honest.trips) < 0.5
        assert max(honest.trips) < 2.0
        assert megabytes(pid) < before + 100.0


def megabytes(pid: int) -> float:
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


FLOODS = {
    "crumbs": b"x",
    "deep": b'{"type":' + b"[" * 60_000,
    "numbers": b'{"theta":[' + b"0," * 30_000 + b"0]}",
    "digits": b'{"theta":[1' + b"0" * 60_000 + b"]}",
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
