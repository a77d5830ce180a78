"""Authentication of requests: the token, and the Host and Origin that a browser sends."""

from __future__ import annotations

import hmac
import ipaddress
import socket
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from secrets import token_urlsafe
from urllib.parse import urlsplit

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
