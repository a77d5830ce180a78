"""The server under load: many frames, mute and hostile pages, a computer that goes, a process that is killed."""

from __future__ import annotations

import asyncio
import gc
import json
import os
import random
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import tracemalloc
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import pytest
from numpy.testing import assert_array_equal

import schema_samples as samples
from twistarm.support.strict_json import LARGEST_MESSAGE
from twistarm.viewer import Viewer
from twistarm.viewer.protocol.messages import SCHEMA
from viewer_page import LOOP, WAIT, Page, target, until

RATE = 60

LEAST = 0.8
"""Share of the frames that arrive on a machine that others use too; the latest always does."""

FLAT = 300_000
"""Bytes: what the interpreter itself keeps and drops; a leak of 100 bytes a message would be three times that after ten
thousand messages."""


@contextmanager
def flat_memory(viewer: Viewer) -> Iterator[None]:
    """Python's memory soon after the block is what it was before; the doctor, who imports and reads, has looked."""
    with Page(viewer) as page:
        page.until(lambda: page.latest.get("findings", {}).get("note") == "")
    tracemalloc.start()
    before = collected()
    try:
        yield
        until(lambda: collected() - before < FLAT)  # a socket takes a moment to close, a leak stays
    finally:
        tracemalloc.stop()


def collected() -> int:
    gc.collect()
    return tracemalloc.get_traced_memory()[0]


class Counter(Page):
    """A page that counts its frames and notes when the latest came."""

    frames, behind = 0, 0.0

    async def count(self, last: float, sent: dict[float, float]) -> None:
        while self.latest["frame"]["theta"][2] != last:
            message = await asyncio.wait_for(self.connection.read_message(), WAIT)
            assert message is not None, "the socket was dropped"
            self.latest[json.loads(message)["type"]] = told = json.loads(message)
            if told["type"] == "frame":
                self.frames += 1
                at = sent.get(told["theta"][2])
                self.behind = max(self.behind, 0.0 if at is None else time.monotonic() - at)


def post_frames(viewer: Viewer, seconds: float, sent: dict[float, float]) -> None:
    begin = time.monotonic()
    for k in range(int(seconds * RATE)):
        time.sleep(max(0.0, begin + k / RATE - time.monotonic()))
        value = (k + 1) / 2**16
        sent[value] = time.monotonic()
        viewer.show([0.0, 0.0, value])


def watch_frames(viewer: Viewer, pages: int, seconds: float) -> list[Counter]:
    """Post frames for so many seconds, and let so many pages count them."""
    opened = [Counter(viewer) for _ in range(pages)]
    sent: dict[float, float] = {}
    poster = threading.Thread(target=post_frames, args=(viewer, seconds, sent))
    poster.start()
    last = int(seconds * RATE) / 2**16
    counting = [asyncio.run_coroutine_threadsafe(page.count(last, sent), LOOP) for page in opened]
    for page, counted in zip(opened, counting, strict=True):
        counted.result(seconds + WAIT)
        page.close()
        page.objects.clear()
        page.latest.clear()
    poster.join()
    return opened


# many frames ------------------------------------------------------------------------------------------


@pytest.mark.alone
def test_pages_that_never_read_neither_grow_nor_delay_the_others(viewer: Viewer) -> None:
    with ExitStack() as stack:
        for _ in range(5):
            stack.enter_context(target(viewer).upgrade(receive=4096))
        (page,) = watch_frames(viewer, 1, 2.0)
        with flat_memory(viewer):
            watch_frames(viewer, 1, 1.0)
        assert page.frames >= LEAST * 2.0 * RATE
        assert page.behind < 0.25


# hostile messages -------------------------------------------------------------------------------------


def hostile() -> list[str | bytes]:
    """Every request of the schema spoilt in every way, shuffled; none of them is valid."""
    spoilt = [text for kind in SCHEMA["requests"] for text in samples.spoilt(kind) if len(text) < LARGEST_MESSAGE]
    random.Random(0).shuffle(spoilt)
    return spoilt


@pytest.mark.slow
def test_hostile_messages_leave_the_server_alive_and_its_memory_flat(viewer: Viewer) -> None:
    messages = (hostile() * 10)[:10_000]

    def flood(texts: list[str | bytes]) -> None:
        with Page(viewer) as page:
            for first in range(0, len(texts), 100):
                for text in texts[first : first + 100]:
                    page.send(text)
                page.ask(type="pose", name="zero", ease=False)  # a page that reads nothing would answer no ping

    flood(messages[:1000])
    with flat_memory(viewer):
        flood(messages)
    assert_array_equal(viewer.theta, [0, 0, 0])


# the end of a process ---------------------------------------------------------------------------------


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no process groups to look into")
@pytest.mark.usefixtures("hangups")
@pytest.mark.parametrize(
    "end", [signal.SIGTERM, *(pytest.param(end, marks=pytest.mark.slow) for end in (signal.SIGKILL, signal.SIGHUP))]
)
def test_an_ended_process_leaves_nothing_running(end: signal.Signals) -> None:
    program = "from twistarm.cli import main; main()"
    command = [sys.executable, "-c", program, "view", "rover_arm", "--no-browser"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True)
    try:
        assert process.stdout is not None
        match = re.search(r"http://127\.0\.0\.1:(\d+)/", process.stdout.readline())
        assert match is not None
        port = int(match[1])
        with socket.create_connection(("127.0.0.1", port), timeout=WAIT):
            os.kill(process.pid, end)
            assert process.wait(WAIT) == -end
        with pytest.raises(ProcessLookupError):
            os.killpg(process.pid, 0)  # nobody is left in its group
        with pytest.raises(OSError, match="refused"):
            socket.create_connection(("127.0.0.1", port))
    finally:
        process.kill()
        process.communicate()
