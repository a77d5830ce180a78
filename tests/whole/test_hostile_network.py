"""The view under attack: an honest page goes on and is answered while strangers do their worst."""

from __future__ import annotations

import os
import socket
import statistics
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import pytest

from hostile.network import SILENT
from hostile.served import Result, Trouble, quiet, served
from hostile.strangers import STRANGERS
from twistarm import Arm
from twistarm.control.stream import UdpSource

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="processes are weighed by /proc")

SECONDS = 3.0


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


def test_idle_connections_and_a_stuck_terminal_do_not_stop_the_page() -> None:
    with full_pipe() as errors, served(descriptors=256, errors=errors, warm=False) as view:
        result = Trouble(view).attack("idle", 1.5)
        assert [each for each in result.failures if not each.startswith("loading")] == []
        assert result.log == 0
        assert result.loads >= 2
        assert result.median < 0.1
        assert result.descriptors < 200


@pytest.mark.slow
def test_the_honest_page_goes_on_whatever_is_done() -> None:
    """Where the machine was busy with something else, an attack has a second try."""
    results: list[Result] = []
    faults: list[str] = []
    with served("0.0.0.0") as view:
        trouble, resting = Trouble(view), view.descriptors()
        for name in STRANGERS:
            for _ in range(2):
                result = trouble.attack(name, SECONDS)
                if not (fault := result.fault(name in SILENT)):
                    break
            results.append(result)
            faults += [f"{name}: {fault}"] if fault else []
        if quiet(view, resting + 2) > 35:
            faults.append(f"{view.descriptors() - resting} descriptors kept")
        print(view.log())
    print(f"\nnetwork: {len(results)} attacks, {len(faults)} faults", *results, sep="\n")
    assert faults == []


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
        print(f"\n{flood}: {1e3 * statistics.median(spent):.2f} ms, at most {1e3 * max(spent):.2f} ms")
        assert statistics.median(spent) < 0.005
