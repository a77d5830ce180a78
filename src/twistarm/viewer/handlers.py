"""What answers a browser: the page's files, and one socket per page with an outbox that cannot grow."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import tornado.web
import tornado.websocket

from ..errors import TwistarmError
from ..strict_json import encode
from .aside import aside
from .downloads import DOWNLOADS
from .guard import Guard

if TYPE_CHECKING:
    from .scene import Scene
    from .server import Server

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "connect-src 'self' ws://{host} wss://{host}; base-uri 'none'; form-action 'none'; "
    "frame-ancestors http://localhost:* http://127.0.0.1:*"
)
"""No script but our own files, and no eval; Meshcat's bundle writes style attributes, hence inline styles.

A frame may hold the page where all that surrounds it comes from this machine, by http or https on any port: Jupyter
does. Whoever would have hands click on it unseen must have a server here, and know the token. ([::1] cannot be said.)
"""


def require_admission(guard: Guard, request: Any, token: str) -> None:
    """403 for a foreign Host or Origin, or a wrong token, each with its reason."""
    if not guard.admits_host(request.host):
        raise tornado.web.HTTPError(403, reason="foreign Host")
    if not guard.admits_origin(request.headers.get("Origin")):
        raise tornado.web.HTTPError(403, reason="foreign Origin")
    if not guard.knows_token(token):
        raise tornado.web.HTTPError(403, reason="wrong token: open the address the viewer gave")


REPLIES = ("done", "error")
"""What answers the page itself, whatever arm is on show."""

MOST_PAGES = 64
"""Sockets at a time: each costs a megabyte of buffers at the worst, and a team has fewer screens."""


class FileHandler(tornado.web.RequestHandler):
    """What every answer to a GET has."""

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


class PageHandler(FileHandler):
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


class DownloadHandler(FileHandler):
    """GET /TOKEN/NAME: a file of DOWNLOADS, made in a thread, one after the other."""

    def initialize(self, server: Server) -> None:
        """Called by tornado with the arguments of the route."""
        self.server = server

    async def get(self, token: str, name: str) -> None:
        """Send the file to be saved; 404 and the reason where there is none now."""
        require_admission(self.server.guard, self.request, token)
        download = DOWNLOADS[name]
        try:
            async with self.server.writing:
                text = await aside(download.prepare(self.server.current(), self.server.scene))
        except TwistarmError as error:
            self.set_status(404)
            self.set_header("Content-Type", "text/plain; charset=utf-8")
            return await self.finish(f"{error}\n")
        self.set_header("Content-Type", download.content_type)
        file_name = download.file_name(self.server.stage.arm.name)
        self.set_header("Content-Disposition", f'attachment; filename="{file_name}"')
        await self.finish(text)


class SocketHandler(tornado.websocket.WebSocketHandler):
    """One page. Its outbox holds the latest message of each type, so one that reads slowly or never costs nothing."""

    def initialize(self, server: Server) -> None:
        """Called by tornado with the arguments of the route."""
        self.server = server
        self._outbox: dict[str, str] = {}
        self._scene: Scene | None = None  # of which the page has been sent the first objects
        self._waiting = asyncio.Event()
        self._sender: asyncio.Task[None] | None = None
        self._sent = 0
        self.name = server.name_page()

    async def get(self, *path: str, **arguments: str) -> None:
        """Refuse strangers, and whom there is no room for, before the handshake."""
        require_admission(self.server.guard, self.request, path[0])
        if len(self.server.clients) >= MOST_PAGES:
            raise tornado.web.HTTPError(503, reason=f"{MOST_PAGES} pages are open: close one of them")
        await super().get(*path, **arguments)

    def check_origin(self, origin: str) -> bool:
        """Ask the guard, which knows forwarded ports."""
        return self.server.guard.admits_origin(origin)

    def open(self, *path: str, **arguments: str) -> None:
        """Greet the page, then keep it up to date."""
        self.set_nodelay(True)
        self.begin(self.server.state())
        self.server.clients.add(self)
        self._sender = asyncio.get_running_loop().create_task(self._send())

    def begin(self, texts: Mapping[str, str]) -> None:
        """Say what is on show, all of it: the page knows nothing of this arm. Answers that wait are not lost."""
        self._outbox = {kind: text for kind, text in self._outbox.items() if kind in REPLIES}
        for kind, text in texts.items():
            self.put(kind, text)

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
            while True:
                await self._waiting.wait()
                self._waiting.clear()
                await self._catch_up()
        except tornado.websocket.WebSocketClosedError:
            self.server.clients.discard(self)

    async def _catch_up(self) -> None:
        """Send what the page lacks of the scene; once all but the meshes is there, whatever else waits goes first."""
        while (scene := self.server.scene) is not self._scene or self._sent < len(scene.objects) or self._outbox:
            if scene is not self._scene:  # a new page, or another arm
                self._scene, self._sent = scene, 0
                await self.write_message(self.server.greeting())
            elif self._sent < len(scene.objects):
                self._sent += 1
                if scene.objects[self._sent - 1]:  # else a later one has replaced it
                    await self.write_message(scene.objects[self._sent - 1], binary=True)
            if scene is self.server.scene and self._sent >= scene.plain and self._outbox:
                await self._empty_outbox()

    async def _empty_outbox(self) -> None:
        """Send all that waits at once, and wait until the page has taken it: meanwhile the outbox fills anew.

        A wait for each message would hold up the next for two turns of the loop.
        """
        texts, self._outbox = self._outbox, {}
        for text in texts.values():
            written = self.write_message(text)
            written.add_done_callback(lambda each: each.cancelled() or each.exception())  # the last one's is raised
        await written
