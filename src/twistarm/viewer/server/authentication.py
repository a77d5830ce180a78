"""Authentication of requests: the token, and the Host and Origin that a browser sends."""

from __future__ import annotations

import hmac
import ipaddress
import socket
from collections.abc import Mapping
from dataclasses import dataclass, field
from secrets import token_urlsafe
from urllib.parse import urlsplit

LOOPBACK = ("127.0.0.1", "localhost", "::1")
EVERYWHERE = ("", "0.0.0.0", "::")

TOKEN = r"[\w-]{22}"
"""16 random bytes in base64."""


def new_token() -> str:
    """What nobody guesses."""
    return token_urlsafe(16)


@dataclass(frozen=True)
class Authentication:
    """Admits whoever knows the token and asks for a host that is ours, on any port: ports are forwarded.

    A page of another site that makes its own name resolve to this machine (DNS rebinding) still sends that name as
    Host and Origin, and is refused by it.
    """

    host: str
    token: str = field(default_factory=new_token)

    def knows_token(self, given: str) -> bool:
        """Compares in constant time."""
        return hmac.compare_digest(given.encode(), self.token.encode())

    def refusal(self, method: str, headers: Mapping[str, str]) -> tuple[int, str] | None:
        """Status and reason for whoever asks for what we are not; None where all that is left to show is the token."""
        if method != "GET":
            return 405, "Method Not Allowed"
        if not self.admits_host(headers.get("Host") or self.host):
            return 403, "foreign Host"
        return None if self.admits_origin(headers.get("Origin")) else (403, "foreign Origin")

    def admits_host(self, host: str) -> bool:
        """Whether a Host header names this machine."""
        name = _host_name(f"//{host}")
        if name is None:
            return False
        if name in LOOPBACK or name == self.host.lower():
            return True
        return self.host in EVERYWHERE and (_is_address(name) or name in _own_names())

    def admits_origin(self, origin: str | None) -> bool:
        """Whether an Origin header is a page of ours; only programs send none."""
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


def _own_names() -> tuple[str, str]:
    name = socket.gethostname().lower()
    return name, f"{name.split('.')[0]}.local"
