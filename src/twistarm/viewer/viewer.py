"""The live view: an arm in the browser, drawn by Meshcat, moved from Python and from the page."""

from __future__ import annotations

import os
import sys
import threading
import time
import webbrowser
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path

from numpy.typing import ArrayLike

from ..arm.arm import Arm, require_arm
from ..control.servo import ServoOutput, ServoSettings
from ..control.stream import Cycle, Inbox
from ..ik import IKSolutions
from ..planning.trajectory import Trajectory
from ..support.checks import Array, as_flag, as_positive, require
from ..support.closeable import Closeable
from ..support.errors import InputError, shown
from ..support.files import writable, write_whole
from .files.inline import HEIGHT, Inline
from .files.page_export import stand_alone
from .files.scene_snapshot import SceneSnapshot, on_show
from .files.screenshot import write_picture
from .parts.limit_checks import check_trajectory, checked_theta
from .parts.servo_words import servo_words
from .parts.solutions import answer_of
from .parts.tool_path import NO_PATH, tool_path
from .scene.arm_scene import Scene
from .scene.drawing import require_meshcat
from .server.memory import Memory
from .server.watching import Watch
from .stage import Stage

MOVED = "the program moves the arm: Drive was switched off"


class Viewer(Closeable):
    """A view of `arm` at `theta` (ready where not given), served to the browser until `close`.

    host: the interface to listen on; anything but the default opens the view to a network, the token still required.
    port: 0 takes a free one. open_browser: show the page at once; where no browser is found, `url` is there to open.
    keep: keep the recorded poses of this port in a file of this user's, for the next view at that port. Without `theta`
    the arm then stands where it stood last. `notes` says what could not be kept or taken.
    A context manager. Every method may be called from any thread. Those that move or show something return at once;
    `theta` and `recorded` wait for what was shown before, a frame at most; `save_html`, `save_png` and
    `inline(static=True)` until all is written, every mesh read; `close` until all has ended; `wait` until then.

    Raises InputError for a theta of the wrong shape or a port in use, MissingExtraError without Meshcat. What moves or
    shows something raises InputError once the view is closed.
    """

    def __init__(
        self,
        arm: Arm,
        theta: ArrayLike | None = None,
        *,
        host: str = "127.0.0.1",
        port: int = 0,
        open_browser: bool = True,
        keep: bool = False,
    ) -> None:
        require_meshcat()
        from .server.server import Server

        require_arm(arm)
        if not isinstance(host, str):
            raise InputError(f"host must be the name or address of an interface; got {shown(host)}")
        if as_flag(keep, "keep") and port == 0:
            raise InputError("poses are kept for a port that is always the same: give port=, as in port=8000")
        self._host = host
        self._watches: list[Watch] = []
        self._closed = threading.Event()
        memory = Memory(port) if keep else None
        self._server = Server(Stage(arm, theta), Scene(arm), host, port, memory, stands=theta is not None)
        self.notes: tuple[str, ...] = () if memory is None else tuple(memory.notes)
        self._server.start()
        if open_browser:
            self.open_page()

    @property
    def url(self) -> str:
        """The page's address with its secret token, new at each start: whoever knows it can move the view."""
        name = {"": "127.0.0.1", "0.0.0.0": "127.0.0.1", "::": "::1"}.get(self._host, self._host)
        authority = f"{f'[{name}]' if ':' in name else name}:{self._server.port}"
        return f"http://{authority}/{self._server.authentication.token}/"

    def open_page(self) -> bool:
        """Open the page in this user's browser; whether there is one with a window.

        The browser is started with `url`. Other users of a shared computer can read the arguments of programs: there,
        paste `url` into the browser instead.
        """
        return _started_browser(self.url)

    @property
    def arm(self) -> Arm:
        """The arm on show."""
        return self._server.stage.arm

    @property
    def theta(self) -> Array:
        """The configuration (n,) on show [rad, m], whoever set it: Python, a slider, or a trajectory that plays."""
        return self._server.ask(lambda stage: stage.theta.copy())

    def show(self, theta: ArrayLike) -> None:
        """Stand at theta (n,) [rad, m]. Called faster than the pages can draw, the latest wins."""
        self._require_open()
        self._stand(theta)

    def _stand(self, theta: ArrayLike) -> None:
        arm = self.arm
        checked = checked_theta(arm, theta).copy()
        self._server.driver.drop(MOVED)
        self._post("show", arm, lambda stage: stage.show(checked))

    def _require_open(self) -> None:
        if self._closed.is_set():
            raise InputError("the viewer was closed: there is nothing to show it in; Viewer(arm) opens another")

    def play(self, trajectory: Trajectory, speed: float = 1.0, loop: bool = False) -> None:
        """Play `trajectory` from its start, `speed` times as fast, again and again with `loop`; returns at once.

        Args:
            trajectory: A motion of the arm on show.
            speed: Playback speed, 1 as planned.
            loop: Whether it plays again and again.

        Raises:
            InputError: The trajectory is of another arm, or speed is not positive.
        """
        self._require_open()
        arm = self.arm
        check_trajectory(arm, trajectory)
        times, again = as_positive(speed, "speed"), as_flag(loop, "loop")
        self._server.driver.drop(MOVED)
        self._post("play", arm, lambda stage: stage.load(trajectory, times, again, time.monotonic()))

    def _post(self, key: str, arm: Arm, change: Callable[[Stage], None]) -> None:
        """Change what is on show, unless another arm has taken the place of `arm` meanwhile."""
        self._server.post(key, lambda stage: change(stage) if stage.arm is arm else None)

    def load(self, arm: Arm) -> tuple[str, ...]:
        """Show `arm` in place of the one on show, on the pages that are open; returns once that is so.

        Each joint stands where the joint of its name stood, layers and camera stay, and so do the poses and the motion
        as far as they fit; what was changed or left out is returned, in words. Poses left out come back with an arm
        that allows them.

        Raises InputError while a servo drives the arm, and of a view that was closed.
        """
        return tuple(self._server.exchange(Stage(arm), self._server.scene.successor(arm)))

    def watch(
        self, load: Callable[[], Arm], files: Iterable[Path], say: Callable[[str], None] = lambda _: None
    ) -> None:
        """Show what `load` returns whenever one of `files`, or of those that it read the last time, has changed.

        `twistarm.viewer.server.watching.loaded` finds the files of an arm. The pages say when it was loaded again, and
        why not where it cannot be: the last one that could stays on show. `say` gets the same text, from another
        thread.

        Args:
            load: A function that returns the arm.
            files: The files to watch at first.
            say: Called with a line of text after each change.
        """
        self._watches.append(Watch(self._server, load, files, say))

    @property
    def recorded(self) -> dict[str, Array]:
        """The poses recorded on the pages: theta (n,) [rad, m] by name, in the order of their list."""
        return self._server.ask(lambda stage: stage.program.list.named())

    @property
    def commands(self) -> Inbox:
        """What the pages command by keyboard and gamepad, as a source for a stream; once asked for, they may.

        Each page is a commander of its own, and two at once bring the arm to rest. Until `show_servo(None)`, sliders,
        poses and trajectories of the pages are refused. A drive that a page had switched on ends.
        """
        self._server.driver.drop()
        self._server.commands.open = True
        self._server.post("jogging", lambda stage: stage.take_commands())
        return self._server.commands.inbox

    def servo_settings(self, settings: ServoSettings | None = None) -> Callable[[], ServoSettings]:
        """`settings` with `beyond` as the pages choose it, for `run(…, settings=view.servo_settings())`.

        Pages may choose it from now on, beginning with that of `settings`, until `show_servo(None)`.
        """
        given = ServoSettings() if settings is None else settings
        require(given, ServoSettings, "settings", "as ServoSettings() is")
        commands = self._server.commands
        commands.beyond, commands.free = given.beyond, True
        self._server.post("beyond", lambda stage: self._server.show_choice())
        return commands.servo_settings(given)

    def show_servo(self, answer: Cycle | ServoOutput | None) -> None:
        """Show what a cycle of `stream.run` came to: where the joints are, and the servo's status and reason.

        An answer of `servo_step` gives status and reason alone; None: the servo has ended, and sliders work again.
        Called at any rate, the latest is shown, at most 60 times a second. Harmless once the view is closed: a loop
        that drives an arm does not end for that.
        """
        if answer is None and self._server.driver.on:  # no servo of the program's
            return
        self._server.driver.drop()
        if isinstance(answer, Cycle) and answer.theta is not None:
            self._stand(answer.theta)
        if answer is None:
            self._server.commands.open = self._server.commands.free = False
            self._server.post("beyond", lambda stage: self._server.show_choice())
        report = None if answer is None else servo_words(answer)
        self._server.post("servo", lambda stage: stage.set_servo_status(report))

    def show_screws(self, visible: bool = True) -> None:
        """Draw each joint's screw axis where it lies at the configuration on show, or draw none."""
        self._set_visible("screws", visible)

    def show_frames(self, visible: bool = True) -> None:
        """Draw the space and the tool frame, or do not."""
        self._set_visible("frames", visible)

    def _set_visible(self, layer: str, visible: bool) -> None:
        self._require_open()
        flag = as_flag(visible, "visible")
        self._server.post(layer, lambda stage: stage.set_visible(layer, flag))

    def show_path(self, motion: Trajectory | ArrayLike | None) -> None:
        """Draw the way of the tool's origin along a trajectory, or through configurations (k, n); None draws none."""
        self._require_open()
        path = NO_PATH if motion is None else tool_path(self.arm, motion)
        self._server.post("path", lambda stage: stage.draw_path(path))

    def show_solutions(self, solutions: IKSolutions | None) -> None:
        """Draw every configuration of `solve_ik_all` faintly, for the pages to step through; None draws none.

        The arm stands at the nearest; those outside the limits are red. They are let go once the arm is moved.
        """
        self._require_open()
        arm = self.arm
        if (
            solutions is not None
            and require(solutions, IKSolutions, "solutions", "as solve_ik_all returns").arm is not arm
        ):
            raise InputError("these are configurations of another arm: solve_ik_all(viewer.arm, …) gives this one's")
        others = self._server.ask(lambda stage: dict(stage.others))
        answer = None if solutions is None else answer_of(solutions, others)
        self._server.driver.drop(MOVED)
        self._post("show", arm, lambda stage: stage.show_solutions(answer))

    def save_html(self, path: str | os.PathLike[str], trajectory: Trajectory | None = None) -> Path:
        """Write a stand-alone page of what is on show, every joint, layer and finding, and the loaded trajectory.

        See `twistarm.viewer.save_html`.

        Args:
            path: The file to write.
            trajectory: A motion that the page plays in place of the loaded one, or None.

        Returns:
            The path written.

        Raises:
            InputError: The file cannot be written, or the trajectory is of another arm.
        """
        target = writable(path)
        return write_whole(target, stand_alone(self._exhibit(trajectory)))

    def inline(self, height: float = HEIGHT, *, static: bool = False) -> Inline:
        """The view for a notebook, `height` pixels high: as the last line of a cell it is shown there.

        The frame holds the live page, for a notebook that the browser has from localhost or 127.0.0.1; the notebook
        keeps its address, at which nothing answers once the view is closed. With `static` the frame holds what is on
        show now as a stand-alone page, which the notebook keeps: for exported notebooks and nbviewer, for a remote
        JupyterHub, and for VS Code, whose notebooks stand in frames of schemes of its own (`vscode-webview:`, shared by
        all its extensions) that the live page does not admit.

        Args:
            height: Height of the frame [pixels].
            static: Whether the frame holds a stand-alone page instead of the live one.

        Returns:
            An object that a notebook shows.

        Raises:
            InputError: An argument cannot be used.
        """
        if as_flag(static, "static"):
            return Inline.page(stand_alone(self._exhibit()), self.arm.name, height)
        return Inline.live(self.url, self.arm.name, height)

    def _repr_html_(self) -> str:
        return self.inline().html

    def _exhibit(self, trajectory: Trajectory | None = None) -> SceneSnapshot:
        shown = self._server.ask(lambda stage: on_show(stage, self._server.scene))
        return shown if trajectory is None else shown.playing(trajectory)

    def save_png(self, path: str | os.PathLike[str], *, size: tuple[int, int] = (1280, 720)) -> Path:
        """Write a picture of what is on show; see `twistarm.viewer.save_png`.

        Args:
            path: The file to write, which ends in .png.
            size: (width, height) [pixels].

        Returns:
            The path written.

        Raises:
            InputError: The size or the path cannot be used.
            TwistarmError: There is no browser, or it does not draw.
        """
        return write_picture(path, size, self._exhibit)

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
        for watch in self._watches:
            watch.close()
        self._server.stop()


def _started_browser(url: str) -> bool:
    """Whether there is a browser with a window, which opens `url` then: one in the terminal would take it over."""
    windowless = sys.platform.startswith("linux") and not any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY")))
    if windowless and not os.environ.get("BROWSER"):
        return False
    with suppress(webbrowser.Error):
        return webbrowser.open(url)
    return False
