"""Who may talk to the viewer: hosts and origins one by one, and what every answer tells the browser."""

from __future__ import annotations

import socket

import pytest

from twistarm import Arm
from twistarm.viewer import Viewer
from twistarm.viewer.server.authentication import Authentication
from viewer_page import get, swing

GUARD = Authentication("127.0.0.1")


def test_a_view_on_every_interface_admits_addresses_but_no_foreign_names() -> None:
    guard = Authentication("0.0.0.0")
    assert guard.admits_host("192.168.1.7:8000")
    assert guard.admits_host(f"{socket.gethostname()}:8000")
    assert not guard.admits_host("evil.example:8000")
    assert Authentication("rover.local").admits_host("rover.local:80")
    assert not GUARD.admits_host("192.168.1.7")


@pytest.mark.parametrize("host", ["x@127.0.0.1", "x:y@127.0.0.1", "x@localhost:80", "@127.0.0.1", ":@[::1]:8080"])
def test_a_host_with_a_user_is_refused(host: str) -> None:
    assert not GUARD.admits_host(host)
    assert not GUARD.admits_origin(f"http://{host}")
    assert not Authentication("0.0.0.0").admits_host(host)


@pytest.mark.parametrize(
    "host",
    ["127.0.0.1/x", "127.0.0.1?x", "127.0.0.1#x", "127.0.0.1:99999", "127.0.0.1:x", "", "127.0.0.1.evil.example"],
)
def test_what_is_no_host_of_ours_is_refused(host: str) -> None:
    assert not GUARD.admits_host(host)


@pytest.mark.parametrize(
    "origin",
    ["vscode-webview://localhost", "ftp://127.0.0.1", "ws://127.0.0.1", "file://localhost", "//localhost", "localhost",
     "chrome-extension://127.0.0.1", "https:localhost", "", "null", "http://127.0.0.1.evil.example"],
)  # fmt: skip
def test_an_origin_of_another_scheme_is_refused_though_its_host_is_ours(origin: str) -> None:
    assert not GUARD.admits_origin(origin)


@pytest.mark.parametrize("origin", ["http://127.0.0.1:8000", "https://localhost", "http://[::1]:9", None])
def test_an_origin_of_ours_is_admitted(origin: str | None) -> None:
    assert GUARD.admits_origin(origin)
    assert GUARD.admits_host("LOCALHOST")


def test_no_answer_s_type_is_guessed_by_the_browser(arm: Arm, viewer: Viewer) -> None:
    viewer.play(swing(arm))
    assert viewer.theta.shape == (3,)  # applied
    answers = {"": 200, "main.js": 200, "motion.csv": 200, "motion.json": 200, "nothing.js": 404}
    for name, expected in answers.items():
        status, _, headers = get(viewer.url + name)
        assert (status, headers["X-Content-Type-Options"]) == (expected, "nosniff"), name
    status, _, headers = get(viewer.url, Origin="ftp://127.0.0.1")
    assert (status, headers["X-Content-Type-Options"]) == (403, "nosniff")
