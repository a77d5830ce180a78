"""How the page is opened: no token on a command line, an address that is good once, for this user and a short while."""

from __future__ import annotations

import http.client
import os
import subprocess
import sys
import time
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from twistarm import Arm
from twistarm.viewer import Viewer
from twistarm.viewer.server import one_time_addresses
from viewer_page import WAIT, get
from viewer_page import arm as arm
from viewer_page import viewer as viewer


@pytest.fixture
def address(viewer: Viewer, monkeypatch: pytest.MonkeyPatch) -> str:
    """The address with which a browser is started."""
    monkeypatch.setenv("BROWSER", "any")
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda url: opened.append(url) is None)
    assert viewer.open_page()
    return opened[0]


def asked(url: str) -> tuple[int, str | None, str]:
    """Status, where it leads to, and text."""
    parts = urlsplit(url)
    connection = http.client.HTTPConnection(parts.netloc, timeout=WAIT)
    connection.request("GET", parts.path)
    answer = connection.getresponse()
    told = answer.status, answer.getheader("Location"), answer.read().decode()
    assert answer.getheader("Referrer-Policy") == "no-referrer"
    assert answer.getheader("Cache-Control") == "no-store"
    connection.close()
    return told


def test_the_first_is_led_to_the_page_and_a_second_is_announced(
    viewer: Viewer, address: str, capfd: pytest.CaptureFixture[str]
) -> None:
    token = viewer._server.authentication.token
    assert token not in address
    assert asked(address)[:2] == (302, f"/{token}/")
    assert get(viewer.url)[0] == 200
    assert capfd.readouterr().err == ""
    status, location, text = asked(address)
    assert (status, location) == (403, None)
    assert "good once, and was used" in text
    assert token not in text
    assert "another user of this computer was first" in capfd.readouterr().err


def test_it_leads_nowhere_later(viewer: Viewer, address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    now = time.monotonic()
    monkeypatch.setattr(one_time_addresses.time, "monotonic", lambda: now + one_time_addresses.LIFETIME)
    assert asked(address)[:2] == (403, None)
    assert get(viewer.url)[0] == 200


def test_whoever_guesses_is_told_what_every_stranger_is_told(viewer: Viewer, address: str) -> None:
    for path in (address[:-1], address + "/", address.replace("/open/", "/"), address.replace("open", "x")):
        assert asked(path)[0] == 403
        assert "wrong token" in asked(path)[2]
    assert asked(address)[0] == 302


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="other systems do not tell whose a connection is")
def test_another_user_who_reads_it_gets_nothing_and_does_not_use_it_up(viewer: Viewer, address: str) -> None:
    if os.geteuid() == 0:
        parts = urlsplit(address)
        head = f"GET {parts.path} HTTP/1.1\r\nHost: {parts.netloc}\r\n\r\n"
        program = (  # once it is another user, it can import no more
            "import os, socket, sys, encodings.idna; os.setuid(65534)\n"
            "s = socket.create_connection(('127.0.0.1', int(sys.argv[1])))\n"
            "s.sendall(sys.argv[2].encode()); os.write(1, s.recv(4096))"
        )
        command = [sys.executable, "-c", program, str(parts.port), head]
        answer = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout
        assert answer.startswith("HTTP/1.1 403 this address is another user's")
    else:
        with pytest.MonkeyPatch.context() as patch:  # we are the other user
            patch.setattr(one_time_addresses.os, "geteuid", lambda: 1)
            patch.setattr(one_time_addresses.os, "getuid", lambda: 1)
            assert asked(address)[0] == 403
    assert asked(address)[0] == 302


@pytest.mark.skipif(not Path("/proc/self/cmdline").exists(), reason="no list of command lines to read here")
def test_no_command_line_of_this_machine_holds_the_token(
    arm: Arm, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    browser, seen = tmp_path / "browser", tmp_path / "seen"
    browser.write_text(f'#!/bin/sh\ntr "\\0" " " < /proc/$$/cmdline > {seen}.new; mv {seen}.new {seen}; exec sleep 1\n')
    browser.chmod(0o755)
    monkeypatch.setenv("BROWSER", f"{browser} %s &")
    with Viewer(arm) as viewer:
        end = time.monotonic() + WAIT
        while not seen.exists():
            assert time.monotonic() < end
            time.sleep(0.02)
        line = seen.read_text()
        assert "/open/" in line
        assert viewer._server.authentication.token not in line
