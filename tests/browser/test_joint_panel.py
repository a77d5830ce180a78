"""The panel's joints by mouse and keyboard: numbers typed and stepped, units, limits, buttons, a servo in between."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from arms import assert_drawn
from needed import absent
from twistarm import load_arm
from twistarm.viewer import Viewer
from waiting import settled, until

pytestmark = pytest.mark.browser

ARM = load_arm("rover_arm")  # slide ±0.5 m, shoulder ±1.57, elbow ±2.36, wrist_pitch ±1.75, wrist_roll without limits

START = [0.1, 0.2, -0.3, 0.4, 0.5]

Opened = Callable[[], AbstractContextManager[Any]]

AXE = Path(__file__).parents[2] / "tools/page/node_modules/axe-core/axe.min.js"


@pytest.fixture(scope="module")
def viewer() -> Iterator[Viewer]:
    with Viewer(ARM, START, open_browser=False) as served:
        yield served


@pytest.fixture(scope="module")
def opened(open_page: Opened, viewer: Viewer) -> Iterator[Any]:
    """One page for all: opening one takes a second."""
    with open_page() as page:
        page.context.grant_permissions(["clipboard-read", "clipboard-write"])
        page.set_viewport_size({"width": 740, "height": 720})
        yield settled(page, viewer.url)


@pytest.fixture
def page(opened: Any, viewer: Viewer) -> Any:
    """The page with the arm at START and nothing under way."""
    if opened.url != viewer.url:
        settled(opened, viewer.url)
    opened.keyboard.press("Escape")
    opened.evaluate("document.activeElement.blur(), twistarm.panel.showError('')")
    viewer.show(START)
    stands(opened, START)
    return opened


def box(page: Any, joint: str, unit: str = "degrees") -> Any:
    return page.get_by_role("spinbutton", name=f"{joint}, {unit}", exact=True)


def type_into(page: Any, joint: str, text: str, unit: str = "degrees") -> None:
    """As a hand does it: click, which does not clear the box, select all of it, type."""
    box(page, joint, unit).click()
    page.keyboard.press("ControlOrMeta+a")
    page.keyboard.type(text)


def stands(page: Any, theta: Any) -> None:
    """Wait until the page shows theta, and every request is answered."""
    numbers = [float(value) for value in theta]
    until(page, f"twistarm.state.frame.theta.every((value, i) => Math.abs(value - {numbers}[i]) < 1e-12)")
    until(page, "twistarm.link.underway === 0 && twistarm.link.pending.size === 0 && twistarm.panel.held === null")


def at(**values: float) -> list[float]:
    return [values.get(name, value) for name, value in zip(ARM.joint_names, START, strict=True)]


def sent(page: Any) -> int:
    """How many requests the page has sent."""
    count: int = page.evaluate("twistarm.link.number")
    return count


def said(page: Any) -> str:
    text: str = page.locator("#error").inner_text()
    return text


@pytest.mark.smoke
def test_a_typed_number_moves_the_arm_by_enter_and_by_leaving_the_box(page: Any, viewer: Viewer) -> None:
    type_into(page, "shoulder", "30")
    page.keyboard.press("Enter")
    stands(page, at(shoulder=np.pi / 6))
    assert_drawn(page, ARM, at(shoulder=np.pi / 6))
    assert box(page, "shoulder").input_value() == "30.0"
    page.keyboard.type("-12.5")  # what was sent is selected: the next number replaces it
    page.keyboard.press("Tab")
    stands(page, at(shoulder=np.deg2rad(-12.5)))
    assert page.evaluate("document.activeElement.dataset.joint") == "elbow"  # its slider comes next
    type_into(page, "slide", "-0.25", "metres")
    page.locator("#pane").click()
    stands(page, at(slide=-0.25, shoulder=np.deg2rad(-12.5)))
    assert_allclose(viewer.theta, at(slide=-0.25, shoulder=np.deg2rad(-12.5)), atol=1e-15)
    type_into(page, "finger_left", "0.02", "metres")
    page.keyboard.press("Enter")
    until(page, "twistarm.state.frame.others.finger_left === 0.02")


def test_looking_into_a_box_sends_nothing_and_escape_restores(page: Any) -> None:
    before = sent(page)
    box(page, "shoulder").click()
    page.keyboard.press("Tab")
    type_into(page, "shoulder", "77")
    page.keyboard.press("Escape")
    assert box(page, "shoulder").input_value() == "11.5"  # 0.2 rad
    page.keyboard.press("Enter")
    page.keyboard.press("Tab")
    assert sent(page) == before


@pytest.mark.parametrize("text", ["12x", "", "1 m"])
def test_nonsense_is_marked_and_nothing_is_sent(page: Any, text: str) -> None:
    before = sent(page)
    type_into(page, "shoulder", text)
    if text == "":
        page.keyboard.press("Delete")
    assert box(page, "shoulder").get_attribute("aria-invalid") == "true"
    page.keyboard.press("Enter")
    assert said(page).startswith("shoulder: ")
    page.keyboard.press("Tab")
    assert box(page, "shoulder").input_value() == text
    assert sent(page) == before
    box(page, "shoulder").press("Escape")
    assert box(page, "shoulder").input_value() == "11.5"
    assert box(page, "shoulder").get_attribute("aria-invalid") is None
    assert page.locator("#error").is_hidden()


def test_a_box_under_a_hand_is_not_overwritten_and_the_others_are(page: Any, viewer: Viewer) -> None:
    type_into(page, "shoulder", "4")
    viewer.show(at(shoulder=0.6, elbow=0.7))
    stands(page, at(shoulder=0.6, elbow=0.7))
    assert box(page, "shoulder").input_value() == "4"
    assert box(page, "elbow").input_value() == "40.1"  # 0.7 rad
    page.evaluate("document.activeElement.dispatchEvent(new FocusEvent('blur'))")  # as where the window loses the focus
    page.keyboard.type("2")
    page.keyboard.press("Enter")
    stands(page, at(shoulder=np.deg2rad(42), elbow=0.7))


def test_arrow_keys_step_and_end_at_the_limit(page: Any) -> None:
    box(page, "shoulder").focus()
    page.keyboard.press("ArrowUp")
    stands(page, at(shoulder=0.2 + np.deg2rad(1)))
    page.keyboard.press("Shift+ArrowDown")
    stands(page, at(shoulder=0.2 - np.deg2rad(9)))
    for _ in range(12):
        page.keyboard.press("PageUp")
    stands(page, at(shoulder=1.57))
    assert said(page) == ""
    box(page, "slide", "metres").press("ArrowDown")
    stands(page, at(slide=0.099, shoulder=1.57))


def test_radians_everywhere_and_after_a_reload(page: Any, viewer: Viewer) -> None:
    page.get_by_text("View", exact=True).click()
    page.get_by_label("Radians", exact=True).check()
    assert box(page, "shoulder", "radians").input_value() == "0.200"
    type_into(page, "shoulder", "-0.75", "radians")
    page.keyboard.press("Enter")
    stands(page, at(shoulder=-0.75))
    settled(page, viewer.url)
    assert box(page, "shoulder", "radians").input_value() == "−0.750"
    page.get_by_text("View", exact=True).click()
    page.get_by_label("Radians", exact=True).uncheck()
    assert box(page, "shoulder").input_value() == "−43.0"  # -0.75 rad


def test_limits_are_marked_and_the_page_is_accessible(page: Any, viewer: Viewer) -> None:
    # Within 5 % of 1.57 - -1.57 of the upper; 0.14 beyond the lower; more than 5 % of 3.5 from both, which is not near.
    viewer.show(at(shoulder=1.57 - 0.15, elbow=-2.5, wrist_pitch=1.75 - 0.18))
    until(page, "document.querySelector('[data-limit=outside]')")
    rows = {name: page.get_by_role("group", name=name) for name in ARM.joint_names}
    states = {name: row.get_attribute("data-limit") for name, row in rows.items()}
    assert states == {"slide": "", "shoulder": "near", "elbow": "outside", "wrist_pitch": "", "wrist_roll": ""}
    if not AXE.is_file():
        absent("axe-core is not installed: make lint-page")
    page.evaluate(AXE.read_text("utf-8"))
    page.evaluate("document.getElementById('findings').open = true")
    for scheme in ("dark", "light"):
        page.emulate_media(color_scheme=scheme)
        found = page.evaluate("axe.run({ iframes: false, preload: false })")
        assert [(each["id"], each["nodes"][0]["html"][:120]) for each in found["violations"]] == [], scheme


# {quantity: {expression: value [rad, m], null where it has none}}; tests/cli has the same for the command line.
CASES = json.loads((Path(__file__).parents[1] / "data/expressions.json").read_text(encoding="utf-8"))

TYPED = """async ([texts, unit, ...bare]) => {
  const { typed } = await import(new URL("units.js", location.href));
  return texts.map((text) => typed(text, unit, ...bare));
}"""


def test_numbers_are_typed_as_expressions_with_units(page: Any) -> None:
    for quantity, how in {"degrees": ["rad"], "radians": ["rad", 1], "metres": ["m"]}.items():
        found = page.evaluate(TYPED, [list(CASES[quantity]), *how])
        expected = [value and pytest.approx(value, rel=1e-12) for value in CASES[quantity].values()]
        assert dict(zip(CASES[quantity], found, strict=True)) == dict(zip(CASES[quantity], expected, strict=True))


def test_under_a_servo_the_arm_s_boxes_are_shut(page: Any, viewer: Viewer) -> None:
    type_into(page, "shoulder", "33")
    inbox = viewer.commands
    until(page, "twistarm.jog.accepts && document.querySelector('.joint .number').disabled")
    for control in (box(page, "shoulder"), page.get_by_role("button", name="random")):
        assert control.is_disabled()
    assert box(page, "shoulder").input_value() == "11.5"
    box(page, "finger_left", "metres").click()
    page.keyboard.press("ControlOrMeta+a")
    page.keyboard.type("w0.03d")
    page.keyboard.press("ArrowUp")
    assert page.evaluate("twistarm.jog.timer") is None
    page.keyboard.press("ControlOrMeta+a")
    page.keyboard.type("0.03")
    page.keyboard.press("Enter")
    until(page, "twistarm.state.frame.others.finger_left === 0.03")
    assert inbox.read(0.0).command is None
    viewer.show_servo(None)
    until(page, "!document.querySelector('.joint .number').disabled")
    assert viewer.theta.tolist() == START
