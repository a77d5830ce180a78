"""Waiting for what a page shows. Playwright's own way needs eval in the page, which the page's policy forbids."""

from __future__ import annotations

import time
from typing import Any

# Seconds until something that should happen at once counts as not happening, on a busy machine too.
WAIT = 20.0


def until(page: Any, condition: str) -> None:
    """Wait for a JavaScript expression."""
    end = time.monotonic() + WAIT
    while not page.evaluate(f"Boolean({condition})"):
        assert time.monotonic() < end, f"the page never showed {condition}"
        time.sleep(0.02)


def idle(page: Any) -> None:
    """Wait until the process has answered all that a live page has asked."""
    until(page, "twistarm.link.underway === 0 && twistarm.link.pending.size === 0")


def after_frames(page: Any) -> None:
    """Wait until the view has been rendered as it stands now: the first frame that comes may be under way."""
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def draw(page: Any) -> None:
    """Fill the view from now on, until another page is loaded: for tests that look at its pixels."""
    page.evaluate("globalThis.undrawn = false, twistarm.view.viewer.set_dirty()")
    after_frames(page)


def settled(page: Any, url: str) -> Any:
    """Open a live page and wait until the arm stands on it."""
    page.goto(url)
    until(page, "globalThis.twistarm?.state.fitted")
    return page
