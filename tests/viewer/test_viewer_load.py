"""The server under load: many frames, mute and hostile pages, a computer that goes, a process that is killed."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
from contextlib import ExitStack
from urllib.parse import urlsplit

import pytest

from twistarm.viewer import Viewer
from viewer_page import WAIT, Page, address, connection

HANDSHAKE = (
    "GET {} HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)


def test_pages_that_never_read_do_not_keep_frames_from_the_others(viewer: Viewer) -> None:
    with ExitStack() as stack:
        for _ in range(5):
            mute = stack.enter_context(connection(viewer, receive=4096))
            mute.sendall(HANDSHAKE.format(urlsplit(address(viewer)).path).encode())
            mute.recv(1)
        page = stack.enter_context(Page(viewer))
        for k in range(1, 121):
            viewer.show([0.0, 0.0, k / 2**16])
        page.until(lambda: page.latest["frame"]["theta"][2] == 120 / 2**16)


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
