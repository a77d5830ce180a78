"""A headless Chromium for the tests of the page."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from functools import cache, partial
from pathlib import Path
from typing import Any

import pytest

from arms import load
from chromium import launched
from twistarm import Arm
from twistarm.viewer import Viewer
from waiting import settled

UNDRAWN = """
globalThis.undrawn = true;
for (const { prototype } of [WebGLRenderingContext, WebGL2RenderingContext]) {
  for (const name of ["clear", "drawArrays", "drawElements", "drawArraysInstanced", "drawElementsInstanced"]) {
    const draw = prototype[name];
    prototype[name] = function (...what) { if (!globalThis.undrawn) draw.apply(this, what); };
  }
}"""
"""Software fills a view in 0.1 s to 0.4 s, a graphics card at once: pages do all but fill it, until `draw` asks."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """One test of each panel is among the quick ones, marked smoke; the others are long ones."""
    for item in items:
        if item.path.parent == Path(__file__).parent and not item.get_closest_marker("smoke"):
            item.add_marker("slow")


@pytest.fixture(scope="package")
def browser() -> Iterator[Any]:
    """Closed after this folder: while it is open, playwright's event loop runs in this thread, and no other can."""
    with launched() as browser:
        yield browser


@contextmanager
def watched(browser: Any) -> Iterator[Any]:
    """A page in a window of its own; none of its scripts may fail."""
    context = browser.new_context(viewport={"width": 1280, "height": 720}, color_scheme="light")
    context.add_init_script(UNDRAWN)
    opened = context.new_page()
    errors: list[str] = []
    opened.on("pageerror", lambda error: errors.append(str(error)))
    opened.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
    yield opened
    context.close()
    assert errors == []


@pytest.fixture(scope="package")
def open_page(browser: Any) -> Callable[[], AbstractContextManager[Any]]:
    """Opens pages: `with open_page() as page`."""
    return partial(watched, browser)


@pytest.fixture
def page(open_page: Callable[[], AbstractContextManager[Any]]) -> Iterator[Any]:
    """A page of the test's own."""
    with open_page() as opened:
        yield opened


@pytest.fixture
def other(open_page: Callable[[], AbstractContextManager[Any]]) -> Iterator[Any]:
    """A second page beside it, as somebody else's."""
    with open_page() as opened:
        yield opened


@pytest.fixture(params=["rover_arm"])
def arm(request: pytest.FixtureRequest) -> Arm:
    return load(request.param)


@pytest.fixture
def viewer(arm: Arm) -> Iterator[Viewer]:
    with Viewer(arm, open_browser=False) as served:
        yield served


Shown = Callable[..., tuple[Any, Viewer]]


@pytest.fixture(scope="module")
def shown(open_page: Callable[[], AbstractContextManager[Any]]) -> Iterator[Shown]:
    """A page and its viewer for each arm by name, in a window of `size`: opening one takes a second or two."""
    with ExitStack() as stack:

        @cache
        def of(name: str, size: tuple[int, int] = (1280, 720)) -> tuple[Any, Viewer]:
            viewer = stack.enter_context(Viewer(load(name), open_browser=False))
            page = stack.enter_context(open_page())
            page.set_viewport_size({"width": size[0], "height": size[1]})
            return settled(page, viewer.url), viewer

        yield of


@pytest.fixture(scope="module")
def opened(open_page: Callable[[], AbstractContextManager[Any]], viewer: Viewer) -> Iterator[Any]:
    """One page for all tests of a module whose viewer is one: opening one takes a second."""
    with open_page() as page:
        yield settled(page, viewer.url)
