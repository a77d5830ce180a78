"""Attacks on the view's server by who does not know the token."""

from __future__ import annotations

import random
import socket
import struct
from collections.abc import Callable
from contextlib import suppress

from .target import HANDSHAKE, POSE, TEXT, Target, asked, flooded, frame


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
