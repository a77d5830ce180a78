"""Keys and gamepad of the page as commands: the right twist again and again, and one stop whatever ends it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from twistarm import ArmBuilder
from twistarm.control.servo import ServoOutput, ServoReason
from twistarm.viewer import Viewer
from waiting import settled, until

pytestmark = pytest.mark.browser

ARM = ArmBuilder("turner").revolute("a", [0, 0, 1], [0, 0, 0.1], lower=-2, upper=2).tool(np.eye(4)).build()

LINEAR, ANGULAR = 0.1, 0.4  # The page's first speed [m/s, rad/s]: 40 % of 0.25 m/s and 1 rad/s.

KEYS = {
    "w": (0, 1), "s": (0, -1), "a": (1, 1), "d": (1, -1), "r": (2, 1), "f": (2, -1),
    "q": (3, 1), "e": (3, -1), "ArrowUp": (4, -1), "ArrowDown": (4, 1), "ArrowLeft": (5, 1), "ArrowRight": (5, -1),
}  # fmt: skip
"""The component of (v, w) and its sign, as the page's legend has them."""

PAD = """(state) => {
  const buttons = Array.from({ length: 17 }, (_, i) => {
    const value = state.buttons?.[i] ?? 0;
    return { value, pressed: value > 0.5 };
  });
  const pad = { connected: true, mapping: state.mapping ?? "standard", axes: state.axes ?? [0, 0, 0, 0], buttons };
  navigator.getGamepads = () => [null, pad];
}"""
"""A gamepad that does not exist, in the words of the W3C's Gamepad interface."""

HIDE = """(hidden) => {
  Object.defineProperty(document, "hidden", { value: hidden, configurable: true });
  document.dispatchEvent(new Event("visibilitychange"));
}"""

BESIDE = """() => {
  const slider = document.querySelector(".joint input").cloneNode();
  Object.assign(slider, { id: "beside", disabled: false });
  document.getElementById("joints").append(slider);
}"""
"""The slider of a joint beside the arm, which works while a servo drives."""

AS_OPENED = """() => {
  delete navigator.getGamepads;
  document.activeElement?.blur();
  delete document.hidden;
  document.getElementById("jog").open = false;
  twistarm.panel.showError("");
  document.getElementById("beside")?.remove();
  Object.assign(twistarm.jog, { frame: "base", step: 3 });
  Object.assign(twistarm.jog.line, { slowed: NaN, staled: NaN });
}"""
"""What tests leave behind on the page, undone."""

LB, RB, LT, RT, LEFT, RIGHT = 4, 5, 6, 7, 14, 15

DEFLECTIONS: list[tuple[dict[str, Any], list[float]]] = [
    ({"axes": [-1, 0, 0, 0]}, [0, 1, 0, 0, 0, 0]),
    ({"axes": [0, 0, -1, 0]}, [0, 0, 0, 0, 0, 1]),
    ({"axes": [0, 0, 0, 1]}, [0, 0, 0, 0, 1, 0]),
    ({"axes": [0.05, 0.56, -0.11, 0.1]}, [-0.5, 0, 0, 0, 0, 0]),  # half of what lies beyond the dead band of 0.12
    ({"buttons": {RT: 1}}, [0, 0, 1, 0, 0, 0]),
    ({"buttons": {LT: 0.56}}, [0, 0, -0.5, 0, 0, 0]),
    ({"buttons": {LEFT: 1}}, [0, 0, 0, 1, 0, 0]),
    ({"buttons": {RIGHT: 1}}, [0, 0, 0, -1, 0, 0]),
]
"""Sticks, triggers and cross, and the share of the speeds that they mean."""

INTERRUPTIONS = {
    "the window loses the focus": (
        "window.dispatchEvent(new Event('blur'))",
        "window.dispatchEvent(new Event('focus'))",
    ),
    "the tab is hidden": (f"({HIDE})(true)", f"({HIDE})(false)"),
    "a slider gets the focus": ("document.getElementById('beside').focus()", "document.activeElement.blur()"),
    "a menu opens": ("window.dispatchEvent(new Event('contextmenu'))", "null"),
    "the page goes": ("window.dispatchEvent(new Event('pagehide'))", "null"),
    "a shortcut": ("window.dispatchEvent(new KeyboardEvent('keydown', { key: 'a', ctrlKey: true }))", "null"),
}
"""What hides from the page that a key goes up, and what ends it."""


class Heard:
    """What pages command, as it arrives: (time [s], kind, fields)."""

    def __init__(self, viewer: Viewer) -> None:
        self.messages: list[tuple[float, str, dict[str, Any]]] = []
        self._viewer = viewer
        _ = viewer.commands
        self._take = viewer._server.commands.take
        viewer._server.commands.take = self._record  # type: ignore[method-assign]

    def _record(self, request: Any, sender: str) -> None:
        self.messages.append((time.monotonic(), request.kind, dict(request.fields)))
        self._take(request, sender)

    def close(self) -> None:
        """Hear no more."""
        del self._viewer._server.commands.take

    @property
    def kinds(self) -> list[str]:
        return [kind for _, kind, _ in self.messages]

    def await_kind(self, kind: str) -> None:
        end = time.monotonic() + 10
        while kind not in self.kinds:
            assert time.monotonic() < end, f"no {kind} arrived"
            time.sleep(0.01)

    def quiet(self) -> None:
        """Nothing more comes."""
        count = len(self.messages)
        time.sleep(0.15)  # almost four periods
        assert len(self.messages) == count

    def jog(self) -> dict[str, Any]:
        """The next jog."""
        self.messages.clear()
        self.await_kind("jog")
        return next(fields for _, kind, fields in self.messages if kind == "jog")


@pytest.fixture(scope="module")
def viewer() -> Iterator[Viewer]:
    with Viewer(ARM, open_browser=False) as served:
        yield served


@pytest.fixture
def page(opened: Any) -> Any:
    return opened


@pytest.fixture
def heard(page: Any, viewer: Viewer) -> Iterator[Heard]:
    """What a page commands that is as it was when it opened."""
    heard = Heard(viewer)
    until(page, "!document.getElementById('jog').hidden")
    until(page, "twistarm.jog.ready")
    yield heard
    for key in KEYS:
        page.keyboard.up(key)
    page.evaluate(AS_OPENED)
    until(page, "twistarm.jog.timer === null && twistarm.link.underway === 0 && !twistarm.jog.gamepad.armed")
    heard.close()


def line(page: Any) -> str:
    text: str = page.locator("#jog-line").inner_text()
    return text


def let_go(page: Any) -> None:
    """Nothing of the gamepad is held, and the page has seen it."""
    page.evaluate(PAD, {})
    until(page, "twistarm.jog.timer === null && twistarm.jog.gamepad.armed")


def test_without_a_servo_a_page_takes_no_key_until_commands_are_taken(
    open_page: Callable[[], AbstractContextManager[Any]],
) -> None:
    with Viewer(ARM, open_browser=False) as viewer, open_page() as page:
        settled(page, viewer.url)
        page.evaluate("() => { const { link } = twistarm; link.sent = []; link.transmit = (r) => link.sent.push(r); }")
        for key in ("w", "t", "+"):
            page.keyboard.press(key)
        page.evaluate(PAD, {"axes": [0, -1, 0, 0], "buttons": {LB: 1}})
        time.sleep(0.1)
        assert page.locator("#jog").is_hidden()
        assert page.evaluate("twistarm.link.sent") == []
        page.evaluate("() => { delete twistarm.link.transmit; delete navigator.getGamepads; }")
        heard = Heard(viewer)
        until(page, "!document.getElementById('jog').hidden")
        assert line(page) == "Jog on · base axes · 0.100 m/s, 23°/s"
        page.keyboard.press("w")
        heard.await_kind("stop")
        viewer.close()
        until(page, "document.getElementById('jog').hidden")


@pytest.mark.smoke
def test_a_held_key_says_its_twist_again_and_again_and_stops_once(page: Any, heard: Heard) -> None:
    page.keyboard.down("w")
    time.sleep(0.6)
    page.keyboard.up("w")
    heard.await_kind("stop")
    heard.quiet()
    *jogs, last = heard.messages
    assert [kind for _, kind, _ in jogs] == ["jog"] * len(jogs)
    assert last[1] == "stop"
    assert all(fields == {"twist": [LINEAR, 0, 0, 0, 0, 0], "frame": "base"} for _, _, fields in jogs)
    gaps = np.diff([at for at, _, _ in jogs])
    assert 0.03 < np.median(gaps) < 0.05  # 20 to 30 Hz


def test_every_key_moves_its_axis(page: Any, heard: Heard) -> None:
    for key, (axis, sign) in KEYS.items():
        page.keyboard.down(key)
        twist = heard.jog()["twist"]
        page.keyboard.up(key)
        expected = np.zeros(6)
        expected[axis] = sign * (LINEAR if axis < 3 else ANGULAR)
        assert_allclose(twist, expected, atol=1e-15, err_msg=key)
        heard.await_kind("stop")


def test_keys_add_up_and_no_diagonal_is_faster(page: Any, heard: Heard) -> None:
    for key in ("w", "a", "ArrowLeft"):
        page.keyboard.down(key)
    time.sleep(0.1)
    twist = heard.jog()["twist"]
    assert_allclose(twist, [LINEAR / np.sqrt(2), LINEAR / np.sqrt(2), 0, 0, 0, ANGULAR], atol=1e-15)
    page.keyboard.up("a")
    page.keyboard.down("s")  # against w
    time.sleep(0.1)
    assert_allclose(heard.jog()["twist"], [0, 0, 0, 0, 0, ANGULAR], atol=1e-15)
    for key in ("ArrowLeft", "w", "s"):
        page.keyboard.up(key)
    heard.await_kind("stop")


def test_axes_and_speed_are_chosen_by_keys_and_written_out(page: Any, heard: Heard) -> None:
    assert line(page) == "Jog on · base axes · 0.100 m/s, 23°/s"
    page.keyboard.press("t")
    for _ in range(5):
        page.keyboard.press("+")
    until(page, "document.getElementById('jog-line').textContent === 'Jog on · tool axes · 0.250 m/s, 57°/s'")
    page.keyboard.down("w")
    assert heard.jog() == {"twist": [0.25, 0, 0, 0, 0, 0], "frame": "tool"}
    for _ in range(9):
        page.keyboard.press("-")
    time.sleep(0.1)
    assert_allclose(heard.jog()["twist"], [0.0125, 0, 0, 0, 0, 0], atol=1e-15)
    page.keyboard.up("w")


def test_whatever_hides_the_key_s_release_stops_and_only_a_new_press_moves(page: Any, heard: Heard) -> None:
    page.evaluate(BESIDE)
    for why, (event, end) in INTERRUPTIONS.items():
        heard.messages.clear()
        page.keyboard.down("w")
        heard.await_kind("jog")
        page.evaluate(event)
        heard.await_kind("stop")
        page.keyboard.down("w")  # held all the time: repeats
        page.evaluate(end)
        page.keyboard.down("w")
        heard.quiet()
        assert heard.kinds.count("stop") == 1, why
        assert heard.kinds[-1] == "stop", why
        page.keyboard.up("w")


def test_a_lost_socket_is_a_stop_even_with_a_key_held(page: Any, heard: Heard) -> None:
    page.keyboard.down("w")
    heard.await_kind("jog")
    page.evaluate("twistarm.link.socket.close()")
    until(page, "document.getElementById('jog').hidden")
    until(page, "!document.getElementById('jog').hidden")  # connected again
    heard.messages.clear()
    page.keyboard.down("w")
    heard.quiet()
    assert heard.messages == []
    page.keyboard.up("w")
    page.keyboard.down("w")
    heard.await_kind("jog")


def test_a_stop_waits_for_no_other_request_and_nothing_replaces_it(page: Any, heard: Heard) -> None:
    page.keyboard.down("w")
    heard.await_kind("jog")
    page.evaluate("() => { twistarm.link.underway = 10 ** 9; }")  # a request that is never answered
    time.sleep(0.1)
    assert page.evaluate("twistarm.link.pending.size") == 1  # the latest jog waits
    page.keyboard.up("w")
    heard.await_kind("stop")
    assert page.evaluate("twistarm.link.pending.size") == 0
    page.evaluate("() => { twistarm.link.underway = 0; twistarm.link.flush(); }")
    heard.quiet()
    assert heard.kinds[-1] == "stop"


def test_a_gamepad_moves_while_a_shoulder_button_is_held(page: Any, heard: Heard) -> None:
    page.evaluate(PAD, {"axes": [0, -1, 0, 0]})
    until(page, "document.getElementById('jog-line').textContent.endsWith('gamepad: hold LB or RB')")
    heard.quiet()
    assert heard.messages == []
    page.evaluate(PAD, {"axes": [0, -1, 0, 0], "buttons": {RB: 1}})
    assert_allclose(heard.jog()["twist"], [LINEAR, 0, 0, 0, 0, 0], atol=1e-15)
    page.evaluate(PAD, {"axes": [0, -1, 0, 0]})
    heard.await_kind("stop")
    heard.quiet()


def test_sticks_triggers_and_cross(page: Any, heard: Heard) -> None:
    for state, share in DEFLECTIONS:
        let_go(page)
        page.evaluate(PAD, {**state, "buttons": {**state.get("buttons", {}), LB: 1}})
        assert_allclose(heard.jog()["twist"], np.array(share) * np.repeat([LINEAR, ANGULAR], 3), atol=1e-12)


def test_a_shoulder_button_held_since_before_must_be_let_go_first(page: Any, heard: Heard) -> None:
    held = {"axes": [0, -1, 0, 0], "buttons": {LB: 1}}
    page.evaluate(PAD, held)
    time.sleep(0.1)
    assert heard.messages == []
    let_go(page)
    page.evaluate(PAD, held)
    heard.await_kind("jog")
    page.evaluate("() => window.dispatchEvent(new Event('blur'))")
    heard.await_kind("stop")
    page.evaluate("() => window.dispatchEvent(new Event('focus'))")
    heard.quiet()


def test_a_servo_that_others_command_is_seen_and_takes_no_key(page: Any, viewer: Viewer, heard: Heard) -> None:
    reason = "slowed by the velocity limit of a"
    answer = replace(ServoOutput.stale(np.zeros(1), reason), reason=ServoReason.VELOCITY_LIMIT, scale=1.0, joint="a")
    viewer.show_servo(None)
    until(page, "document.getElementById('jog').hidden")
    viewer.show_servo(answer)  # of a servo that others command
    until(page, "!document.getElementById('jog').hidden")
    assert page.locator("#jog").inner_text().replace("\n", "") == f"Servo{reason}"
    heard.messages.clear()
    page.keyboard.press("w")
    heard.quiet()
    assert heard.messages == []
