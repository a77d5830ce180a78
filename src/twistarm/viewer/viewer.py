"""The live view: an arm in the browser, drawn by Meshcat, moved from Python and the page."""

from __future__ import annotations

import os
import sys
import threading
import time
import webbrowser
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import partial
from pathlib import Path

from numpy.typing import ArrayLike

from ..arm.arm import Arm, require_arm
from ..collision import Scene, require_scene
from ..control.servo import ServoOutput, ServoSettings
from ..control.stream import Cycle, Inbox
from ..design import ReachMap
from ..ik import AllSolutions
from ..planning.trajectory import Trajectory
from ..support.checks import Array, as_flag, as_number, as_positive, require, require_callback
from ..support.errors import InputError, quote
from ..support.files import writable, write_whole
from ..support.interrupts import Closeable
from .messages import LARGEST_VALUE, Message, as_name
from .parts.arm_data import NO_PATH, check_trajectory, checked_theta, tool_path
from .parts.custom import Control, Draw, V
from .parts.reach import drawing
from .parts.target import choices_of
from .saved_page import HEIGHT, Inline, SceneSnapshot, on_show, stand_alone
from .scene.arm_drawing import Drawing
from .scene.drawing import require_meshcat
from .screenshot import write_picture
from .server.driver import servo_words
from .server.watching import Watch
from .stage import Stage

MOVED = "the program moves the arm: Drive was switched off"


class Viewer(Closeable):
    """A view of `arm` at `theta` (by default `arm.ready`), served to the browser until `close`.

    host: the interface. Any other host opens the view to a network. The token is still required.

    port: 0 takes a free one.

    open_browser: show the page at once. Without a browser, open `url` yourself.

    scene: obstacles and collision checks. The pages change this scene, so `solve_ik` and `plan` see their obstacles.
    Without one, the pages make a scene when the layer Collision is first switched on.

    beside: another arm to compare. Each page draws it as a ghost or side by side and moves it by its own sliders. Its
    joints can follow those of `arm` with the same name. `load` removes it.

    The view is a context manager. Every method may be called from any thread. Methods that move or show something
    return at once. `theta` and `recorded` wait at most a frame. `save_html`, `save_png` and `inline(static=True)` wait
    for the file and the meshes, `close` for the end.

    Raises InputError for a wrong theta, a port in use or a closed view, MissingExtraError without Meshcat.
    """

    def __init__(
        self,
        arm: Arm,
        theta: ArrayLike | None = None,
        *,
        host: str = "127.0.0.1",
        port: int = 0,
        open_browser: bool = True,
        scene: Scene | None = None,
        beside: Arm | None = None,
    ) -> None:
        require_meshcat()
        from .server.handlers import application
        from .server.server import Server

        require_arm(arm)
        if scene is not None:
            require_scene(scene, arm)
        if not isinstance(host, str):
            raise InputError(f"host must be the name or address of an interface; got {quote(host)}")
        self._host = host
        self._watches: list[Watch] = []
        self._closed = threading.Event()
        other = None if beside is None else require_arm(beside)
        stage = Stage(arm, theta, scene, other)
        self._server = Server(stage, Drawing(arm, beside=other), host, port, application)
        self.draw = Draw(self._put_drawing)
        self._server.start()
        if open_browser:
            self.open_page()

    @property
    def url(self) -> str:
        """The page's address with its secret token, new at each start. With it, anyone can move the view."""
        # Not every browser opens the address that means all interfaces.
        name = {"": "127.0.0.1", "0.0.0.0": "127.0.0.1", "::": "::1"}.get(self._host, self._host)
        authority = f"{f'[{name}]' if ':' in name else name}:{self._server.port}"
        return f"http://{authority}/{self._server.token}/"

    def open_page(self) -> bool:
        """Open the page in this user's browser. Returns whether a graphical browser exists.

        The browser starts with `url` as an argument. Other users of a shared computer can read arguments. Paste `url`
        there.
        """
        return _started_browser(self.url)

    @property
    def arm(self) -> Arm:
        """The arm on show."""
        return self._server.stage.arm

    @property
    def scene(self) -> Scene | None:
        """The scene on show, with the obstacles of the pages. None before there is one."""
        return self._server.ask(lambda stage: stage.collisions.scene)

    @property
    def theta(self) -> Array:
        """The configuration (n,) on show [rad, m], set by Python, a page or a playing trajectory."""
        return self._server.ask(lambda stage: stage.theta.copy())

    def show(self, theta: ArrayLike) -> None:
        """Stand at theta (n,) [rad, m]. Called faster than the pages can draw, the latest wins."""
        self._require_open()
        self._move_to(theta)

    def _move_to(self, theta: ArrayLike) -> None:
        arm = self.arm
        checked = checked_theta(arm, theta).copy()
        self._server.driver.drop(MOVED)
        self._post("show", arm, lambda stage: stage.show(checked))

    def _require_open(self) -> None:
        if self._closed.is_set():
            raise InputError("the viewer is closed: open another by Viewer(arm)")

    def play(self, trajectory: Trajectory, speed: float = 1.0, loop: bool = False) -> None:
        """Play a trajectory from its start. Returns at once.

        Args:
            trajectory: A motion of the arm on show. Another arm's raises InputError.
            speed: Playback speed, above 0, 1 as planned.
            loop: Whether it plays again and again.
        """
        self._require_open()
        arm = self.arm
        check_trajectory(arm, trajectory)
        times, again = as_positive(speed, "speed"), as_flag(loop, "loop")
        self._server.driver.drop(MOVED)
        self._post("play", arm, lambda stage: stage.load(trajectory, times, again).play(time.monotonic()))

    def _post(self, key: str, arm: Arm, change: Callable[[Stage], None]) -> None:
        """Change what is on show, unless another arm has replaced `arm`."""
        self._server.post(key, lambda stage: change(stage) if stage.arm is arm else None)

    def load(self, arm: Arm) -> tuple[str, ...]:
        """Show `arm` in place of the present one on all open pages, then return.

        Joints keep their values by name. Layers, camera, poses and the motion stay if they fit. Returns the changes and
        omissions in words. Raises InputError while a servo drives the arm, or if the view is closed.
        """
        return tuple(self._server.exchange(arm))

    def watch(
        self, load: Callable[[], Arm], files: Iterable[Path], say: Callable[[str], None] = lambda _: None
    ) -> None:
        """Show what `load` returns whenever one of `files`, or a file that it read, changes.

        `twistarm.viewer.server.watching.load_with_files` finds the files of an arm. The pages show each load, or why it
        failed while the last good arm stays.

        Args:
            load: A function that returns the arm.
            files: The files to watch at first.
            say: Called with the same line of text after each change, from another thread.
        """
        self._watches.append(Watch(self._server, load, files, say))

    @property
    def recorded(self) -> dict[str, Array]:
        """The poses recorded on the pages: theta (n,) [rad, m] by name, in list order."""
        return self._server.ask(lambda stage: stage.poses.named())

    @property
    def commands(self) -> Inbox:
        """Keyboard and gamepad commands of the pages, as a source for a stream.

        Each page is a separate sender, and two at once bring the arm to rest. Until `show_servo(None)`, sliders, poses
        and trajectories of the pages are refused. A page's drive ends.
        """
        self._server.driver.drop()
        self._server.commands.open = True
        self._server.post("jogging", lambda stage: stage.take_commands())
        return self._server.commands.inbox

    def servo_settings(self, settings: ServoSettings | None = None) -> Callable[[], ServoSettings]:
        """`settings` with `on_unreachable` as the pages choose it, for `StreamOptions(settings=view.servo_settings())`.

        Pages may choose it from now on, beginning with that of `settings`, until `show_servo(None)`.
        """
        initial = ServoSettings() if settings is None else settings
        require(initial, ServoSettings, "settings", "as ServoSettings() is")
        commands = self._server.commands
        commands.on_unreachable, commands.free = initial.on_unreachable, True
        self._server.post("on_unreachable", lambda stage: self._server.show_choice())
        return commands.servo_settings(initial)

    def show_servo(self, answer: Cycle | ServoOutput | None) -> None:
        """Show a cycle of `stream.run`: joint values, status and reason.

        An output of `servo_step` shows only status and reason. None ends the servo and enables the sliders. Call it at
        any rate. The view shows the latest, at most 60 times a second. After the view is closed it does nothing, so a
        control loop can continue.
        """
        if answer is None and self._server.driver.on:  # no servo of the program's
            return
        self._server.driver.drop()
        if isinstance(answer, Cycle) and answer.theta is not None:
            self._move_to(answer.theta)
        if answer is None:
            self._server.commands.open = self._server.commands.free = False
            self._server.post("on_unreachable", lambda stage: self._server.show_choice())
        report = None if answer is None else servo_words(answer)
        self._server.post("servo", lambda stage: stage.set_servo_status(report))

    def show_screws(self, visible: bool = True) -> None:
        """Draw each joint's screw axis at the present configuration, or none."""
        self._set_visible("screws", visible)

    def show_frames(self, visible: bool = True) -> None:
        """Draw the space and the tool frame, or do not."""
        self._set_visible("frames", visible)

    def _set_visible(self, layer: str, visible: bool) -> None:
        self._require_open()
        flag = as_flag(visible, "visible")
        self._server.post(layer, lambda stage: stage.set_visible(layer, flag))

    def show_path(self, motion: Trajectory | ArrayLike | None) -> None:
        """Draw the path of the tool's origin along a trajectory or through configurations (k, n). None draws none."""
        self._require_open()
        path = NO_PATH if motion is None else tool_path(self.arm, motion)
        self._server.post("path", lambda stage: stage.draw_path(path))

    def show_reach(self, m: ReachMap | None) -> None:
        """Draw a map of `reach_map`: its surface, and a slice through the tool. None hides it.

        Colours are the share of directions reached. Raises InputError for a map of another arm.
        """
        self._require_open()
        arm = self.arm
        message = None if m is None else drawing(require(m, ReachMap, "m", "as reach_map returns").require(arm))
        self._post("reach", arm, lambda stage: stage.show_reach(message))

    def show_solutions(self, solutions: AllSolutions | None) -> None:
        """Draw each configuration of `solve_ik_all` faintly, for stepping through on the pages.

        None draws none. The arm goes to the nearest. Those outside the limits are red. Moving the arm releases them.
        """
        self._require_open()
        arm = self.arm
        if solutions is not None and require(solutions, AllSolutions, "solutions", "of solve_ik_all").arm is not arm:
            raise InputError("these are configurations of another arm: solve_ik_all(viewer.arm, …) gives this one's")
        choices = None if solutions is None else choices_of(solutions)
        self._server.driver.drop(MOVED)
        self._post("show", arm, lambda stage: stage.show_solutions(choices))

    def slider(
        self,
        name: str,
        lo: float,
        hi: float,
        on_change: Callable[[float], object] | None = None,
        value: float | None = None,
    ) -> Control[float]:
        """Show a slider on the pages, in place of a control of the same name.

        Returns the control. Python can read and set its `value`. Callbacks run one after the other in a thread, and
        may call every method of the view. If one is slow, the next call skips values. An error in one is shown as one
        line on the pages and in the terminal. Controls stay when another arm is loaded. Saved pages leave them out.

        Args:
            name: What the pages call it.
            lo: The lower end.
            hi: The upper end.
            on_change: Called with the value after a page has moved the slider, or None.
            value: The first value, by default `lo`.
        """
        lower, upper = as_number(lo, "lo"), as_number(hi, "hi")
        if not -LARGEST_VALUE <= lower < upper <= LARGEST_VALUE:
            raise InputError(
                f"lo must be below hi, each at most {LARGEST_VALUE:g} in size; got {lower:g} and {upper:g}"
            )

        call = require_callback(on_change, "on_change", "the value")
        inside = partial(as_number, name=f"value of {quote(name)}", least=lower, most=upper)
        return self._control(name, lower if value is None else value, inside, call, (lower, upper))

    def button(self, name: str, on_click: Callable[[], object]) -> Control[None]:
        """Show a button on the pages, as `slider` does.

        Args:
            name: What the button says.
            on_click: Called without arguments for each press.
        """
        return self._control(name, None, lambda value: None, require_callback(on_click, "on_click", "nothing"))

    def text(self, name: str, value: str) -> Control[str]:
        """Show a line of text on the pages, as `slider` does.

        Args:
            name: What stands before the text.
            value: The text. Setting the control's `value` changes it.
        """
        return self._control(name, value, lambda text: as_name(text, "value"))

    def _control(
        self,
        name: str,
        value: V,
        check: Callable[[V], V],
        call: Callable[..., object] | None = None,
        ends: tuple[float, float] | None = None,
    ) -> Control[V]:
        self._require_open()
        return Control(as_name(name, "name"), value, check, self._server.post, call, ends)

    def _put_drawing(self, message: Message) -> None:
        self._require_open()
        self._server.post(message["node"], lambda stage: stage.drawings.update({message["node"]: message}))

    def save_html(self, path: str | os.PathLike[str], trajectory: Trajectory | None = None) -> Path:
        """Write a saved page of the present state: joints, layers, findings and the loaded trajectory.

        Args:
            path: The file to write, as in `twistarm.viewer.save_html`.
            trajectory: A motion that the page plays in place of the loaded one, or None.
        """
        target = writable(path)
        return write_whole(target, stand_alone(self._exhibit(trajectory)))

    def inline(self, height: float = HEIGHT, *, static: bool = False) -> Inline:
        """The view for a notebook, `height` pixels high, shown on a cell's last line.

        The frame holds the live page, for notebooks on localhost or 127.0.0.1. The notebook keeps its address, which is
        dead after the view closes. With `static` the frame holds a saved page. Use it for exported notebooks, nbviewer,
        a remote JupyterHub, and VS Code. VS Code frames notebooks in `vscode-webview:`, shared by all its extensions.
        The live page refuses it.

        Args:
            height: Height of the frame [pixels].
            static: Whether the frame holds a stand-alone page instead of the live one.
        """
        if as_flag(static, "static"):
            return Inline.page(stand_alone(self._exhibit()), self.arm.name, height)
        return Inline.live(self.url, self.arm.name, height)

    def _repr_html_(self) -> str:
        return self.inline().html

    def _exhibit(self, trajectory: Trajectory | None = None) -> SceneSnapshot:
        snapshot = self._server.ask(lambda stage: on_show(stage, self._server.drawing))
        return snapshot if trajectory is None else snapshot.playing(trajectory)

    def save_png(self, path: str | os.PathLike[str], *, size: tuple[int, int] = (1280, 720)) -> Path:
        """Write a picture of what is on show.

        Args:
            path: The file to write, as in `twistarm.viewer.save_png`.
            size: (width, height) [pixels].
        """
        return write_picture(path, size, self._exhibit)

    def wait(self) -> None:
        """Serve until Ctrl-C or a call of `close`. Ctrl-C closes the view and returns."""
        try:
            while not self._closed.wait(0.5):
                pass
        except KeyboardInterrupt:
            self.close()

    def close(self) -> None:
        """Stop serving. Nothing is left running. Harmless when repeated."""
        self._closed.set()
        for watch in self._watches:
            watch.close()
        self._server.stop()


def _started_browser(url: str) -> bool:
    """Whether a graphical browser opened `url`. A terminal browser would take over the terminal."""
    windowless = sys.platform.startswith("linux") and not any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY")))
    if windowless and not os.environ.get("BROWSER"):
        return False
    with suppress(webbrowser.Error):
        return webbrowser.open(url)
    return False
