"""Handlers of the web server: admission, the page's files, downloads, and a socket for each page."""

from __future__ import annotations

import asyncio
import hmac
import ipaddress
import logging
import re
import socket
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from importlib.resources import files
from pathlib import Path
from threading import Thread
from typing import Any, NamedTuple
from urllib.parse import urlsplit

import tornado.web
import tornado.websocket

from ...collision.scene_file import scene_text
from ...planning.trajectory import Writing
from ...planning.trajectory_files import written
from ...support.errors import InputError, TwistarmError
from ...support.strict_json import LARGEST_MESSAGE, encode
from ..saved_page import meshcat_bundle, modules, on_show, stand_alone
from ..scene.arm_drawing import Drawing
from ..stage import Stage
from .server import Server

LOOPBACK = ("127.0.0.1", "localhost", "::1")
EVERYWHERE = ("", "0.0.0.0", "::")

WRONG_TOKEN = "wrong token: a view has a new address at each start; open the one that it printed last"


def admits_host(listening: str, header: str) -> bool:
    """Whether a Host header names this machine, where the server listens on the host `listening`.

    Any port is right, because ports may be forwarded. A foreign page may let a name resolve to this machine (DNS
    rebinding). Its Host header still carries that name.
    """
    try:
        parts = urlsplit(f"//{header}")
        _ = parts.port  # raises where it is no number
    except ValueError:
        return False
    if parts.hostname is None or parts.netloc != header or "@" in header:
        return False
    name, own = parts.hostname, socket.gethostname().lower()
    if listening not in EVERYWHERE:
        return name in (*LOOPBACK, listening.lower())
    with suppress(ValueError):
        return bool(ipaddress.ip_address(name))
    return name in (*LOOPBACK, own, f"{own.split('.')[0]}.local")


SAMPLE_TIME = 0.01  # Time between two rows of an export [s].
MOST_SAMPLES = 20_000  # Most rows of an exported motion: some megabytes for seven joints.


class Download(NamedTuple):
    """A file: its content type, and the ending of its name after the arm's name.

    The loop calls `prepare(stage, drawing)`, which copies what it needs from the stage. A thread calls the result,
    which returns the text and must not touch the stage. Both may raise InputError with the reason why there is no file.
    """

    content_type: str
    ending: str
    prepare: Callable[[Stage, Drawing], Callable[[], str | bytes]]


def _motion(kind: str, stage: Stage, drawing: Drawing) -> Callable[[], str | bytes]:
    playback = stage.playback
    if playback is None:
        raise InputError("there is no motion to export: plan one in the Poses panel")
    return partial(written, playback.trajectory, kind, Writing(max(SAMPLE_TIME, playback.duration / MOST_SAMPLES)))


def _scene(stage: Stage, drawing: Drawing) -> Callable[[], str]:
    if stage.collisions.scene is None:
        raise InputError("there is no scene yet: turn on the layer Collision first")
    return partial(scene_text, stage.collisions.scene.content(), Path.cwd())


DOWNLOADS: Mapping[str, Download] = {
    "arm.html": Download("text/html; charset=utf-8", ".html", lambda *shown: partial(stand_alone, on_show(*shown))),
    "scene.toml": Download("application/toml", "_scene.toml", _scene),
    "motion.csv": Download("text/csv; charset=utf-8", "_motion.csv", partial(_motion, "csv")),
    "motion.json": Download("application/json", "_motion.json", partial(_motion, "json")),
    "motion.h": Download("text/plain; charset=utf-8", "_motion.h", partial(_motion, "header")),
}
"""Downloads by their name under the token."""

TYPES = {
    "html": "text/html; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "json": "application/json",
    "wasm": "application/wasm",
}

# Headers of every answer, refusals included.
HEADERS = {"Cache-Control": "no-store", "Referrer-Policy": "no-referrer", "X-Content-Type-Options": "nosniff"}

POLICY = (
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; "
    "connect-src 'self' ws://{host} wss://{host}; base-uri 'none'; form-action 'none'; "
    "frame-ancestors http://localhost:* http://127.0.0.1:*"
)
"""No script but our own files, and no eval but of WebAssembly. Meshcat's bundle writes style attributes, hence inline
styles.

A frame may hold the page where all that surrounds it comes from this machine, by http or https on any port: Jupyter
does. Whoever would have hands click on it unseen must have a server here, and know the token. ([::1] cannot be said.)
"""

REPLIES = ("done", "error")  # Requests that answer the page itself, for any arm.
PING_TIME = 20  # Seconds between two pings of a page, and until a silent page is dropped.

# Tornado logs each malformed request; a program that wants to read that sets up logging.
logging.getLogger("tornado").addHandler(logging.NullHandler())


def application(server: Server) -> tornado.web.Application:
    """Everything stands under the token."""
    return tornado.web.Application(
        [
            (r"/([^/]*)/socket", SocketHandler),
            (rf"/([^/]*)/({'|'.join(map(re.escape, DOWNLOADS))})", DownloadHandler),
            (r"/([^/]*)/?(.*)", PageHandler),
        ],
        default_handler_class=Guarded,
        server=server,
        files=_page_files(),
        log_function=lambda handler: None,
        websocket_max_message_size=LARGEST_MESSAGE,
        websocket_ping_interval=PING_TIME,
        websocket_ping_timeout=PING_TIME,
    )


def _page_files() -> dict[str, tuple[str, bytes]]:
    """Each file by its name under the token: (content type, content). '' is the page.

    index.html requests all modules of main.js at once.
    """
    folder = files("twistarm.viewer").joinpath("page")
    named = {item.name: item.name.rpartition(".")[2] for item in folder.iterdir()}
    served = {
        name: (TYPES[ending], folder.joinpath(name).read_bytes()) for name, ending in named.items() if ending in TYPES
    }
    served["meshcat.js"] = (TYPES["js"], meshcat_bundle().encode())
    links = [f'<link rel="modulepreload" href="{name}">' for name in modules("main.js")]
    links.append('<link rel="preload" href="schema.json" as="fetch" crossorigin>')
    kind, page = served["index.html"]
    served[""] = kind, page.replace(b"</head>", "\n".join([*links, "</head>"]).encode(), 1)
    return served


class Guarded(tornado.web.RequestHandler):
    """A GET with our token and a Host and Origin of ours. Other requests are refused in one line."""

    SUPPORTED_METHODS = ("GET",)

    def initialize(self) -> None:
        """Called by tornado first."""
        self.server: Server = self.settings["server"]

    def set_default_headers(self) -> None:
        """On every answer, errors included."""
        for name, value in HEADERS.items():
            self.set_header(name, value)
        self.clear_header("Server")

    def prepare(self) -> None:
        """Called by tornado before the method."""
        if not admits_host(self.server.host, self.request.headers.get("Host") or self.server.host):
            raise tornado.web.HTTPError(403, reason="foreign Host")
        origin = self.request.headers.get("Origin")  # programs send none
        if origin is not None and urlsplit(origin).netloc != self.request.headers.get("Host"):
            raise tornado.web.HTTPError(403, reason="foreign Origin")
        token = self.request.path.partition("/")[2].partition("/")[0]
        # It takes as long for every wrong token, so none is guessed letter by letter.
        if not hmac.compare_digest(token.encode(), self.server.token.encode()):
            raise tornado.web.HTTPError(403, reason=WRONG_TOKEN)

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
        served: Mapping[str, tuple[str, bytes]] = self.settings["files"]
        if name not in served:
            raise tornado.web.HTTPError(404)
        kind, content = served[name]
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
        arm = re.sub(r"[^A-Za-z0-9._-]", "_", self.server.stage.arm.name)[:100]  # what every system and header takes
        self.set_header("Content-Type", download.content_type)
        self.set_header("Content-Disposition", f'attachment; filename="{arm}{download.ending}"')
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

    Thread(target=run, name="twistarm file", daemon=True).start()
    return await asyncio.wrap_future(done)


class SocketHandler(Guarded, tornado.websocket.WebSocketHandler):
    """One page. Its outbox keeps the latest message of each type, so a slow page costs nothing."""

    def initialize(self) -> None:
        """Called by tornado first."""
        super().initialize()
        self._outbox: dict[str, str] = {}
        self._drawing: Drawing | None = None  # of which the page has been sent the first objects
        self._waiting = asyncio.Event()
        self._sender: asyncio.Task[None] | None = None
        self._sent = 0
        self.name = next(self.server.names)

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
            written.add_done_callback(lambda done: done.cancelled() or done.exception())  # the last one's is raised
        await written
