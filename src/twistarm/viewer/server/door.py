"""The door of the view: who gets in, how many at a time and for how long, and that a crowd outside stops nobody."""

from __future__ import annotations

import asyncio
import resource
import socket
from collections.abc import Awaitable, Sequence
from contextlib import suppress
from typing import NamedTuple
from weakref import WeakValueDictionary

from tornado.http1connection import HTTP1Connection, HTTP1ServerConnection
from tornado.httpserver import HTTPServer
from tornado.httputil import (
    HTTPConnection,
    HTTPHeaders,
    HTTPMessageDelegate,
    HTTPServerConnectionDelegate,
    RequestStartLine,
    ResponseStartLine,
)
from tornado.iostream import IOStream, StreamClosedError

from .complaints import Complaints
from .guard import Guard
from .invitations import USED, Invitations
from .visitor import LARGEST_HEAD, Peer, Visitor, first_to_leave, name_of

MOST = 64
"""Connections at a time of strangers, and again as many of those who have shown the token and are no page's socket."""

KEPT_FREE = 128
"""Descriptors that are left for pages and files."""

IDLE_TIME = 60.0
"""Seconds that a connection of one who has shown the token is kept for the next request."""

TURN = 16
"""Connections accepted in one turn of the loop."""

PAUSE = 0.1
"""Seconds until it is tried again where the system has none to give: descriptors are used up, mostly."""

CROWD = (
    "more than {} connections do not show the view's token, most of them from {}: the oldest are closed, pages go on"
)

ALWAYS = {"Cache-Control": "no-store", "Referrer-Policy": "no-referrer", "X-Content-Type-Options": "nosniff"}
"""Headers of every answer, refusals included."""

LOOK = 1.0
"""Seconds between two looks at who is overdue."""


def places(descriptors: int) -> int:
    """How many strangers are let in, with so many descriptors in all."""
    return MOST if descriptors == resource.RLIM_INFINITY else max(8, min(MOST, (descriptors - KEPT_FREE) // 2))


class Door(HTTPServerConnectionDelegate):
    """Accepts connections and looks at the head of each request before `inside` hears of it.

    What does not show the token is told so and closed. Where strangers, or others, are more than there are places, the
    peer that has the most of them gives up the one that has been there for longest: who comes is let in.
    """

    def __init__(
        self, inside: HTTPServerConnectionDelegate, guard: Guard, invitations: Invitations, complaints: Complaints
    ) -> None:
        self._inside, self._guard, self._invitations, self._complaints = inside, guard, invitations, complaints
        self._places = places(resource.getrlimit(resource.RLIMIT_NOFILE)[0])
        self._strangers: dict[Visitor, None] = {}
        self._known: dict[Visitor, None] = {}
        self._peers: WeakValueDictionary[str, Peer] = WeakValueDictionary()
        # Nothing is sent to the view by a body.
        self._http = HTTPServer(
            self, idle_connection_timeout=IDLE_TIME, max_header_size=LARGEST_HEAD, max_body_size=0,
            body_timeout=LOOK,
        )  # fmt: skip

    async def serve(self, sockets: Sequence[socket.socket], stop: asyncio.Event) -> None:
        """Let visitors in until `stop` is set, and none after."""
        for each in sockets:
            self._listen(each)
        looking = asyncio.create_task(self._look())
        await stop.wait()
        looking.cancel()
        for each in sockets:
            asyncio.get_running_loop().remove_reader(each)
            each.close()

    async def close(self) -> None:
        """Close whatever is open and is no page's."""
        await self._http.close_all_connections()

    def _listen(self, listening: socket.socket) -> None:
        if listening.fileno() >= 0:  # else it was closed in the pause
            asyncio.get_running_loop().add_reader(listening, self._accept, listening)

    def _accept(self, listening: socket.socket) -> None:
        for _ in range(TURN):
            try:
                connection, address = listening.accept()
            except BlockingIOError:
                return
            except ConnectionAbortedError:
                continue
            except OSError as error:
                self._pause(listening, error)
                return
            ports = int(address[1]), int(listening.getsockname()[1])
            self._let_in(Visitor(connection, self._peer(name_of(address)), ports, self._forget))

    def _peer(self, name: str) -> Peer:
        """The one of this name, kept for as long as it is here."""
        return self._peers.setdefault(name, Peer(name))

    def _pause(self, listening: socket.socket, error: OSError) -> None:
        """Without descriptors: a stranger gives up one, and the loop does something else."""
        self._complaints.say("accept", f"a connection could not be accepted: {error.strerror or error}")
        if self._strangers:
            first_to_leave(self._strangers).close()
        loop = asyncio.get_running_loop()
        loop.remove_reader(listening)
        loop.call_later(PAUSE, self._listen, listening)

    def _let_in(self, visitor: Visitor) -> None:
        if len(self._strangers) >= self._places:
            leaving = first_to_leave(self._strangers)
            leaving.close()
            self._complaints.say("crowd", CROWD.format(self._places, leaving.peer.name))
        self._strangers[visitor] = None
        self._http.handle_stream(visitor, (visitor.peer.name, 0))

    def _forget(self, visitor: Visitor) -> None:
        self._strangers.pop(visitor, None)
        self._known.pop(visitor, None)

    def welcome(self, visitor: Visitor) -> None:
        """The visitor has shown the token."""
        self._forget(visitor)
        others = [each for each in self._known if not each.page]
        if len(others) >= self._places:
            first_to_leave(others).close()
        self._known[visitor] = None
        visitor.welcome()

    async def _look(self) -> None:
        while True:
            await asyncio.sleep(LOOK)
            for visitor in [each for each in (*self._strangers, *self._known) if each.is_overdue()]:
                visitor.close()

    def start_request(self, server_conn: object, request_conn: HTTPConnection) -> HTTPMessageDelegate:
        """Called by tornado for each request of a connection."""
        assert isinstance(server_conn, HTTP1ServerConnection)
        assert isinstance(server_conn.stream, Visitor)
        return _Head(self, server_conn.stream, request_conn, self._inside.start_request(server_conn, request_conn))

    def answer(self, visitor: Visitor, start: RequestStartLine, headers: HTTPHeaders) -> Answer | None:
        """What the door itself has to say to a request; None: it may go in."""
        refusal = self._guard.refusal(start.method, headers)
        if refusal is not None:
            return Answer(*refusal)
        path = start.path.partition("?")[0]
        if self._guard.knows_token(path.split("/")[1] if path.startswith("/") else ""):
            self.welcome(visitor)
            return None
        words = self._invitations.refusal(path, visitor.ports)
        if words is None:
            return Answer(403, "wrong token: open the address the viewer gave")
        if words == USED:
            self._complaints.say("invitation", TWICE)
        return Answer(403, words) if words else Answer(302, "Found", f"/{self._guard.token}/")


TWICE = (
    "the address that a browser was started with was asked for twice. If the page did not open, another user of this "
    "computer was first and knows the view's address now: end the view, and begin with --fresh where it is kept"
)


class Answer(NamedTuple):
    """Status, reason, and where to look instead."""

    status: int
    reason: str
    location: str = ""

    def text(self) -> bytes:
        """The whole of it, as it is sent; after it the connection is closed."""
        body = f"{self.status} {self.reason}\n"
        told = {**ALWAYS, "Content-Type": "text/plain; charset=utf-8", "Content-Length": str(len(body))}
        if self.location:
            told["Location"] = self.location
        lines = [f"{name}: {value}" for name, value in {**told, "Connection": "close"}.items()]
        return "\r\n".join([f"HTTP/1.1 {self.status} {self.reason}", *lines, "", body]).encode("latin-1")


class _Head(HTTPMessageDelegate):
    """A request: its head is looked at, and what the door answers itself goes no further, be its body ever so long."""

    def __init__(self, door: Door, visitor: Visitor, connection: HTTPConnection, inside: HTTPMessageDelegate) -> None:
        self._door, self._visitor, self._connection, self._inside = door, visitor, connection, inside
        self._let_in = False

    async def headers_received(self, start_line: RequestStartLine | ResponseStartLine, headers: HTTPHeaders) -> None:
        """Called by tornado; between two requests of one computer the others have their turn."""
        assert isinstance(start_line, RequestStartLine)
        assert isinstance(self._connection, HTTP1Connection)
        if self._visitor.closed():  # what had come before the end is read all the same
            self._connection.detach()
            return
        answer = self._door.answer(self._visitor, start_line, headers)
        if answer is not None:
            await _send_away(self._connection.detach(), answer)
            return
        self._let_in = True
        self._inside.headers_received(start_line, headers)
        await self._visitor.peer.rest()

    def data_received(self, chunk: bytes) -> Awaitable[None] | None:
        """Called by tornado, of what was let in alone."""
        return self._inside.data_received(chunk) if self._let_in else None

    def finish(self) -> None:
        """Called by tornado once the request is whole."""
        if self._let_in:
            self._inside.finish()

    def on_connection_close(self) -> None:
        """Called by tornado where it never will be."""
        if self._let_in:
            self._inside.on_connection_close()


async def _send_away(stream: IOStream, answer: Answer) -> None:
    """Say it and close, whatever else was sent."""
    with suppress(StreamClosedError):
        await stream.write(answer.text())
    stream.close()
