"""A headless Chromium for tests of pages, with the flags of the product's own pictures."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from needed import absent
from twistarm.support.errors import TwistarmError
from twistarm.viewer.screenshot import FLAGS, find_browser


@contextmanager
def launched() -> Iterator[Any]:
    try:
        path = find_browser()
    except TwistarmError as error:
        absent(str(error))
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        absent("playwright is not installed")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(FLAGS))
        yield browser
        browser.close()
