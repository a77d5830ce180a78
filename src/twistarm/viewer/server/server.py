"""The viewer's web server: a thread with an event loop, a secret path, a socket per page."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future, wait
from contextlib import suppress
from errno import EACCES, EADDRINUSE
from functools import partial
from itertools import count
from secrets import token_urlsafe
from socket import socket
from typing import Any, Protocol, TypeVar

from tornado.httpserver import HTTPServer
from tornado.netutil import bind_sockets
from tornado.web import Application

from ...arm.arm import Arm
from ...support.checks import Progress
from ...support.errors import InputError, TwistarmError, quote
from ...support.strict_json import encode
from ..jobs import Job, Workers
from ..messages import ChangePublisher, Message, PageRequest, Source, failure, number_of, parse
from ..parts.arm_data import doctor_findings
from ..scene.arm_drawing import Drawing
from ..stage import Stage
from .driver import COMMANDS, Driver, PageCommands

FRAME_TIME = 1.0 / 60.0
START_TIME = 10.0
STOP_TIME = 5.0
PATIENCE = 0.1
CALM_TIME = 0.5
IDLE_TIME, LARGEST_HEAD = 30.0, 16 * 1024

Change = Callable[[Stage], None]
T = TypeVar("T")


class Client(Protocol):
    """A page's socket. Messages of the same kind replace each other while they wait."""

    def begin(self, texts: Mapping[str, str]) -> None:
        """Send the messages of the whole state, by kind."""

    def put(self, kind: str, text: str) -> None:
        """Send a message of this kind."""

    def close(self, code: int, reason: str) -> None:
        """Close the socket."""


class Server:
    """Serves a stage to any number of pages. Methods that other threads may call come first."""

    def __init__(
        self, stage: Stage, drawing: Drawing, host: str, port: int, application: Callable[[Server], Application]
    ) -> None:
        """application: makes the handlers of the requests to a server."""
        self._application = application
        self.host, self.token = host, token_urlsafe(16)
        self.commands = PageCommands(stage.arm)
        self.clients: dict[Client, None] = {}
        self._sockets = bind(host, port)  # before the thread: the caller gets the error of a port in use
        self.port = int(self._sockets[0].getsockname()[1])
        self.notice: Message = {"type": "notice", "words": "", "wrong": False}
        self._lock = threading.Lock()
        self._changes: dict[str, Change] = {}
        self._applied = 0.0
        self.names = (f"page {number}" for number in count(1))  # each page is a separate sender of commands
        self._jobs: dict[str, float | None] = {}
        self._needs: dict[str, set[str]] = {}  # by page
        self._routes: dict[str, Callable[..., None]] = {
            "servo": lambda sender, on: self.driver.switch(on),
            "on_unreachable": self._choose,
            "exact": self._draw_exactly,
            "needs": self._need,
        }
        self._adopt(stage, drawing)
        self._workers = Workers(
            self._deliver, lambda key, share: self.post(f"job {key}", lambda stage: self._jobs.update({key: share}))
        )
        self._player: asyncio.Task[None] | None = None
        self._thread = threading.Thread(target=lambda: asyncio.run(self._main()), name="twistarm viewer", daemon=True)
        self._started = threading.Event()

    def _adopt(self, stage: Stage, drawing: Drawing) -> None:
        """Make this the arm on show, and make everything that belongs to one arm."""
        self.stage, self.drawing = stage, drawing
        self.commands.arm = stage.arm
        self.show_choice()
        self.driver = Driver(stage, self.commands, self.post)
        self._publisher = ChangePublisher()

    def start(self) -> None:
        """Return once pages are served."""
        self._thread.start()
        if not self._started.wait(START_TIME):
            raise InputError(f"the viewer's server did not start within {START_TIME:g} s")
        self._draw_meshes()

    def stop(self) -> None:
        """Close every page's socket and the port, and end the thread. Harmless when repeated."""
        self.stage.controls.waiting.clear()
        self.driver.close(STOP_TIME)
        if self._thread.is_alive():
            with suppress(RuntimeError):  # the loop may have been closed meanwhile, by another thread's stop
                self._loop.call_soon_threadsafe(self._stop.set)
            self._thread.join(STOP_TIME)
        self.drawing.close()
        self._workers.stop(STOP_TIME)

    def post(self, key: str, change: Change) -> None:
        """Let the loop apply `change`, at most once in FRAME_TIME. It replaces a waiting change of the same key.

        A fast caller pays for a frame 60 times a second, and otherwise for a lock.
        """
        with self._lock:
            first = not self._changes  # else the loop is awake already
            self._changes.pop(key, None)  # so that the latest change is applied last
            self._changes[key] = change
        if first and self._thread.is_alive():
            with suppress(RuntimeError):  # the loop may have been closed meanwhile
                self._loop.call_soon_threadsafe(self._apply_in_time)

    def exchange(self, arm: Arm) -> list[str]:
        """Show another arm. Returns the words of `Stage.take_over`. InputError while a servo drives, or once closed."""
        if not self._thread.is_alive():
            raise InputError("the viewer is closed: open another by Viewer(arm)")
        stage, drawing = Stage(arm), self.drawing.successor(arm)
        return self.ask(lambda _: self._exchange(stage, drawing))

    def notify(self, words: str, wrong: bool = False) -> None:
        """Show a notice on the pages until the next one. `wrong` marks an error."""
        notice = {"type": "notice", "words": words, "wrong": wrong}
        self.post("notice", lambda stage: setattr(self, "notice", notice))

    def _draw_meshes(self) -> None:
        """Read the meshes in a thread while pages are served. Each progress report updates the pages."""
        drawing, meshes = self.drawing, self.drawing.left

        def draw(progress: Progress) -> None:
            while drawing.draw():
                progress(max(0.0, 1.0 - drawing.left / meshes))

        if meshes:
            self._workers.submit(Job("scene", "reading the meshes", draw, lambda result: None))

    def _deliver(self, action: Callable[[], None]) -> None:
        """Finish a job: run `action` in the loop at once, then update the pages."""
        with suppress(RuntimeError):  # the loop may have been closed meanwhile
            for step in (action, self.publish):
                self._loop.call_soon_threadsafe(self._try, step)

    def ask(self, question: Callable[[Stage], T]) -> T:
        """The answer of `question(stage)`, after every change posted so far. A closed view answers as it stands.

        Raises TwistarmError where the loop does not answer within STOP_TIME.
        """
        future: Future[T] = Future()
        with suppress(RuntimeError):  # the loop may have been closed, which is seen below
            self._loop.call_soon_threadsafe(self._answer, question, future)
        end = time.monotonic() + STOP_TIME
        while self._thread.is_alive() and not wait([future], PATIENCE).done:
            if time.monotonic() > end:
                raise TwistarmError(f"the viewer did not answer within {STOP_TIME:g} s; it is busy: ask again")
        return future.result() if future.done() else question(self.stage)

    # everything below runs in the loop ------------------------------------------------------------------

    async def _main(self) -> None:
        self._loop, self._stop = asyncio.get_running_loop(), asyncio.Event()
        # Pages send through their sockets only, so no request has a body.
        listener = HTTPServer(
            self._application(self), idle_connection_timeout=IDLE_TIME, max_header_size=LARGEST_HEAD, max_body_size=0
        )
        listener.add_sockets(self._sockets)
        self._consultation = self._loop.create_task(self._examine_in_calm())
        self._started.set()
        await self._stop.wait()
        listener.stop()
        self._consultation.cancel()
        self._apply()
        for client in list(self.clients):
            client.close(1001, "the viewer was closed")
        await listener.close_all_connections()

    def _exchange(self, stage: Stage, drawing: Drawing) -> list[str]:
        old = self.stage
        if old.driven:
            raise InputError(f"a servo drives {old.arm.name}: end it, then load another arm")
        words = stage.take_over(old)
        self._consultation.cancel()
        drawing.draw_again(self.drawing.exact)
        self._adopt(stage, drawing)
        self._consultation = self._loop.create_task(self._examine_in_calm())
        self._draw_meshes()
        self._submit(stage.reach.due(stage))
        texts = self.state()
        for client in self.clients:
            client.begin(texts)
        self.publish()
        return words

    async def _examine_in_calm(self) -> None:
        """Have the doctor examine the arm after CALM_TIME [s] of calm. So page loads and servos are not delayed."""
        stage, calm = self.stage, 0
        while calm < 2:
            calm = calm + 1 if self.clients and not stage.driven and not self.drawing.left else 0
            await asyncio.sleep(CALM_TIME if calm < 2 else 0.0)
        show = partial(setattr, stage, "findings")
        self._workers.submit(Job("doctor", "examining the arm", lambda progress: doctor_findings(stage.arm), show))

    def state(self) -> dict[str, str]:
        """The messages of the whole view, by type. Other pages get the recent changes too."""
        self._send_changes()
        return self._publisher.everything()

    def _send_changes(self) -> None:
        sources: list[Source] = [self._own_messages, *self.stage.sources()]
        for kind, text in self._publisher.gather(sources).items():
            self._send_to_all(kind, text)

    def _own_messages(self) -> list[Message]:
        jobs = [{"key": key, "share": share} for key, share in self._jobs.items() if share is not None]
        return [{"type": "work", "jobs": jobs}, self.drawing.message(), self.notice]

    def receive(self, text: str | bytes, sender: str) -> list[dict[str, Any]]:
        """Do the request of the page `sender`, update every page, and return the sender's replies.

        A command to the servo changes nothing on show. The resulting motion does.
        """
        try:
            request = parse(text)
        except Exception as error:
            self.commands.refuse(sender, str(error))
            number = number_of(text)
            return [failure(error), *([] if number is None else [{"type": "done", "number": number}])]
        replies: list[dict[str, Any]] = []
        try:
            self._do(request, sender)
        except Exception as error:
            replies.append(failure(error))
        return [*replies, {"type": "done", "number": request.number}]

    def _do(self, request: PageRequest, sender: str) -> None:
        if request.kind in COMMANDS:
            return self.commands.take(request, sender)
        self._apply()
        if request.kind in self._routes:
            self._routes[request.kind](sender, **request.fields)
        else:
            self._submit(self.stage.handle(request, time.monotonic()))
        self.publish()

    def _choose(self, sender: str, what: str) -> None:
        self.commands.on_unreachable = what
        self.show_choice()

    def _draw_exactly(self, sender: str, on: bool) -> None:
        if on != self.drawing.exact:
            self.drawing.draw_again(on)
            self._draw_meshes()

    def _submit(self, job: Job | None) -> None:
        if job is not None:
            self._workers.submit(job)

    def _need(self, sender: str, **needs: bool) -> None:
        """Make what a page needs, as long as one does."""
        self._needs[sender] = {name for name, needed in needs.items() if needed}
        self.stage.needed = frozenset().union(*self._needs.values())
        self._submit(self.stage.reach.due(self.stage))

    def show_choice(self) -> None:
        """Show the servo's behaviour where the arm cannot follow, and whether pages may choose it."""
        self.stage.show_choice(self.commands.on_unreachable, self.commands.free)

    def leave(self, sender: str) -> None:
        """Forget a page that has gone, and what it needs. After the last page, end Drive."""
        self.commands.refuse(sender, "its page has gone")
        if not self.clients:
            self.driver.switch(False)
        self._need(sender)
        del self._needs[sender]

    def publish(self) -> None:
        """Send the latest changes to every page, and keep a motion going."""
        if self.clients:
            self._send_changes()
            if not self.drawing.left:
                self._submit(self.stage.collisions.due(self.stage))
        if self.stage.moving and (self._player is None or self._player.done()):
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

    def current(self) -> Stage:
        """The stage once every change posted so far is applied."""
        self._apply()
        return self.stage

    def _answer(self, question: Callable[[Stage], T], future: Future[T]) -> None:
        try:
            future.set_result(question(self.current()))
        except Exception as error:
            future.set_exception(error)

    async def _play(self) -> None:
        while self.stage.moving:
            await asyncio.sleep(FRAME_TIME)
            self._try(lambda: self.stage.advance(time.monotonic()))
            self._try(self.publish)

    def _try(self, action: Callable[[], None]) -> None:
        """Show an error of `action` on the pages. The server goes on."""
        try:
            action()
        except Exception as error:
            self._send_to_all("error", encode(failure(error)))

    def _send_to_all(self, kind: str, text: str) -> None:
        for client in self.clients:
            client.put(kind, text)


def bind(host: str, port: int) -> list[socket]:
    """Sockets that listen on `host` and `port` (0: a free one). InputError where that is impossible."""
    if not isinstance(port, int) or isinstance(port, bool) or not 0 <= port <= 65535:
        raise InputError(f"port must be 0 (a free one) … 65535; got {quote(port)}")
    try:
        return bind_sockets(port, host or None)
    except (OSError, UnicodeError) as error:
        why = {
            EADDRINUSE: f"port {port} is in use on {host}; take another, or --port 0 (port=0) for a free one",
            EACCES: f"port {port} needs more rights than this user has; take one above 1023",
        }
        other = f"cannot listen on host {host!r}: {error}; use 127.0.0.1, or an address of this machine"
        raise InputError(why.get(getattr(error, "errno", 0), other)) from error
