"""The gateway of the view: who gets in, how many at a time and for how long, and that a crowd outside stops nobody."""

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

from .authentication import Authentication
from .client_connection import LARGEST_HEAD, ClientConnection, Peer, first_to_leave, name_of
from .one_time_addresses import USED, OneTimeAddresses
from .server_log import ServerLog

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


class Gateway(HTTPServerConnectionDelegate):
    """Accepts connections and looks at the head of each request before `inside` hears of it.

    What does not show the token is told so and closed. Where strangers, or others, are more than there are places, the
    peer that has the most of them gives up the one that has been there for longest: who comes is let in.
    """

    def __init__(
        self,
        inside: HTTPServerConnectionDelegate,
        authentication: Authentication,
        one_time_addresses: OneTimeAddresses,
        log: ServerLog,
    ) -> None:
        self._inside, self._authentication, self._log = inside, authentication, log
        self._one_time_addresses = one_time_addresses
        self._places = places(resource.getrlimit(resource.RLIMIT_NOFILE)[0])
        self._strangers: dict[ClientConnection, None] = {}
        self._known: dict[ClientConnection, None] = {}
        self._peers: WeakValueDictionary[str, Peer] = WeakValueDictionary()
        # Nothing is sent to the view by a body.
        self._http = HTTPServer(
            self, idle_connection_timeout=IDLE_TIME, max_header_size=LARGEST_HEAD, max_body_size=0,
            body_timeout=LOOK,
        )  # fmt: skip

    async def serve(self, sockets: Sequence[socket.socket], stop: asyncio.Event) -> None:
        """Let clients in until `stop` is set, and none after."""
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
            self._let_in(ClientConnection(connection, self._peer(name_of(address)), ports, self._forget))

    def _peer(self, name: str) -> Peer:
        """The one of this name, kept for as long as it is here."""
        return self._peers.setdefault(name, Peer(name))

    def _pause(self, listening: socket.socket, error: OSError) -> None:
        """Without descriptors: a stranger gives up one, and the loop does something else."""
        self._log.say("accept", f"a connection could not be accepted: {error.strerror or error}")
        if self._strangers:
            first_to_leave(self._strangers).close()
        loop = asyncio.get_running_loop()
        loop.remove_reader(listening)
        loop.call_later(PAUSE, self._listen, listening)

    def _let_in(self, client: ClientConnection) -> None:
        if len(self._strangers) >= self._places:
            leaving = first_to_leave(self._strangers)
            leaving.close()
            self._log.say("crowd", CROWD.format(self._places, leaving.peer.name))
        self._strangers[client] = None
        self._http.handle_stream(client, (client.peer.name, 0))

    def _forget(self, client: ClientConnection) -> None:
        self._strangers.pop(client, None)
        self._known.pop(client, None)

    def welcome(self, client: ClientConnection) -> None:
        """The client has shown the token."""
        self._forget(client)
        others = [each for each in self._known if not each.page]
        if len(others) >= self._places:
            first_to_leave(others).close()
        self._known[client] = None
        client.welcome()

    async def _look(self) -> None:
        while True:
            await asyncio.sleep(LOOK)
            for client in [each for each in (*self._strangers, *self._known) if each.is_overdue()]:
                client.close()

    def start_request(self, server_conn: object, request_conn: HTTPConnection) -> HTTPMessageDelegate:
        """Called by tornado for each request of a connection."""
        assert isinstance(server_conn, HTTP1ServerConnection)
        assert isinstance(server_conn.stream, ClientConnection)
        return _Head(self, server_conn.stream, request_conn, self._inside.start_request(server_conn, request_conn))

    def answer(self, client: ClientConnection, start: RequestStartLine, headers: HTTPHeaders) -> Answer | None:
        """What the gateway itself has to say to a request; None: it may go in."""
        refusal = self._authentication.refusal(start.method, headers)
        if refusal is not None:
            return Answer(*refusal)
        path = start.path.partition("?")[0]
        if self._authentication.knows_token(path.split("/")[1] if path.startswith("/") else ""):
            self.welcome(client)
            return None
        words = self._one_time_addresses.refusal(path, client.ports)
        if words is None:
            return Answer(403, "wrong token: open the address the viewer gave")
        if words == USED:
            self._log.say("one-time address", TWICE)
        return Answer(403, words) if words else Answer(302, "Found", f"/{self._authentication.token}/")


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
    """A request: its head is looked at, and what the gateway answers goes no further, be its body ever so long."""

    def __init__(
        self, gateway: Gateway, client: ClientConnection, connection: HTTPConnection, inside: HTTPMessageDelegate
    ) -> None:
        self._gateway, self._client, self._connection, self._inside = gateway, client, connection, inside
        self._let_in = False

    async def headers_received(self, start_line: RequestStartLine | ResponseStartLine, headers: HTTPHeaders) -> None:
        """Called by tornado; between two requests of one computer the others have their turn."""
        assert isinstance(start_line, RequestStartLine)
        assert isinstance(self._connection, HTTP1Connection)
        if self._client.closed():  # what had come before the end is read all the same
            self._connection.detach()
            return
        answer = self._gateway.answer(self._client, start_line, headers)
        if answer is not None:
            await _send_away(self._connection.detach(), answer)
            return
        self._let_in = True
        self._inside.headers_received(start_line, headers)
        await self._client.peer.rest()

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
