"""The server under load: many frames, mute and hostile pages, a computer that goes, a process that is killed."""

from __future__ import annotations

import asyncio
import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from contextlib import ExitStack

import pytest

from twistarm.viewer import Viewer
from viewer_page import LOOP, WAIT, Page, target

RATE = 60

LEAST = 0.8  # Share of the frames that arrive on a machine that others use too; the latest always does.


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
        assert page.frames >= LEAST * 2.0 * RATE
        assert page.behind < 0.25


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
