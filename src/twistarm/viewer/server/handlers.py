"""Handlers of the web server: the page's files, downloads, and a socket per page with a bounded outbox."""

from __future__ import annotations

import asyncio
import logging
import re
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import tornado.web
import tornado.websocket

from ...collision.scene_file import scene_text
from ...planning.trajectory_files import Writing, written
from ...support.errors import InputError, TwistarmError
from ...support.strict_json import LARGEST_MESSAGE, encode
from ..files.page_export import modules, stand_alone
from ..files.scene_snapshot import on_show
from ..page_files import page_files
from ..scene.arm_drawing import Drawing
from ..stage import Stage
from .server import Server

SAMPLE_TIME = 0.01
"""Time between two rows of an export [s]."""

MOST_SAMPLES = 20_000
"""Most rows of an exported motion: some megabytes for seven joints."""


@dataclass(frozen=True)
class Download:
    """A file: its content type, and the ending of its name after the arm's name.

    The loop calls `prepare(stage, drawing)`, which copies what it needs from the stage. A thread calls the result,
    which returns the text and must not touch the stage. Both may raise InputError with the reason why there is no file.
    """

    content_type: str
    ending: str
    prepare: Callable[[Stage, Drawing], Callable[[], str | bytes]]

    def file_name(self, arm: str) -> str:
        """The file's name, in letters that every system and header takes."""
        return re.sub(r"[^A-Za-z0-9._-]", "_", arm)[:100] + self.ending


def _motion(kind: str, stage: Stage, drawing: Drawing) -> Callable[[], str | bytes]:
    at = stage.playback
    if at is None:
        raise InputError("nothing to export: no trajectory is loaded")
    return partial(written, at.trajectory, kind, Writing(max(SAMPLE_TIME, at.duration / MOST_SAMPLES)))


def _page(stage: Stage, drawing: Drawing) -> Callable[[], str]:
    return partial(stand_alone, on_show(stage, drawing))


def _scene(stage: Stage, drawing: Drawing) -> Callable[[], str]:
    made = stage.collisions.scene
    if made is None:
        raise InputError("there is no scene yet: switch the layer Collision on first")
    return partial(scene_text, made.content(), Path.cwd())


DOWNLOADS: Mapping[str, Download] = {
    "arm.html": Download("text/html; charset=utf-8", ".html", _page),
    "scene.toml": Download("application/toml", "_scene.toml", _scene),
    "motion.csv": Download("text/csv; charset=utf-8", "_motion.csv", partial(_motion, "csv")),
    "motion.json": Download("application/json", "_motion.json", partial(_motion, "json")),
    "motion.h": Download("text/plain; charset=utf-8", "_motion.h", partial(_motion, "header")),
}
"""Downloads by their name under the token."""


HEADERS = {"Cache-Control": "no-store", "Referrer-Policy": "no-referrer", "X-Content-Type-Options": "nosniff"}
"""Headers of every answer, refusals included."""

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
"""Requests that answer the page itself, for any arm."""

PING_TIME = 20
"""Seconds between two pings of a page, and until a silent page is dropped."""

# Tornado logs each malformed request; a program that wants to read that sets up logging.
logging.getLogger("tornado").addHandler(logging.NullHandler())


def application(server: Server) -> tornado.web.Application:
    """Everything stands under the token."""
    shared = {"server": server}
    return tornado.web.Application(
        [
            (r"/([^/]*)/socket", SocketHandler, shared),
            (rf"/([^/]*)/({'|'.join(map(re.escape, DOWNLOADS))})", DownloadHandler, shared),
            (r"/([^/]*)/?(.*)", PageHandler, shared),
        ],
        default_handler_class=Guarded,
        default_handler_args=shared,
        files=_files(),
        log_function=lambda handler: None,
        websocket_max_message_size=LARGEST_MESSAGE,
        websocket_ping_interval=PING_TIME,
        websocket_ping_timeout=PING_TIME,
    )


def _files() -> dict[str, tuple[str, bytes]]:
    """The page's files. index.html requests all modules of main.js at once."""
    files = page_files()
    kind, page = files[""]
    links = [f'<link rel="modulepreload" href="{name}">' for name in modules("main.js")]
    links.append('<link rel="preload" href="schema.json" as="fetch" crossorigin>')
    files[""] = kind, page.replace(b"</head>", "\n".join([*links, "</head>"]).encode(), 1)
    return files


class Guarded(tornado.web.RequestHandler):
    """A GET with our token, Host and Origin. Other requests are refused in one line."""

    SUPPORTED_METHODS = ("GET",)

    def initialize(self, server: Server) -> None:
        """Called by tornado with the arguments of the route."""
        self.server = server

    def set_default_headers(self) -> None:
        """On every answer, errors included."""
        for name, value in HEADERS.items():
            self.set_header(name, value)
        self.clear_header("Server")

    def prepare(self) -> None:
        """Called by tornado before the method."""
        reason = self.server.authentication.refusal(self.request.path, self.request.headers)
        if reason:
            raise tornado.web.HTTPError(403, reason=reason)

    def write_error(self, status_code: int, **kwargs: Any) -> None:
        """One line of text instead of tornado's page."""
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(f"{status_code} {self._reason}\n")

    def log_exception(self, kind: Any, error: Any, trace: Any) -> None:
        """Show refusals to the browser only, because their addresses may hold the token."""
        if not isinstance(error, tornado.web.HTTPError):
            super().log_exception(kind, error, trace)


class PageHandler(Guarded):
    """GET /TOKEN/FILE: one of the page's files."""

    def get(self, token: str, name: str) -> None:
        """Send the file. /TOKEN redirects to /TOKEN/, the base of the page's relative addresses."""
        if not name and not self.request.path.endswith("/"):
            return self.redirect(f"/{token}/")
        files: Mapping[str, tuple[str, bytes]] = self.settings["files"]
        if name not in files:
            raise tornado.web.HTTPError(404)
        kind, content = files[name]
        self.set_header("Content-Type", kind)
        self.set_header("Content-Security-Policy", POLICY.format(host=self.request.host))
        self.write(content)


class DownloadHandler(Guarded):
    """GET /TOKEN/NAME: a file of DOWNLOADS, made in a thread."""

    async def get(self, token: str, name: str) -> None:
        """Send the file, or 404 with the reason."""
        download = DOWNLOADS[name]
        try:
            text = await _in_daemon_thread(download.prepare(self.server.current(), self.server.drawing))
        except TwistarmError as error:
            self.set_status(404)
            self.set_header("Content-Type", "text/plain; charset=utf-8")
            return await self.finish(f"{error}\n")
        self.set_header("Content-Type", download.content_type)
        file_name = download.file_name(self.server.stage.arm.name)
        self.set_header("Content-Disposition", f'attachment; filename="{file_name}"')
        await self.finish(text)


async def _in_daemon_thread(call: Callable[[], str | bytes]) -> str | bytes:
    """What `call` returns or raises. The threads of a loop's executor would hold up the end of the program."""
    done: Future[str | bytes] = Future()
    done.set_running_or_notify_cancel()

    def run() -> None:
        try:
            done.set_result(call())
        except Exception as error:
            done.set_exception(error)

    threading.Thread(target=run, name="twistarm file", daemon=True).start()
    return await asyncio.wrap_future(done)


class SocketHandler(Guarded, tornado.websocket.WebSocketHandler):
    """One page. Its outbox keeps the latest message of each type, so a slow page costs nothing."""

    def initialize(self, server: Server) -> None:
        """Called by tornado with the arguments of the route."""
        super().initialize(server)
        self._outbox: dict[str, str] = {}
        self._drawing: Drawing | None = None  # of which the page has been sent the first objects
        self._waiting = asyncio.Event()
        self._sender: asyncio.Task[None] | None = None
        self._sent = 0
        self.name = next(server.names)

    def check_origin(self, origin: str) -> bool:
        """Ask `authentication`, which knows forwarded ports."""
        return self.server.authentication.admits_origin(origin)

    def open(self, *path: str, **arguments: str) -> None:
        """Greet the page, then keep it up to date."""
        self.set_nodelay(True)
        self.begin(self.server.state())
        self.server.clients[self] = None
        self._sender = asyncio.get_running_loop().create_task(self._send())
        self.server.publish()

    def begin(self, texts: Mapping[str, str]) -> None:
        """Send the whole state, because the page knows nothing of this arm. Waiting answers stay."""
        self._outbox = {kind: text for kind, text in self._outbox.items() if kind in REPLIES}
        for kind, text in texts.items():
            self.put(kind, text)

    def put(self, kind: str, text: str) -> None:
        """Queue `text`. An unsent message of the same kind is dropped."""
        self._outbox.pop(kind, None)
        self._outbox[kind] = text
        self._waiting.set()

    def on_message(self, message: str | bytes) -> None:
        """Answer a message."""
        for reply in self.server.receive(message, self.name):
            self.put(reply["type"], encode(reply))

    def on_close(self) -> None:
        """Forget the page, and what it commanded."""
        self.server.clients.pop(self, None)
        self.server.leave(self.name)
        if self._sender is not None:
            self._sender.cancel()

    async def _send(self) -> None:
        try:
            while True:
                await self._waiting.wait()
                self._waiting.clear()
                await self._catch_up()
        except tornado.websocket.WebSocketClosedError:
            self.server.clients.pop(self, None)

    async def _catch_up(self) -> None:
        """Send the missing parts of the scene. Before the meshes, all other messages go first."""
        while True:
            drawing = self.server.drawing
            if drawing is self._drawing and self._sent >= len(drawing.objects) and not self._outbox:
                return
            if drawing is not self._drawing:  # a new page, or another arm
                self._drawing, self._sent = drawing, 0
                await self.write_message(encode(self.server.stage.hello(drawing.links)))
            elif self._sent < len(drawing.objects):
                self._sent += 1
                if drawing.objects[self._sent - 1]:  # else a later one has replaced it
                    await self.write_message(drawing.objects[self._sent - 1], binary=True)
            if drawing is self.server.drawing and self._sent >= drawing.plain and self._outbox:
                await self._empty_outbox()

    async def _empty_outbox(self) -> None:
        """Send all waiting messages at once. Then wait for the page while the outbox fills again.

        Waiting for each message would delay the next by two turns of the loop.
        """
        texts, self._outbox = self._outbox, {}
        for text in texts.values():
            written = self.write_message(text)
            written.add_done_callback(lambda each: each.cancelled() or each.exception())  # the last one's is raised
        await written
