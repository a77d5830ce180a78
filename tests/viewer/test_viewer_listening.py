"""The view's connections: one cap, in which pages stay, time-outs, and files under way."""

from __future__ import annotations

import socket
import threading
import time
from contextlib import ExitStack
from dataclasses import replace

import pytest

from hostile.target import HANDSHAKE, Target
from twistarm import Arm
from twistarm.viewer import Viewer
from twistarm.viewer.server import listening
from twistarm.viewer.server.downloads import DOWNLOADS
from twistarm.viewer.server.handlers import MOST_FILES
from viewer_page import WAIT, Page, get, port_of, until, visit


def target(viewer: Viewer) -> Target:
    return Target("127.0.0.1", port_of(viewer), viewer.url.split("/")[3], WAIT)


def is_closed(one: socket.socket) -> bool:
    """Whether the other side has ended it."""
    one.settimeout(WAIT)
    try:
        while one.recv(1 << 20):
            pass
    except TimeoutError:
        return False
    except ConnectionError:
        pass
    return True


@pytest.mark.parametrize("sent", [b"", b"GET / HTT", b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: y"])
def test_who_sends_no_request_in_time_is_closed(arm: Arm, sent: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(listening, "IDLE_TIME", 0.3)
    with Viewer(arm, open_browser=False) as viewer, target(viewer).open() as one:
        one.sendall(sent)
        assert is_closed(one)


@pytest.mark.parametrize("path", ["/stranger/", ""])
@pytest.mark.parametrize("method", ["POST", "PUT", "GET"])
def test_a_body_is_not_waited_for(viewer: Viewer, method: str, path: str) -> None:
    there = target(viewer)
    with there.open() as one:
        one.sendall(there.head(path, method, Content_Length="60000") + b"a")
        assert one.recv(12) == b"HTTP/1.1 400"
        assert is_closed(one)


def test_who_waits_outside_gives_way_and_pages_stay(viewer: Viewer) -> None:
    there = target(viewer)

    async def outlive(page: Page) -> None:
        with ExitStack() as stack:
            waiting = [stack.enter_context(there.open()) for _ in range(listening.MOST_CONNECTIONS + 5)]
            assert get(viewer.url)[0] == 200
            assert all(map(is_closed, waiting[:5]))
            waiting[-1].sendall(there.head("nothing.js"))
            assert waiting[-1].recv(12) == b"HTTP/1.1 404"
        await page.ask(type="pose", name="zero", ease=False)

    assert visit(viewer, outlive).latest["frame"]["theta"] == [0, 0, 0]


def test_where_all_are_pages_the_next_is_closed_until_one_goes(viewer: Viewer) -> None:
    there = target(viewer)
    pages = there.crowd(listening.MOST_CONNECTIONS, there.upgrade)
    assert len(pages) == listening.MOST_CONNECTIONS
    with there.open() as one:
        one.sendall(there.head("socket", **HANDSHAKE))
        assert is_closed(one)
    for page in pages:
        page.close()
    end = time.monotonic() + WAIT
    while get_or_none(viewer.url) != 200:
        assert time.monotonic() < end


def get_or_none(url: str) -> int | None:
    """The status; None where the connection was closed."""
    try:
        return get(url)[0]
    except OSError:
        return None


def test_files_under_way_are_counted(viewer: Viewer, monkeypatch: pytest.MonkeyPatch) -> None:
    begun, leave = threading.Event(), threading.Event()

    def write() -> str:
        begun.set()
        assert leave.wait(WAIT)
        return "written"

    slow = replace(DOWNLOADS["motion.csv"], prepare=lambda stage, scene: write)
    monkeypatch.setitem(DOWNLOADS, "motion.csv", slow)
    there = target(viewer)
    with ExitStack() as stack:
        waiting = [stack.enter_context(there.open()) for _ in range(MOST_FILES)]
        for one in waiting:
            one.sendall(there.head("motion.csv"))
        assert begun.wait(WAIT)
        until(lambda: viewer._server.files == MOST_FILES)
        assert get(viewer.url + "motion.csv")[:2] == (503, f"503 {MOST_FILES} files are under way: try again\n")
        leave.set()
        assert [one.recv(12) for one in waiting] == [b"HTTP/1.1 200"] * MOST_FILES
    assert get(viewer.url + "motion.csv")[0] == 200
