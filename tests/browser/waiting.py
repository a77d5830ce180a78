"""Waiting for what a page shows. Playwright's own way needs eval in the page, which the page's policy forbids."""

from __future__ import annotations

import time
from typing import Any

WAIT = 20.0
"""Seconds until something that should happen at once counts as not happening; software rendering is slow."""


def until(page: Any, condition: str) -> None:
    """Wait for a JavaScript expression."""
    end = time.monotonic() + WAIT
    while not page.evaluate(f"Boolean({condition})"):
        assert time.monotonic() < end, f"the page never showed {condition}"
        time.sleep(0.02)


def settled(page: Any, url: str) -> Any:
    """Open a live page and wait until the arm stands on it."""
    page.goto(url)
    until(page, "globalThis.twistarm?.state.fitted")
    return page
