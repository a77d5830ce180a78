"""The server of the view: who may come in, how it starts, that closing answers and leaves nothing."""

from __future__ import annotations

import re
import socket
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from numpy.testing import assert_array_equal
from tornado.httpclient import HTTPClientError

from twistarm import Arm
from twistarm.support.errors import InputError, MissingExtraError
from twistarm.viewer import Viewer, save_html
from twistarm.viewer.server import server
from twistarm.viewer.server.handlers import admits_host
from viewer_page import THETA, Page, connection, get, port_of, swing, visit


def test_the_page_and_its_files_are_served_under_the_token_only(viewer: Viewer) -> None:
    status, text, headers = get(viewer.url)
    assert status == 200
    assert "<title>twistarm</title>" in text
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "script-src 'self' 'wasm-unsafe-eval';" in policy
    assert "'unsafe-eval'" not in policy
    (ancestors,) = re.findall(r"frame-ancestors ([^;]*)", policy)
    assert ancestors.split() == ["http://localhost:*", "http://127.0.0.1:*"], "only pages of this machine may frame it"
    for name in re.findall(r'(?:src|href)="([\w.]+)"', text):
        assert get(viewer.url + name)[0] == 200, name
    root = viewer.url.rsplit("/", 2)[0]
    for wrong in ("/", "/wrong/", "/wrong/main.js", "/wrong/motion.csv", "/wrong/socket", ""):
        address = root + wrong
        status, text, _ = get(address)
        assert status == 403, address
        assert "wrong token" in text
    assert get(viewer.url + "../../etc/passwd")[0] in (403, 404)
    assert get(viewer.url + "nothing.js")[0] == 404
    assert get(viewer.url.rstrip("/"))[1].startswith("<!DOCTYPE html>")


def test_hosts_and_origins_are_asked_of_the_page_and_of_its_socket(viewer: Viewer) -> None:
    for name, foreign in (("Host", "evil.example:80"), ("Origin", "http://evil.example")):
        for file in ("", "motion.csv"):
            status, text, headers = get(viewer.url + file, **{name: foreign})
            assert (status, headers["X-Content-Type-Options"]) == (403, "nosniff")
            assert "<title>" not in text
    assert get(viewer.url, Host="localhost:1234")[0] == 200
    with pytest.raises(HTTPClientError, match="403"):
        visit(viewer, Origin="http://evil.example")
    forwarded = {"Host": "localhost:9999", "Origin": "http://localhost:9999"}
    assert "hello" in visit(viewer, **forwarded).latest


def test_every_module_that_the_page_runs_is_named_once_and_served(viewer: Viewer) -> None:
    page = get(viewer.url)[1]
    named = re.findall(r'<link rel="modulepreload" href="([\w.]+)">', page)
    reached, waiting = set(), ["main.js"]
    while waiting:  # as a browser goes from import to import
        name = waiting.pop()
        if name not in reached:
            reached.add(name)
            status, text, headers = get(viewer.url + name)
            assert status == 200, name
            assert headers["Content-Type"].startswith("text/javascript")
            waiting += re.findall(r'\bfrom "\./([\w.]+)"', text)
    assert sorted(named) == sorted(reached)
    assert len(reached) > 30
    assert page.index("modulepreload") < page.index("</head>") < page.index("<body>")


ODD_REQUESTS = [
    (b"POST /{token}/", 405),
    (b"GET /{token}/..%2f..%2fserver.py", 404),
    (b"GET http://evil.example/{token}/", 403),
    (b"GET /" + 100_000 * b"a", None),
    (b"\x16\x03\x01\x00\xff", 400),
]
"""The first line of a request, and what it gets; None: the connection is closed."""


def test_odd_requests_are_refused_in_a_line_and_nothing_is_printed(
    viewer: Viewer, capfd: pytest.CaptureFixture[str]
) -> None:
    token = viewer.url.split("/")[3].encode()
    for line, status in ODD_REQUESTS:
        answer = raw(viewer, line.replace(b"{token}", token) + b" HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 0\r\n")
        assert answer.startswith(b"" if status is None else b"HTTP/1.1 %d " % status), line[:60]
        assert b"Traceback" not in answer
        assert b"root:" not in answer
    body = b"GET /" + token + b"/ HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 1\r\n"
    assert raw(viewer, body).startswith(b"HTTP/1.1 400")
    assert get(viewer.url)[0] == 200
    assert capfd.readouterr() == ("", "")


def raw(viewer: Viewer, head: bytes) -> bytes:
    """What comes back for this request, as far as its first packet."""
    with connection(viewer) as sent:
        sent.sendall(head + b"\r\n")
        with suppress(ConnectionResetError):
            return sent.recv(4096)
        return b""


def test_a_port_in_use_is_one_line(arm: Arm, viewer: Viewer) -> None:
    port = port_of(viewer)
    with pytest.raises(InputError, match=f"port {port} .*127.0.0.1"):
        Viewer(arm, port=port, open_browser=False)


@pytest.mark.parametrize(
    ("name", "value", "allowed"),
    [
        *(("port", port, "0 .a free one.") for port in (-1, 65536, "80", 1.5, True)),
        *(("host", host, "127.0.0.1") for host in ("no.such.host.invalid", "203.0.113.7", "x" * 300)),
    ],
)
def test_a_port_or_host_that_is_none(arm: Arm, name: str, value: Any, allowed: str) -> None:
    with pytest.raises(InputError, match=f"{name} .*{allowed}"):
        Viewer(arm, open_browser=False, **{name: value})


def test_closing_leaves_nothing(arm: Arm, viewer: Viewer, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_process(*arguments: Any, **options: Any) -> None:
        raise AssertionError("the viewer starts no process, Meshcat's server least of all")

    monkeypatch.setattr(subprocess, "Popen", no_process)
    visit(viewer)  # which begins the thread that looks up names for these pages
    threads = set(threading.enumerate())
    viewer = Viewer(arm, open_browser=False)
    port = port_of(viewer)
    with Page(viewer) as page:
        viewer.close()
        page.until_closed()
    viewer.close()
    assert set(threading.enumerate()) - threads == set()
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.1", port))
    Viewer(arm, port=port, open_browser=False).close()
    assert_array_equal(viewer.theta, arm.ready)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for one child")
def test_ctrl_c_ends_waiting_cleanly() -> None:
    program = (
        "import os, signal, threading, numpy as np; from twistarm import arm_from_screws, joints\n"
        "from twistarm.viewer import Viewer\n"
        "arm = arm_from_screws(joints.revolute([0, 0, 1], [0, 0, 0]), np.eye(4))\n"
        "with Viewer(arm, open_browser=False) as v:\n"
        "    threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT)).start()\n"
        "    v.wait(); print('done')\n"
    )
    child = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert (child.stdout, child.stderr, child.returncode) == ("done\n", "", 0)


def test_without_meshcat_the_error_says_what_to_install(
    arm: Arm, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setitem(sys.modules, "meshcat", None)
    for view in (lambda: Viewer(arm, open_browser=False), lambda: save_html(arm, tmp_path / "view.html")):
        with pytest.raises(MissingExtraError, match=r"the viewer needs meshcat, .*: pip install 'twistarm\[view\]'"):
            view()


def test_a_missing_browser_is_no_error(
    arm: Arm, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setenv("BROWSER", "none-of-this-name")
    with Viewer(arm) as viewer:
        assert opened == [viewer.url]
    if sys.platform.startswith("linux"):
        for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
            monkeypatch.delenv(name, raising=False)
        with Viewer(arm) as viewer:
            assert viewer.url.startswith("http://127.0.0.1:")
        assert len(opened) == 1
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("host", "name"), [("localhost", "localhost"), ("0.0.0.0", "127.0.0.1"), ("::1", "[::1]")])
def test_other_hosts(arm: Arm, host: str, name: str) -> None:
    if host == "::1" and not socket.has_ipv6:
        pytest.skip("this machine has no IPv6")
    with Viewer(arm, host=host, open_browser=False) as viewer:
        assert viewer.url.startswith(f"http://{name}:")
        assert get(viewer.url)[0] == 200


HOSTS = {
    "127.0.0.1": {
        True: ("LOCALHOST", "127.0.0.1:8000", "[::1]:9"),
        False: ("192.168.1.7", "127.0.0.1.evil.example", "x@127.0.0.1", "x:y@127.0.0.1", ":@[::1]:8080", "127.0.0.1/x",
                "127.0.0.1?x", "127.0.0.1#x", "127.0.0.1:99999", "127.0.0.1:x", ""),
    },
    "0.0.0.0": {
        True: ("192.168.1.7:8000", f"{socket.gethostname()}:8000"), False: ("evil.example:8000", "x@127.0.0.1"),
    },
    "rover.local": {True: ("rover.local:80",), False: ()},
}  # fmt: skip
"""Of a view that listens on each: the Host headers that are admitted, and those that are not."""


def test_hosts_of_ours_alone_are_admitted() -> None:
    for listening, table in HOSTS.items():
        for admitted, hosts in table.items():
            assert [host for host in hosts if admits_host(listening, host) != admitted] == [], listening


def test_no_answer_s_type_is_guessed_by_the_browser(arm: Arm, viewer: Viewer) -> None:
    viewer.play(swing(arm))
    assert viewer.theta.shape == (3,)  # applied
    answers = {"": 200, "main.js": 200, "motion.csv": 200, "motion.json": 200, "motion.txt": 404, "nothing.js": 404}
    for name, expected in answers.items():
        status, _, headers = get(viewer.url + name)
        assert (status, headers["X-Content-Type-Options"]) == (expected, "nosniff"), name


def test_who_sends_no_whole_request_in_time_is_closed(arm: Arm, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "IDLE_TIME", 0.3)
    with Viewer(arm, open_browser=False) as viewer, connection(viewer) as one:
        one.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: y")
        with suppress(ConnectionResetError):
            assert one.recv(1) == b""


def test_a_closed_view_shows_nothing_more_and_still_answers(arm: Arm, viewer: Viewer) -> None:
    viewer.close()
    moving = (
        lambda: viewer.show(THETA),
        lambda: viewer.play(swing(arm)),
        lambda: viewer.show_path(None),
        lambda: viewer.show_screws(False),
        lambda: viewer.show_frames(False),
        lambda: viewer.load(arm),
    )
    for call in moving:
        with pytest.raises(InputError, match="closed"):
            call()
    viewer.show_servo(None)  # a loop that drives an arm goes on
    assert_array_equal(viewer.theta, THETA)
    assert "srcdoc" in viewer.inline(static=True).html
