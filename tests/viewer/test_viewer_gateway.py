"""The gateway of the view: places, times, and what is said of a crowd."""

from __future__ import annotations

import asyncio
import errno
import logging
import os
import socket
import sys
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from types import SimpleNamespace
from typing import Any

import pytest

from hostile.target import HANDSHAKE, OTHER, Target
from twistarm.viewer import Viewer
from twistarm.viewer.server import client_connection, gateway
from twistarm.viewer.server.client_connection import first_to_leave, name_of
from twistarm.viewer.server.gateway import places
from twistarm.viewer.server.handlers import MOST_FILES, MOST_PAGES
from twistarm.viewer.server.server_log import ServerLog
from viewer_page import WAIT, get, nothing, visit
from viewer_page import arm as arm
from viewer_page import viewer as viewer

two_computers = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="127.0.0.2 is another computer on Linux"
)


def target(viewer: Viewer, source: str = "") -> Target:
    return Target("127.0.0.1", viewer._server.port, viewer._server.authentication.token, WAIT, source)


def until(reached: Callable[[], bool]) -> None:
    end = time.monotonic() + WAIT
    while not reached():
        assert time.monotonic() < end
        time.sleep(0.02)


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


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody is waited for as long as otherwise."""
    for module, name, seconds in (
        (gateway, "LOOK", 0.05),
        (client_connection, "STRANGER_TIME", 0.3),
        (client_connection, "STALL_TIME", 0.3),
    ):
        monkeypatch.setattr(module, name, seconds)


@pytest.mark.parametrize("sent", [b"", b"GET / HTT", b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: y"])
def test_who_does_not_show_the_token_in_time_is_closed(hasty: None, viewer: Viewer, sent: bytes) -> None:
    with target(viewer).open() as one:
        one.sendall(sent)
        assert is_closed(one)


@pytest.mark.parametrize("method", ["POST", "PUT", "GET"])
def test_a_body_is_not_waited_for(viewer: Viewer, method: str) -> None:
    """Neither a stranger's nor one of who knows the token: nothing is sent to the view by it."""
    there = target(viewer)
    for path in ("/stranger/", ""):
        with there.open() as one:
            one.sendall(there.head(path, method, Content_Length="60000") + b"a")
            assert one.recv(12) in (b"HTTP/1.1 405", b"HTTP/1.1 403", b"HTTP/1.1 400")
            assert is_closed(one)


def test_an_answer_that_nobody_takes_is_given_up(hasty: None, viewer: Viewer) -> None:
    there = target(viewer)
    with there.open(receive=4096) as one:
        one.sendall(there.head("meshcat.js") * 20)
        until(lambda: any(each.writing() for each in known(viewer)))
        until(lambda: not known(viewer))


def known(viewer: Viewer) -> list[Any]:
    """Who has shown the token and is connected."""
    return viewer._server.ask(lambda stage: list(viewer._server.gateway._known))


@two_computers
def test_a_computer_with_every_page_gives_one_up_for_another_s(viewer: Viewer) -> None:
    there = target(viewer, OTHER)
    pages = there.crowd(MOST_PAGES, there.upgrade)
    until(lambda: len(viewer._server.clients) == MOST_PAGES)
    with there.open() as one:
        one.sendall(there.head("socket", **HANDSHAKE))
        assert one.recv(12) == b"HTTP/1.1 503"
    assert "hello" in visit(viewer, nothing).latest
    for page in pages:
        page.close()


def test_who_knows_the_token_has_places_too_and_no_more(viewer: Viewer) -> None:
    here, most = target(viewer), viewer._server.gateway._places
    with ExitStack() as stack:
        known_ones = []
        for _ in range(most + 1):  # one after the other: all at once would be too many strangers
            known_ones.append(stack.enter_context(here.open()))
            known_ones[-1].sendall(here.head("nothing.js"))
            known_ones[-1].recv(1)
        assert is_closed(known_ones[0])
        assert len(known(viewer)) == most


@two_computers
def test_strangers_of_one_computer_do_not_crowd_out_those_of_another(viewer: Viewer) -> None:
    with target(viewer).open() as honest, ExitStack() as stack:
        for _ in range(3 * gateway.MOST):
            stack.enter_context(target(viewer, OTHER).open())
        honest.sendall(target(viewer).head("nothing.js"))
        assert honest.recv(12) == b"HTTP/1.1 404"


def test_without_descriptors_the_loop_goes_on_and_lets_in_who_waits(
    viewer: Viewer, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    begin, spent = time.monotonic(), time.process_time()

    def accept(self: socket.socket) -> Any:
        if time.monotonic() < begin + 0.5:
            raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))
        return real(self)

    real = socket.socket.accept
    monkeypatch.setattr(socket.socket, "accept", accept)
    assert get(viewer.url)[0] == 200
    assert time.process_time() - spent < 0.4
    said = capfd.readouterr().err
    assert "could not be accepted: Too many open files" in said
    assert len(said.splitlines()) == 1


def test_files_under_way_to_one_computer_are_counted(viewer: Viewer) -> None:
    server, there = viewer._server, target(viewer)
    asyncio.run_coroutine_threadsafe(server.writing.acquire(), server._loop).result(WAIT)  # no file is made meanwhile
    with ExitStack() as stack:
        waiting = [stack.enter_context(there.open()) for _ in range(MOST_FILES)]
        for one in waiting:
            one.sendall(there.head("motion.csv"))
        until(lambda: len(known(viewer)) == MOST_FILES)
        assert get(viewer.url + "motion.csv")[:2] == (503, f"503 {MOST_FILES} files are under way to this computer\n")
        server._loop.call_soon_threadsafe(server.writing.release)
        assert [one.recv(12) for one in waiting] == [b"HTTP/1.1 404"] * MOST_FILES
    assert get(viewer.url + "motion.csv")[0] == 404


def test_places_leave_descriptors_free() -> None:
    assert [places(each) for each in (64, 256, 1024, 1 << 20)] == [8, 64, 64, 64]


def test_the_first_of_the_many_leaves() -> None:
    guests = [SimpleNamespace(peer=peer, number=k) for k, peer in enumerate("abbcb")]
    assert first_to_leave(guests).number == 1  # type: ignore[type-var]


@pytest.mark.parametrize(
    ("address", "name"),
    [("10.0.0.7", "10.0.0.7"), ("::1", "::1"), ("fe80::1%eth0", "fe80::/64"), ("2001:db8::a:b", "2001:db8::/64")],
)
def test_a_computer_is_known_by_what_it_cannot_choose(address: str, name: str) -> None:
    assert name_of((address, 1)) == name


# what is said -----------------------------------------------------------------------------------------


def test_a_flood_is_a_handful_of_lines(capfd: pytest.CaptureFixture[str]) -> None:
    complaints = ServerLog("the view")
    for k in range(12_345):
        complaints.say("flood", f"{k}\x1b[31m were there")
    lines = capfd.readouterr().err.splitlines()
    assert lines[0] == "the view: 0\\x1b[31m were there"
    assert [line.rpartition("(")[2] for line in lines[1:]] == [
        f"{count:,} times by now)" for count in (10, 100, 1000, 10_000)
    ]


def test_logs_of_libraries_count_for_the_loop_s_thread_alone(
    capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    async def fail() -> None:
        asyncio.get_running_loop().call_soon(lambda: 1 / 0)  # type: ignore[arg-type]
        await asyncio.sleep(0.01)
        logging.getLogger("tornado.general").info("nothing of interest")

    with ServerLog("the view") as complaints:
        asyncio.run(fail())
        thread = threading.Thread(target=logging.getLogger("tornado.general").warning, args=("another's",))
        thread.start()
        thread.join()
    assert complaints.counts == {"ZeroDivisionError": 1}
    assert capfd.readouterr().err == "the view: ZeroDivisionError: division by zero\n"
    assert [record.message for record in caplog.records] == ["another's"]
