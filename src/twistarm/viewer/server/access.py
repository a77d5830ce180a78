"""Access: sockets that listen, and authentication by the token and by the Host and Origin that a browser sends."""

from __future__ import annotations

import errno
import hmac
import ipaddress
import socket
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from secrets import token_urlsafe
from urllib.parse import urlsplit

import tornado.netutil

from ...support.errors import InputError, shown

LOOPBACK = ("127.0.0.1", "localhost", "::1")
EVERYWHERE = ("", "0.0.0.0", "::")

WRONG_TOKEN = "wrong token: a view has a new address at each start; open the one that it printed last"


@dataclass(frozen=True)
class Authentication:
    """Admits requests with the token and one of our hosts. Any port is right, because ports may be forwarded.

    A foreign page may let a name resolve to this machine (DNS rebinding). Its Host and Origin still carry that name,
    so the request is refused.
    """

    host: str
    token: str = field(default_factory=partial(token_urlsafe, 16))

    def refusal(self, path: str, headers: Mapping[str, str]) -> str:
        """The reason to refuse a request; empty where it is admitted."""
        if not self.admits_host(headers.get("Host") or self.host):
            return "foreign Host"
        if not self.admits_origin(headers.get("Origin")):
            return "foreign Origin"
        given = path.partition("/")[2].partition("/")[0]
        return "" if hmac.compare_digest(given.encode(), self.token.encode()) else WRONG_TOKEN

    def admits_host(self, host: str) -> bool:
        """Whether a Host header names this machine."""
        name = _host_name(f"//{host}")
        if name is None:
            return False
        if name in LOOPBACK or name == self.host.lower():
            return True
        own = socket.gethostname().lower()
        return self.host in EVERYWHERE and (_is_address(name) or name in (own, f"{own.split('.')[0]}.local"))

    def admits_origin(self, origin: str | None) -> bool:
        """Whether an Origin header names a page of ours. Programs send no Origin and are admitted."""
        if origin is None:
            return True
        if not origin.startswith(("http://", "https://")):
            return False
        return self.admits_host(origin.split("//", 1)[1])


def _host_name(address: str) -> str | None:
    try:
        parts = urlsplit(address)
        _ = parts.port  # raises where it is no number
    except ValueError:
        return None
    plain = parts.username is None and parts.path == "" and not parts.query and not parts.fragment
    return parts.hostname if plain else None


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


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
