"""What answers a browser: the page's files, and one socket per page with an outbox that cannot grow."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import tornado.web
import tornado.websocket

from ..strict_json import encode
from .guard import Guard

if TYPE_CHECKING:
    from .server import Server

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "connect-src 'self' ws://{host} wss://{host}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""No script but our own files, and no eval; Meshcat's bundle writes style attributes, hence inline styles."""


def require_admission(guard: Guard, request: Any, token: str) -> None:
    """403 for a foreign Host or Origin, or a wrong token, each with its reason."""
    if not guard.admits_host(request.host):
        raise tornado.web.HTTPError(403, reason="foreign Host")
    if not guard.admits_origin(request.headers.get("Origin")):
        raise tornado.web.HTTPError(403, reason="foreign Origin")
    if not guard.knows_token(token):
        raise tornado.web.HTTPError(403, reason="wrong token: open the address the viewer gave")


class PageHandler(tornado.web.RequestHandler):
    """GET /TOKEN/FILE: one of the page's files."""

    def initialize(self, guard: Guard, files: Mapping[str, tuple[str, bytes]]) -> None:
        """Called by tornado with the arguments of the route."""
        self.guard, self.files = guard, files

    def get(self, token: str, name: str) -> None:
        """Send the file; the bare /TOKEN is led to /TOKEN/, on which the page's relative addresses rest."""
        require_admission(self.guard, self.request, token)
        if not name and not self.request.path.endswith("/"):
            return self.redirect(f"/{token}/")
        if name not in self.files:
            raise tornado.web.HTTPError(404)
        kind, content = self.files[name]
        self.set_header("Content-Type", kind)
        self.set_header("Content-Security-Policy", POLICY.format(host=self.request.host))
        self.write(content)

    def set_default_headers(self) -> None:
        """On every answer, errors included."""
        self.set_header("Cache-Control", "no-store")
        self.set_header("Referrer-Policy", "no-referrer")
        self.set_header("X-Content-Type-Options", "nosniff")
        self.clear_header("Server")

    def write_error(self, status_code: int, **kwargs: Any) -> None:
        """One line of text instead of tornado's page."""
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(f"{status_code} {self._reason}\n")

    def log_exception(self, *exception: Any) -> None:
        """Refusals are told to the browser only."""


class SocketHandler(tornado.websocket.WebSocketHandler):
    """One page. Its outbox holds the latest message of each type, so one that reads slowly or never costs nothing."""

    def initialize(self, server: Server) -> None:
        """Called by tornado with the arguments of the route."""
        self.server = server
        self._outbox: dict[str, str] = {}
        self._waiting = asyncio.Event()
        self._sender: asyncio.Task[None] | None = None
        self.name = server.name_page()

    async def get(self, *path: str, **arguments: str) -> None:
        """Refuse strangers before the handshake."""
        require_admission(self.server.guard, self.request, path[0])
        await super().get(*path, **arguments)

    def check_origin(self, origin: str) -> bool:
        """Ask the guard, which knows forwarded ports."""
        return self.server.guard.admits_origin(origin)

    def open(self, *path: str, **arguments: str) -> None:
        """Greet the page, then keep it up to date."""
        self.set_nodelay(True)
        for kind, text in self.server.state().items():
            self.put(kind, text)
        self.server.clients.add(self)
        self._sender = asyncio.get_running_loop().create_task(self._send())

    def put(self, kind: str, text: str) -> None:
        """Send `text` as soon as the page has taken what came before; an unsent one of its kind is dropped."""
        self._outbox.pop(kind, None)
        self._outbox[kind] = text
        self._waiting.set()

    def on_message(self, message: str | bytes) -> None:
        """Whatever arrives gets an answer."""
        for reply in self.server.receive(message, self.name):
            self.put(reply["type"], encode(reply))

    def on_close(self) -> None:
        """Forget the page, and what it commanded."""
        self.server.clients.discard(self)
        self.server.leave(self.name)
        if self._sender is not None:
            self._sender.cancel()

    def log_exception(self, *exception: Any) -> None:
        """Refusals are told to the browser only."""

    def write_error(self, status_code: int, **kwargs: Any) -> None:
        """One line of text instead of tornado's page."""
        self.finish(f"{status_code} {self._reason}\n")

    async def _send(self) -> None:
        try:
            for message in self.server.greeting():
                await self.write_message(message, binary=isinstance(message, bytes))
            while True:
                await self._waiting.wait()
                while self._outbox:
                    await self.write_message(self._outbox.pop(next(iter(self._outbox))))
                self._waiting.clear()
        except tornado.websocket.WebSocketClosedError:
            self.server.clients.discard(self)
