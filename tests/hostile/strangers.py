"""Attacks on the view's server by who does not know the token."""

from __future__ import annotations

import random
from collections.abc import Callable

from .target import HANDSHAKE, POSE, Target, asked, flooded, frame


def slow_head(target: Target) -> None:
    head = target.head("/stranger/", Cookie="a" * 9999)
    target.each(300, target.open, lambda k: head[k : k + 1], 0.5)


def dripped_head(target: Target) -> None:
    """A byte at a time as fast as it goes: each is looked at together with all that came before."""
    target.each(20, target.open, lambda k: b"a", 0.0)


def huge_head(target: Target) -> None:
    target.again(lambda: target.open().sendall(b"GET / HTTP/1.1\r\nX: " + b"a" * 2_000_000))


def many_chunks(target: Target) -> None:
    head = target.head("/stranger/", "POST", Transfer_Encoding="chunked")
    target.each(20, target.open, lambda k: head if k == 0 else b"1\r\na\r\n" * 1000, 0.0)


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


def foreign_host(target: Target) -> None:
    target.again(lambda: asked(target, target.head(host="evil.example")))


def foreign_origin(target: Target) -> None:
    target.again(lambda: asked(target, target.head("socket", Origin="http://evil.example", Upgrade="websocket")))


def frames_before_the_answer(target: Target) -> None:
    head = target.head("/stranger/socket", **HANDSHAKE)
    target.again(lambda: asked(target, head + frame(POSE) * 1000))


STRANGERS: dict[str, Callable[[Target], None]] = {
    attack.__name__: attack
    for attack in (
        slow_head, dripped_head, huge_head, many_chunks, odd_lengths, pipelined,
        never_reads_refusals, wrong_tokens, foreign_host, foreign_origin, frames_before_the_answer,
    )
}  # fmt: skip
