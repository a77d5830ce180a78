"""A film of a motion without a display. A headless browser draws its frames from the saved page."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from queue import Empty, Queue
from threading import Thread
from time import monotonic

from ...arm.arm import Arm
from ...planning.trajectory import Trajectory
from ...support.errors import InputError, TwistarmError, one_line
from ...support.files import write_whole
from . import headless
from .page_export import POLICY
from .scene_snapshot import of_arm
from .screenshot import checked_size, sized_page

SCRIPT = """<script type="module">
const post = (what, body) => fetch(`{address}/${{what}}`, {{ method: "POST", mode: "no-cors", body }});
try {{
  if (!globalThis.twistarm) throw new Error("drew no page, as without WebGL; update it");
  await post("film", await twistarm.share.record({width}, {height}, {rate}, (share) => post("share", share)));
}} catch ({{ message }}) {{
  post("fault", message);
}}
</script>
</body>"""
"""The script that a saved page gets: it films the motion and posts progress and film to `address`."""

SMALLER = 4
"""The film's sides divided by the page's. The browser draws both, and a small page costs little."""


def webm_of(
    arm: Arm, motion: Trajectory | None, size: tuple[int, int], rate: int, progress: Callable[[float], object]
) -> bytes:
    """`motion` at its own speed as WebM (VP8): `size` (width, height) [pixels], `rate` frames in a second.

    Raises InputError without a motion that lasts, TwistarmError without a browser or if it does not film.
    """
    width, height = checked_size(size)
    if motion is None or motion.duration == 0.0:
        raise InputError("a film shows a motion that lasts: -o FILE.webm goes with --play FILE")
    with headless.browser_at_work("film") as (browser, folder), _listening() as (address, heard):
        page = sized_page(of_arm(arm, motion), (width // SMALLER, height // SMALLER))
        script = SCRIPT.format(address=address, width=width, height=height, rate=rate)
        page = page.replace(POLICY, f"{POLICY}; connect-src {address}/", 1).replace("</body>", script, 1)
        with headless.opened(browser, write_whole(folder / "arm.html", page), (), "#pane") as ended:
            return _filmed(browser, ended, heard, progress)


@contextmanager
def _listening() -> Iterator[tuple[str, Queue[tuple[str, bytes]]]]:
    """A secret address on this machine, and the queue of what the page posts below it: name and content."""
    heard: Queue[tuple[str, bytes]] = Queue()
    secret = f"/{secrets.token_urlsafe()}"

    class Receiver(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            place, _, what = self.path.rpartition("/")
            if place == secret:
                heard.put((what, self.rfile.read(int(self.headers["Content-Length"]))))
            self.send_response(204 if place == secret else 403)
            self.end_headers()

        def log_message(self, *said: object) -> None:
            """Write no log, which nobody reads."""

    with ThreadingHTTPServer(("127.0.0.1", 0), Receiver) as server:
        Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()
        try:
            yield f"http://127.0.0.1:{server.server_port}{secret}", heard
        finally:
            server.shutdown()


def _filmed(
    browser: str, ended: headless.Ended, heard: Queue[tuple[str, bytes]], progress: Callable[[float], object]
) -> bytes:
    last, end = monotonic(), None
    while not end and monotonic() - last < headless.TIMEOUT:
        end = ended(0.0)
        try:
            what, content = heard.get(timeout=0.1)
        except Empty:
            continue
        last, end = monotonic(), None
        if what == "film":
            return content
        if what == "fault":
            raise TwistarmError(f"{browser} filmed nothing: {one_line(content.decode('utf-8', 'replace'), 300)}")
        progress(float(content))
    raise TwistarmError(f"{browser} {end or f'was ended after {headless.TIMEOUT:g} s'} and filmed nothing")
