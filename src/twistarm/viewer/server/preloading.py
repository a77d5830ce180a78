"""Preload links in the page's head: the browser asks for all that the page needs at once."""

from __future__ import annotations

from ..files.page_export import modules

BEFORE = b"</head>"


def with_preloads(page: bytes) -> bytes:
    """index.html with a link for each module that main.js runs, and for the schema that it reads.

    Else a browser learns of a module from the one that imports it, and asks again and again before the page can begin.
    """
    links = [f'<link rel="modulepreload" href="{name}">' for name in modules("main.js")]
    links.append('<link rel="preload" href="schema.json" as="fetch" crossorigin>')
    return page.replace(BEFORE, "\n".join([*links, ""]).encode() + BEFORE, 1)
