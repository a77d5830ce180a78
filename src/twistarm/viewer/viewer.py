"""The live view: an arm in the browser, drawn by Meshcat, moved from Python and from the page."""

from __future__ import annotations

import os
import sys
import threading
import time
import webbrowser
from contextlib import suppress
from pathlib import Path

from numpy.typing import ArrayLike

from ..arm import Arm
from ..checks import Array, as_positive
from ..closing import Closing
from ..planning.trajectory import Trajectory
from ..servo import ServoOutput
from ..stream import Cycle, Inbox
from .admission import check_trajectory, checked_theta
from .drawing import require_meshcat
from .export import save_html
from .path import NO_PATH, tool_path
from .scene import build_scene
from .screenshot import save_png
from .servo_words import servo_words
from .stage import Stage


class Viewer(Closing):
    """A view of `arm` at `theta` (ready where not given), served to the browser until `close`.

    host: the interface to listen on; anything but the default opens the view to a network, the token still required.
    port: 0 takes a free one. open_browser: show the page at once; where no browser is found, `url` is there to open.
    A context manager. Every method may be called from any thread and returns at once.

    Raises InputError for a theta of the wrong shape or a port in use, MissingExtraError without Meshcat.
    """

    def __init__(
        self,
        arm: Arm,
        theta: ArrayLike | None = None,
        *,
        host: str = "127.0.0.1",
        port: int = 0,
        open_browser: bool = True,
    ) -> None:
        require_meshcat()
        from .server import Server

        self.arm = arm
        self._host = host
        self._closed = threading.Event()
        self._server = Server(Stage(arm, theta), build_scene(arm), host, port)
        self._server.start()
        if open_browser:
            show_in_browser(self.url)

    @property
    def url(self) -> str:
        """The page's address, its secret token included: whoever knows it can move the view."""
        name = {"": "127.0.0.1", "0.0.0.0": "127.0.0.1", "::": "::1"}.get(self._host, self._host)
        return f"http://{f'[{name}]' if ':' in name else name}:{self._server.port}/{self._server.guard.token}/"

    @property
    def theta(self) -> Array:
        """The configuration (n,) on show [rad, m], whoever set it: Python, a slider, or a trajectory that plays."""
        return self._server.ask(lambda stage: stage.theta.copy())

    def show(self, theta: ArrayLike) -> None:
        """Stand at theta (n,) [rad, m]. Called faster than the pages can draw, the latest wins."""
        checked = checked_theta(self.arm, theta).copy()
        self._server.post("show", lambda stage: stage.show(checked))

    def play(self, trajectory: Trajectory, speed: float = 1.0, loop: bool = False) -> None:
        """Play `trajectory` from its start, `speed` times as fast, again and again with `loop`; returns at once."""
        check_trajectory(self.arm, trajectory)
        times = as_positive(speed, "speed")
        self._server.post("play", lambda stage: stage.load(trajectory, times, loop, time.monotonic()))

    @property
    def commands(self) -> Inbox:
        """What the pages command by keyboard and gamepad, as a source for `twistarm.stream`; once asked for, they may.

        Each page is a commander of its own, and two at once bring the arm to rest. Until `show_servo(None)`, sliders,
        poses and trajectories of the pages are refused.
        """
        self._server.commands.open = True
        self._server.post("jogging", lambda stage: stage.take_commands())
        return self._server.commands.inbox

    def show_servo(self, answer: Cycle | ServoOutput | None) -> None:
        """Show what a cycle of `twistarm.stream.run` came to: where the joints are, and the servo's status and reason.

        An answer of `servo_step` gives status and reason alone; None: the servo has ended, and sliders work again.
        Called at any rate, the latest is shown, at most 60 times a second.
        """
        if isinstance(answer, Cycle) and answer.theta is not None:
            self.show(answer.theta)
        self._server.commands.open = self._server.commands.open and answer is not None
        report = None if answer is None else servo_words(answer)
        self._server.post("servo", lambda stage: stage.hear(report))

    def show_screws(self, visible: bool = True) -> None:
        """Draw each joint's screw axis where it lies at the configuration on show, or draw none."""
        self._server.post("screws", lambda stage: stage.set_visible("screws", bool(visible)))

    def show_frames(self, visible: bool = True) -> None:
        """Draw the space and the tool frame, or do not."""
        self._server.post("frames", lambda stage: stage.set_visible("frames", bool(visible)))

    def show_path(self, motion: Trajectory | ArrayLike | None) -> None:
        """Draw the way of the tool's origin along a trajectory, or through configurations (k, n); None draws none."""
        path = NO_PATH if motion is None else tool_path(self.arm, motion)
        self._server.post("path", lambda stage: stage.draw_path(path))

    def save_html(self, path: str | os.PathLike[str], trajectory: Trajectory | None = None) -> Path:
        """Write a stand-alone page of the arm as it stands; see `twistarm.viewer.save_html`."""
        return save_html(self.arm, path, trajectory, self.theta)

    def save_png(self, path: str | os.PathLike[str], *, size: tuple[int, int] = (1280, 720)) -> Path:
        """Write a picture of the arm as it stands, width and height in pixels; see `twistarm.viewer.save_png`."""
        return save_png(self.arm, path, self.theta, size=size)

    def wait(self) -> None:
        """Serve until Ctrl-C or until `close` is called elsewhere; Ctrl-C closes the view and returns."""
        try:
            while not self._closed.wait(0.5):
                pass
        except KeyboardInterrupt:
            self.close()

    def close(self) -> None:
        """Stop serving; nothing is left running. Harmless when repeated."""
        self._closed.set()
        self._server.stop()


def show_in_browser(url: str) -> bool:
    """Open `url` in the user's browser if there is one with a window: one in the terminal would take it over."""
    windowless = sys.platform.startswith("linux") and not any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY")))
    if windowless and not os.environ.get("BROWSER"):
        return False
    with suppress(webbrowser.Error):
        return webbrowser.open(url)
    return False
