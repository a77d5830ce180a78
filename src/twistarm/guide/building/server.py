"""The site served to this machine alone."""

from __future__ import annotations

import errno
from functools import partial
from http import HTTPStatus
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from ...support.errors import InputError

HOST = "127.0.0.1"

NAMES = (HOST, "localhost", "[::1]")
"""Hosts that a browser of this machine may ask for; another name has been made to lead here."""


class SiteServer(ThreadingHTTPServer):
    """Serves the files of `folder` on 127.0.0.1; a context manager. Raises InputError where the port cannot be had."""

    def __init__(self, folder: Path, port: int = 0) -> None:
        try:
            super().__init__((HOST, port), partial(_Handler, directory=str(folder)))
        except (OSError, OverflowError) as error:
            in_use = getattr(error, "errno", None) == errno.EADDRINUSE
            why = "is in use" if in_use else f"cannot be had ({error})"
            raise InputError(f"port {port} {why}; take another, or --port 0 for a free one") from error

    @property
    def url(self) -> str:
        """Where the contents are."""
        return f"http://{HOST}:{self.server_address[1]}/"


class _Handler(SimpleHTTPRequestHandler):
    """Files of the folder by GET, to this machine's own browsers; no listings."""

    server_version = "twistarm"
    sys_version = ""

    def send_head(self) -> Any:
        host = self.headers.get("Host", "")
        if host.rpartition(":")[0] not in NAMES and host not in NAMES:
            self.send_error(HTTPStatus.FORBIDDEN, "this page is for this machine alone")
            return None
        return super().send_head()

    def list_directory(self, path: Any) -> Any:
        self.send_error(HTTPStatus.NOT_FOUND)

    def end_headers(self) -> None:
        self.send_header("Cache-Control", "no-cache")
        self.send_header("X-Content-Type-Options", "nosniff")
        super().end_headers()

    def log_message(self, format: str, *arguments: object) -> None:
        """Say nothing: who reads knows what they read."""
