"""Listening sockets of the view."""

from __future__ import annotations

import errno
import socket
from collections.abc import Sequence

import tornado.netutil

from ...support.errors import InputError, shown


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
