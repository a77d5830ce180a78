"""The viewer's web server: one thread with its own event loop, the page under a secret path, a socket per page."""

from __future__ import annotations

import asyncio
import errno
import socket
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from typing import Any, TypeVar

import tornado.httpserver
import tornado.netutil
import tornado.web

from ..errors import InputError
from ..strict_json import LARGEST_MESSAGE, encode
from .board import Board, Message
from .commands import COMMANDS, PageCommands
from .findings import Examination
from .guard import Guard
from .handlers import PageHandler, SocketHandler
from .jobs import Workers
from .messages import Request, parse
from .page_files import page_files
from .scene import Scene
from .stage import Stage

FRAME_TIME = 1.0 / 60.0
START_TIME = 10.0
STOP_TIME = 5.0
PING_TIME = 20

Change = Callable[[Stage], None]
Answer = TypeVar("Answer")


class Server:
    """Serves a stage to any number of pages; what other threads may call stands first."""

    def __init__(self, stage: Stage, scene: Scene, host: str, port: int) -> None:
        self.stage = stage
        self.scene = scene
        self.guard = Guard(host)
        self.commands = PageCommands(stage.arm)
        self.doctor = Examination(stage.arm, self._show_findings)
        self.clients: set[SocketHandler] = set()
        self._sockets = bind(host, port)
        self.port = int(self._sockets[0].getsockname()[1])
        self._lock = threading.Lock()
        self._changes: dict[str, Change] = {}
        self._applied = 0.0
        self._pages = 0
        self._board = Board()
        self._jobs: dict[str, float] = {}
        self._workers = Workers(self._deliver, self._show_job)
        self._player: asyncio.Task[None] | None = None
        self._thread = threading.Thread(target=lambda: asyncio.run(self._main()), name="twistarm viewer", daemon=True)
        self._started = threading.Event()

    def start(self) -> None:
        """Return once pages are served."""
        self._thread.start()
        if not self._started.wait(START_TIME):
            raise InputError(f"the viewer's server did not start within {START_TIME:g} s")

    def stop(self) -> None:
        """Close every page's socket and the port, and end the thread. Harmless when repeated."""
        if self._thread.is_alive():
            with suppress(RuntimeError):  # the loop may have been closed meanwhile, by another thread's stop
                self._loop.call_soon_threadsafe(self._stop.set)
            self._thread.join(STOP_TIME)
        self._workers.stop(STOP_TIME)
        self.doctor.join(STOP_TIME)

    def post(self, key: str, change: Change) -> None:
        """Let the loop apply `change`, at most once in FRAME_TIME; one that waits under the same key is replaced.

        Whoever posts at any rate pays for a frame 60 times a second, and else for a lock.
        """
        with self._lock:
            first = not self._changes
            self._changes.pop(key, None)
            self._changes[key] = change
        if first and self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._apply_in_time)

    def _show_findings(self, message: dict[str, Any]) -> None:
        with suppress(RuntimeError):  # the loop may have been closed meanwhile
            self.post("findings", lambda stage: setattr(stage, "findings", message))

    def _deliver(self, action: Callable[[], None]) -> None:
        """Do `action` in the loop at once, then tell the pages: the end of a job."""
        with suppress(RuntimeError):  # the loop may have been closed meanwhile
            self._loop.call_soon_threadsafe(self._finish, action)

    def _show_job(self, key: str, share: float | None) -> None:
        with suppress(RuntimeError):
            self.post(f"job {key}", lambda stage: self._note_job(key, share))

    def ask(self, question: Callable[[Stage], Answer]) -> Answer:
        """What `question` says of the stage once every change posted so far is applied."""
        if not self._thread.is_alive():
            return question(self.stage)
        future: Future[Answer] = Future()
        self._loop.call_soon_threadsafe(self._answer, question, future)
        return future.result(STOP_TIME)

    # everything below runs in the loop ------------------------------------------------------------------

    async def _main(self) -> None:
        self._loop, self._stop = asyncio.get_running_loop(), asyncio.Event()
        http = tornado.httpserver.HTTPServer(self._application())
        http.add_sockets(self._sockets)
        consultation = self._loop.create_task(self.doctor.wait(lambda: bool(self.clients) and not self.stage.driven))
        self._started.set()
        await self._stop.wait()
        consultation.cancel()
        self._apply()
        http.stop()
        for client in list(self.clients):
            client.close(1001, "the viewer was closed")
        await http.close_all_connections()

    def _application(self) -> tornado.web.Application:
        shared = {"server": self}
        return tornado.web.Application(
            [
                (r"/([^/]*)/socket", SocketHandler, shared),
                (r"/([^/]*)/?(.*)", PageHandler, {"guard": self.guard, "files": page_files()}),
            ],
            log_function=lambda handler: None,
            websocket_max_message_size=LARGEST_MESSAGE,
            websocket_ping_interval=PING_TIME,
            websocket_ping_timeout=PING_TIME,
        )

    def name_page(self) -> str:
        """A name for the next page: each is a commander of its own."""
        self._pages += 1
        return f"page {self._pages}"

    def greeting(self) -> list[str | bytes]:
        """What a new page needs before the first frame."""
        hello = self.stage.hello(self.scene.links)
        return [
            encode({**hello, "objects": len(self.scene.objects), "notes": self.scene.notes}),
            *self.scene.objects,
        ]

    def state(self) -> dict[str, str]:
        """The messages that say what is on show, by type."""
        self._board.refresh(self._messages())
        return self._board.texts()

    def _messages(self) -> list[Message]:
        jobs = [{"key": key, "share": share} for key, share in self._jobs.items()]
        return [{"type": "work", "jobs": jobs}, *self.stage.messages()]

    def receive(self, text: str | bytes, sender: str) -> list[dict[str, Any]]:
        """Do what the page `sender` asks for, tell every page, and return what only the asking one is told.

        A command to the servo changes nothing on show: what comes of it does.
        """
        try:
            request = parse(text)
        except Exception as error:
            self.commands.refuse(sender, str(error))
            return [_error(error)]
        replies: list[dict[str, Any]] = []
        try:
            self._do(request, sender)
        except Exception as error:
            replies.append(_error(error))
        return [*replies, {"type": "done", "number": request.number}]

    def _do(self, request: Request, sender: str) -> None:
        if request.kind in COMMANDS:
            self.commands.take(request, sender)
            return
        self._apply()
        job = self.stage.handle(request, time.monotonic())
        if job is not None:
            self._workers.submit(job)
        self.publish()

    def _finish(self, action: Callable[[], None]) -> None:
        self._try(action)
        self._try(self.publish)

    def _note_job(self, key: str, share: float | None) -> None:
        if share is None:
            self._jobs.pop(key, None)
        else:
            self._jobs[key] = share

    def leave(self, sender: str) -> None:
        """A page has gone."""
        self.commands.refuse(sender, "its page has gone")

    def publish(self) -> None:
        """Tell every page what changed since the last time, and keep a running trajectory running."""
        if self.clients:
            for kind, text in self._board.refresh(self._messages()).items():
                self._tell(kind, text)
        if self.stage.running and (self._player is None or self._player.done()):
            self._player = self._loop.create_task(self._play())

    def _apply_in_time(self) -> None:
        wait = self._applied + FRAME_TIME - self._loop.time()
        if wait > 0:
            self._loop.call_later(wait, self._apply)
        else:
            self._apply()

    def _apply(self) -> None:
        with self._lock:
            changes, self._changes = self._changes, {}
        if not changes:  # a question came before, and had them applied
            return
        self._applied = self._loop.time()
        for change in changes.values():
            self._try(partial(change, self.stage))
        self._try(self.publish)

    def _answer(self, question: Callable[[Stage], Answer], future: Future[Answer]) -> None:
        self._apply()
        future.set_result(question(self.stage))

    async def _play(self) -> None:
        while self.stage.running:
            await asyncio.sleep(FRAME_TIME)
            self._try(lambda: self.stage.advance(time.monotonic()))
            self._try(self.publish)

    def _try(self, action: Callable[[], None]) -> None:
        """Whatever goes wrong is shown on the pages, and the server lives on."""
        try:
            action()
        except Exception as error:
            self._tell("error", encode(_error(error)))

    def _tell(self, kind: str, text: str) -> None:
        for client in self.clients:
            client.put(kind, text)


def bind(host: str, port: int) -> Sequence[socket.socket]:
    """Sockets listening on `host` and `port` (0: a free one); InputError where that cannot be had."""
    if not isinstance(port, int) or isinstance(port, bool) or not 0 <= port <= 65535:
        raise InputError(f"port must be 0 (a free one) … 65535; got {port!r}")
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


def _error(error: Exception) -> dict[str, Any]:
    return {"type": "error", "message": str(error) or type(error).__name__}
