"""Handlers of the web server: the page's files, and one socket per page with an outbox that cannot grow."""

from __future__ import annotations

import asyncio
import time
from collections import Counter
from collections.abc import Awaitable, Mapping
from typing import Any, Protocol

import tornado.web
import tornado.websocket

from ...support.errors import TwistarmError
from ...support.strict_json import encode
from ..protocol.message_cache import Message
from ..scene.arm_scene import Scene
from ..stage import Stage
from .authentication import Authentication
from .client_connection import ClientConnection, Peer, first_to_leave
from .daemon_threads import run_in_daemon_thread
from .downloads import DOWNLOADS, Download
from .gateway import ALWAYS

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "connect-src 'self' ws://{host} wss://{host}; base-uri 'none'; form-action 'none'; "
    "frame-ancestors http://localhost:* http://127.0.0.1:*"
)
"""No script but our own files, and no eval; Meshcat's bundle writes style attributes, hence inline styles.

A frame may hold the page where all that surrounds it comes from this machine, by http or https on any port: Jupyter
does. Whoever would have hands click on it unseen must have a server here, and know the token. ([::1] cannot be said.)
"""


REPLIES = ("done", "error")
"""What answers the page itself, whatever arm is on show."""

MOST_PAGES = 64
"""Sockets at a time: each costs a megabyte of buffers at the worst, and a team has fewer screens."""


MOST_FILES = 4
"""Files at a time made for one computer, and on their way to it."""


class Service(Protocol):
    """The view, as a handler needs it."""

    stage: Stage
    scene: Scene
    authentication: Authentication
    clients: dict[SocketHandler, None]
    writing: asyncio.Lock

    def current(self) -> Stage:
        """What is on show now."""

    def name_page(self) -> str:
        """A name for a page that has just come."""

    def state(self) -> Mapping[str, str]:
        """Everything that a new page is told, by type."""

    def greeting(self) -> str:
        """The first message about a scene."""

    def receive(self, text: str | bytes, sender: str) -> list[Message]:
        """The replies to a message of a page."""

    def leave(self, sender: str) -> None:
        """A page is gone, and so is what it commanded."""


class FileHandler(tornado.web.RequestHandler):
    """What every answer to a GET has."""

    def set_default_headers(self) -> None:
        """On every answer, errors included."""
        for name, value in ALWAYS.items():
            self.set_header(name, value)
        self.clear_header("Server")

    def write_error(self, status_code: int, **kwargs: Any) -> None:
        """One line of text instead of tornado's page."""
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(f"{status_code} {self._reason}\n")

    def log_exception(self, *exception: Any) -> None:
        """Refusals are told to the browser only."""


class PageHandler(FileHandler):
    """GET /TOKEN/FILE: one of the page's files."""

    def initialize(self, files: Mapping[str, tuple[str, bytes]]) -> None:
        """Called by tornado with the arguments of the route."""
        self.files = files

    def get(self, token: str, name: str) -> None:
        """Send the file; the bare /TOKEN is led to /TOKEN/, on which the page's relative addresses rest."""
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

    def initialize(self, server: Service) -> None:
        """Called by tornado with the arguments of the route."""
        self.server = server

    async def get(self, token: str, name: str) -> None:
        """Send the file to be saved; 404 and the reason where there is none now."""
        download = DOWNLOADS[name]
        peer: Peer = self.request.connection.stream.peer  # type: ignore[union-attr]
        if peer.files >= MOST_FILES:
            raise tornado.web.HTTPError(503, reason=f"{MOST_FILES} files are under way to this computer")
        peer.files += 1
        try:
            await self._send(download)
        finally:
            peer.files -= 1

    async def _send(self, download: Download) -> None:
        try:
            async with self.server.writing:
                text = await run_in_daemon_thread(download.prepare(self.server.current(), self.server.scene))
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

    def initialize(self, server: Service) -> None:
        """Called by tornado with the arguments of the route."""
        self.server = server
        self._outbox: dict[str, str] = {}
        self._scene: Scene | None = None  # of which the page has been sent the first objects
        self._waiting = asyncio.Event()
        self._sender: asyncio.Task[None] | None = None
        self._sent = 0
        self.name = server.name_page()
        self._client: ClientConnection = self.request.connection.stream  # type: ignore[union-attr]
        self.peer: Peer = self._client.peer

    async def get(self, *path: str, **arguments: str) -> None:
        """Refuse whom there is no room for, before the handshake."""
        if len(self.server.clients) >= MOST_PAGES and not self._takes_a_place():
            raise tornado.web.HTTPError(503, reason=f"{MOST_PAGES} pages are open: close one of them")
        await super().get(*path, **arguments)

    def _takes_a_place(self) -> bool:
        """Have the latest page of the peer with the most of them go, where this one's peer has fewer all the same."""
        latest = first_to_leave(reversed(self.server.clients))
        count = Counter(each.peer for each in self.server.clients)
        if count[self.peer] + 1 >= count[latest.peer]:
            return False
        del self.server.clients[latest]
        latest.close(1013, "the place is another computer's")
        return True

    def check_origin(self, origin: str) -> bool:
        """Ask `authentication`, which knows forwarded ports."""
        return self.server.authentication.admits_origin(origin)

    def open(self, *path: str, **arguments: str) -> None:
        """Greet the page, then keep it up to date."""
        self.set_nodelay(True)
        self._client.page = True
        self.begin(self.server.state())
        self.server.clients[self] = None
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

    def on_message(self, message: str | bytes) -> Awaitable[None] | None:
        """Whatever arrives gets an answer; what comes without end has to wait in between."""
        begin = time.monotonic()
        for reply in self.server.receive(message, self.name):
            self.put(reply["type"], encode(reply))
        return self.peer.spend(time.monotonic() - begin)

    def on_close(self) -> None:
        """Forget the page, and what it commanded."""
        self.server.clients.pop(self, None)
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
            self.server.clients.pop(self, None)

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
