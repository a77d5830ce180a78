"""Listening sockets of the view, with one cap on connections."""

from __future__ import annotations

import errno
import socket
from collections.abc import Iterable, Sequence
from typing import Any

import tornado.netutil
from tornado.httpserver import HTTPServer
from tornado.iostream import IOStream

from ...support.errors import InputError, shown

MOST_CONNECTIONS = 128
"""Connections at a time, pages included. This leaves file descriptors for files."""

IDLE_TIME = 30.0
"""Seconds that a connection may wait for its next request, or take to send it."""

LARGEST_HEAD = 16 * 1024
"""Most bytes of a request's head. It may contain the cookies of all servers on this machine."""


class Listener(HTTPServer):
    """Tornado's server with a cap: beyond it, the oldest connection without a page is closed."""

    def initialize(self, *arguments: Any, pages: Iterable[Any] = (), **options: Any) -> None:
        """Called by tornado. pages: the connected pages, each with its `stream`. Requests have no body."""
        limits: dict[str, Any] = {
            "idle_connection_timeout": IDLE_TIME, "body_timeout": IDLE_TIME, "max_header_size": LARGEST_HEAD,
            "max_body_size": 0,
        }  # fmt: skip
        super().initialize(*arguments, **{**options, **limits})
        self._pages = pages
        self._streams: list[IOStream] = []

    def handle_stream(self, stream: IOStream, address: Any) -> None:
        """Called by tornado with a new connection."""
        self._streams = [each for each in self._streams if not each.closed()]
        if len(self._streams) >= MOST_CONNECTIONS:
            pages = {page.stream for page in self._pages}
            next((each for each in self._streams if each not in pages), stream).close()
        self._streams.append(stream)
        super().handle_stream(stream, address)


def bind(host: str, port: int) -> Sequence[socket.socket]:
    """Sockets that listen on `host` and `port` (0: a free one). InputError where that is impossible."""
    if not isinstance(port, int) or isinstance(port, bool) or not 0 <= port <= 65535:
        raise InputError(f"port must be 0 (a free one) … 65535; got {shown(port)}")
    try:
        return tornado.netutil.bind_sockets(port, host or None)
    except (OSError, UnicodeError) as error:
        raise InputError(_bind_message(host, port, error)) from error


def _bind_message(host: str, port: int, error: OSError | UnicodeError) -> str:
    number = getattr(error, "errno", None)
    if number == errno.EADDRINUSE:
        return f"port {port} is in use on {host}; take another, or --port 0 (port=0) for a free one"
    if number == errno.EACCES:
        return f"port {port} needs more rights than this user has; take one above 1023, or --port 0 (port=0)"
    return f"cannot listen on host {host!r}: {error}; use 127.0.0.1, or an address of this machine"
