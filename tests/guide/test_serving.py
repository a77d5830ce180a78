"""The site served: to this machine alone, and nothing beside it."""

from __future__ import annotations

import http.client
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from twistarm import InputError
from twistarm.guide.building.server import SiteServer


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SiteServer]:
    tmp_path = tmp_path_factory.mktemp("served")
    folder = tmp_path / "site"
    (folder / "scenes").mkdir(parents=True)
    (folder / "index.html").write_text("the guide")
    (tmp_path / "secret.txt").write_text("secret")
    with SiteServer(folder) as served:
        thread = threading.Thread(target=served.serve_forever, daemon=True)
        thread.start()
        yield served
        served.shutdown()
        thread.join(5)


def asked(server: SiteServer, path: str, host: str | None = None, method: str = "GET") -> tuple[int, str]:
    address = server.url.removeprefix("http://").strip("/")
    connection = http.client.HTTPConnection(address, timeout=10)
    connection.request(method, path, headers={} if host is None else {"Host": host})
    answer = connection.getresponse()
    return answer.status, answer.read().decode()


def test_the_contents_and_nothing_outside(server: SiteServer) -> None:
    assert server.url.startswith("http://127.0.0.1:")
    assert asked(server, "/") == (200, "the guide")
    for path in ("/../secret.txt", "/%2e%2e/secret.txt", "/scenes/", "/nothing.html"):
        status, text = asked(server, path)
        assert status == 404, path
        assert "secret" not in text.replace("secret.txt", "")
    assert asked(server, "/", method="POST")[0] == 501


@pytest.mark.parametrize(("host", "status"), [("evil.example:80", 403), ("localhost:1", 200), ("127.0.0.1", 200)])
def test_a_name_that_was_made_to_lead_here_is_refused(host: str, status: int, server: SiteServer) -> None:
    assert asked(server, "/", host)[0] == status


def test_a_port_in_use_is_said(server: SiteServer, tmp_path: Path) -> None:
    port = int(server.url.rstrip("/").rpartition(":")[2])
    with pytest.raises(InputError, match=f"port {port} is in use; take another, or --port 0"):
        SiteServer(tmp_path, port)
