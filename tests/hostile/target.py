"""The view's server as an attack sees it: connections, requests and frames."""

from __future__ import annotations

import socket
import time


class Target:
    """Where the attack goes, and until when."""

    def __init__(self, host: str, port: int, token: str, seconds: float) -> None:
        self.host, self.port, self.token = host, port, token
        self.end = time.monotonic() + seconds

    def on(self) -> bool:
        return time.monotonic() < self.end

    def open(self, receive: int = 0) -> socket.socket:
        """A connection, with a window of `receive` bytes."""
        made = socket.socket()
        made.settimeout(5.0)
        if receive:
            made.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive)
        made.connect((self.host, self.port))
        return made

    def head(self, path: str = "", method: str = "GET", host: str = "127.0.0.1", **headers: str) -> bytes:
        """The head of a request, for a path below the token where it does not begin with a slash."""
        full = path if path.startswith("/") else f"/{self.token}/{path}"
        given = [f"{name.replace('_', '-')}: {value}" for name, value in headers.items()]
        return "\r\n".join([f"{method} {full} HTTP/1.1", f"Host: {host}", *given, "", ""]).encode()

    def upgrade(self, receive: int = 0) -> socket.socket:
        """A page's socket, its handshake done."""
        made = self.open(receive=receive)
        made.sendall(self.head("socket", **HANDSHAKE))
        made.recv(1)
        return made


def frame(text: bytes) -> bytes:
    """A masked WebSocket frame of fewer than 126 bytes. A mask of zeros changes nothing."""
    return bytes([0x81, 0x80 | len(text)]) + bytes(4) + text


HANDSHAKE = {
    "Upgrade": "websocket",
    "Connection": "Upgrade",
    "Sec_WebSocket_Key": "dGhlIHNhbXBsZSBub25jZQ==",
    "Sec_WebSocket_Version": "13",
}

POSE = b'{"type":"pose","name":"zero","ease":false,"number":7}'
