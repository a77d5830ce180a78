"""The site in a real browser, opened from disk: no error, no request elsewhere, nothing that axe-core finds, figures
that turn, and sliders whose numbers are right.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from scipy.spatial.transform import Rotation

from chromium import launched
from needed import absent
from small_course import LESSON, ROVER
from twistarm import InputError, load_arm, save_site
from twistarm.guide.building.building import Built, build
from twistarm.guide.building.pages import SCRIPTS, site_file
from twistarm.guide.teaching import output
from twistarm.guide.teaching.output import SLIDERS, slider

pytestmark = [pytest.mark.slow, pytest.mark.browser]

AXE = Path(__file__).parents[2] / "tools" / "page" / "node_modules" / "axe-core" / "axe.min.js"


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with launched() as browser:
        yield browser


@pytest.fixture(scope="module")
def course(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """The whole of it, on the rover arm."""
    made = build(tmp_path_factory.mktemp("whole"), ROVER)
    assert made.failed == ()
    return made


@pytest.fixture(scope="module")
def arms(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The index of a site of two arms."""
    return save_site([load_arm("rr_planar"), load_arm("scara")], tmp_path_factory.mktemp("arms") / "site")


def watched(page: Any) -> list[str]:
    """What goes wrong in a page, and what it asks for that is no file beside it."""
    seen: list[str] = []
    page.on("pageerror", lambda error: seen.append(str(error)))
    page.on("console", lambda message: seen.append(message.text) if message.type == "error" else None)
    local = ("file:", "data:", "blob:")
    page.on("request", lambda request: None if request.url.startswith(local) else seen.append(request.url))
    return seen


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 390])
def test_every_page_reads_without_a_fault(course: Built, arms: Path, browser: Any, scheme: str, width: int) -> None:
    if not AXE.is_file():
        absent("axe-core is not installed: make lint-page")
    context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme, bypass_csp=True)
    for file in [*sorted(course.folder.glob("*.html")), arms]:
        page = context.new_page()
        seen = watched(page)
        page.route("**/scene_*", lambda route: route.fulfill(body="<title>a scene</title>"))  # a test of its own
        page.goto(file.as_uri())
        page.evaluate("document.querySelectorAll('details').forEach((each) => { each.open = true; })")
        page.evaluate(AXE.read_text("utf-8"))
        found = page.evaluate("axe.run({ iframes: false, preload: false })")
        faults = [(fault["id"], fault["nodes"][0]["html"][:120]) for fault in found["violations"]]
        assert faults == [], file.name
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), f"{file.name} is wider than {width}"
        assert page.evaluate(
            "[...document.querySelectorAll('figure > .picture svg')].every((svg) => svg.getBBox().width > 0)"
        )
        assert seen == [], file.name
        page.close()
    context.close()


@pytest.fixture
def opened(browser: Any) -> Iterator[Callable[..., Any]]:
    """A function that opens a file as a page. No page may have an error or ask elsewhere."""
    pages = []

    def open_page(file: Path, **options: Any) -> Any:
        page = browser.new_page(**options)
        pages.append((page, watched(page)))
        page.goto(file.as_uri())
        return page

    yield open_page
    for page, seen in pages:
        assert seen == []
        page.close()


def test_the_scene_is_drawn_from_disk(built: Built, opened: Any) -> None:
    page = opened(built.folder / f"{LESSON}.html")
    frame, inside = page.locator("iframe"), page.frame_locator("iframe")
    assert frame.get_attribute("src") is None, "it waits for its reader"
    frame.scroll_into_view_if_needed()
    inside.locator("body[data-drawn]").wait_for(timeout=60_000)
    assert inside.get_by_role("slider").first.is_visible()
    assert not inside.get_by_role("heading", name="rover_arm").is_visible(), "folded"
    inside.get_by_label("Panel", exact=True).check()
    assert inside.get_by_role("heading", name="rover_arm").is_visible()


def test_a_scene_shows_its_quantity_before_anybody_moves_it(opened: Any, tmp_path: Path) -> None:
    arm, theta = load_arm("elbow"), [0.4, -0.7, 1.3, 0.5, 0.8, -0.3]
    (tmp_path / "scenes").mkdir()
    condition = f"{arm.manipulability(theta).condition:.4g}"
    for quantity, value in {"configurations": "1 of 8", "ellipsoid": condition}.items():
        shown: list[output.Shown] = []
        with output.installed(shown.append):
            output.scene(arm, theta, quantity=quantity)
        script = f"<script>{site_file('scripts/frames.js').decode()}</script>"
        (tmp_path / "scene.html").write_text(
            f"<meta charset=utf-8>{shown[0].html(tmp_path / 'scenes')}{script}", "utf-8"
        )
        opened(tmp_path / "scene.html").frame_locator("iframe").get_by_text(value, exact=True).wait_for(timeout=60_000)
    with pytest.raises(InputError, match="speed"):
        output.scene(arm, quantity="speed")


def test_the_site_of_arms_leads_to_a_page_of_each(arms: Path, opened: Any) -> None:
    page = opened(arms)
    assert page.evaluate("[...document.images].every((each) => each.complete && each.naturalWidth > 0)")
    page.get_by_role("link", name="scara").click()
    page.locator("body[data-drawn]").wait_for(timeout=60_000)
    assert page.get_by_role("heading", name="scara").is_visible()


BOXES = """(figure) => [...figure.querySelectorAll("path")].map((path) => {
  const { x, y, width, height } = path.getBBox();
  return [x, y, width, height];
})"""


def test_a_figure_is_turned_zoomed_and_left_alone(built: Built, opened: Any) -> None:
    page = opened(built.folder / f"{LESSON}.html")
    figure = page.locator("figure > .turns").first
    figure.scroll_into_view_if_needed()
    looks, first = [figure.inner_html()], figure.evaluate(BOXES)

    def changes(act: Callable[[], object]) -> bool:
        act()
        looks.append(figure.inner_html())
        return looks[-1] != looks[-2]

    def drag() -> None:
        figure.hover()
        page.mouse.down()
        page.mouse.move(500, 300)
        page.mouse.up()

    def wheel() -> None:
        figure.hover()
        page.mouse.wheel(0, 90)
        page.wait_for_timeout(200)

    assert changes(drag)
    assert changes(lambda: page.keyboard.press("ArrowLeft"))
    assert not changes(wheel), "the page scrolls"
    page.keyboard.down("Control")
    assert changes(wheel)
    page.keyboard.up("Control")
    assert changes(lambda: page.keyboard.press("0"))
    assert np.allclose(figure.evaluate(BOXES), first, atol=0.2), "as it was drawn"
    assert page.locator("figure > .turns").count() == page.locator("figure > .picture:has([data-eye])").count()


@pytest.mark.parametrize("motion", ["no-preference", "reduce"])
def test_a_slider_plays_and_stops_where_the_reader_takes_it(motion: Any, bench: Any) -> None:
    page = bench("twist")
    page.emulate_media(reduced_motion=motion)
    page.get_by_role("button", name="Play").click()
    turn = page.get_by_label("θ", exact=False).first
    page.wait_for_timeout(1200)
    page.get_by_role("button", name="Pause").click()
    stopped = float(turn.input_value())
    assert stopped > 90
    page.wait_for_timeout(200)
    assert float(turn.input_value()) == stopped


def test_without_scripts_questions_answers_and_drawings_are_there(built: Built, opened: Any) -> None:
    page = opened(built.folder / f"{LESSON}.html", java_script_enabled=False)
    assert page.locator(".slider .picture svg").first.is_visible()
    assert page.locator(".scene .still svg").first.is_visible()
    assert not page.locator("iframe").is_visible()
    page.locator(".prediction summary").first.click()
    assert page.locator(".prediction details div").first.is_visible()


@pytest.fixture
def bench(opened: Any, tmp_path: Path) -> Callable[..., Any]:
    """A function that opens a slider and gives its page."""

    def open_slider(name: str, **numbers: Any) -> Any:
        shown: list[output.Shown] = []
        with output.installed(shown.append):
            slider(name, "?", "!", **numbers)
        scripts = "".join(f"<script>{site_file(name).decode()}</script>" for name in SCRIPTS)
        file = tmp_path / "slider.html"
        file.write_text(f"<meta charset=utf-8>{shown[0].html(None)}{scripts}", "utf-8")
        return opened(file)

    return open_slider


def numbers(page: Any) -> list[float]:
    text = page.locator("pre.numbers").inner_text().replace("−", "-")
    return [float(word) for word in re.findall(r"-?\d+\.?\d*", text.translate({ord(x): " " for x in "₁₂"}))]


def slide(page: Any, label: str, value: float) -> None:
    control = page.get_by_label(label, exact=False).first
    control.evaluate("(input, value) => { input.value = value; input.dispatchEvent(new Event('input')); }", value)


@pytest.mark.parametrize("name", SLIDERS)
def test_each_slider_starts_and_keys_move_it(name: str, bench: Any) -> None:
    page = bench(name)
    assert page.locator(".bench svg > *").count() > 2
    first = page.locator(".bench input").first
    before = page.locator(".bench svg").inner_html()
    first.focus()
    for _ in range(4):
        page.keyboard.press("ArrowRight")
    assert page.locator(".bench svg").inner_html() != before or name == "spline", "keys move it"


def euler(order: str) -> Any:
    return Rotation.from_euler(order, [50, 40, -20], degrees=True).as_matrix().ravel()


AXIS = np.ones(3) / np.sqrt(3)
TWIST = np.array([[0, -1, 0, 0.2], [1, 0, 0, -0.5], [0, 0, 0, 0.1], [0, 0, 0, 0]])
J = np.array([[-0.3, -0.3], [0.4, 0.0]])

NUMBERS: list[tuple[str, dict[str, Any], int, Any, float]] = [
    *(("frame", {"order": k, "alpha": 50, "beta": 40, "gamma": -20}, 0, euler(k), 6e-4) for k in ("ZYZ", "ZYX", "XYZ")),
    (
        "axis_angle",
        {"axis": (1, 1, 1), "angle": 120},
        0,
        [*AXIS, *Rotation.from_rotvec(np.radians(120) * AXIS).as_matrix().ravel()],
        2e-2,  # its sliders have steps
    ),
    (
        "twist",
        {"axis": (0, 0, 1), "point": (0.5, 0.2, 0), "pitch": 0.1, "angle": 90},
        0,
        [0.2, -0.5, 0.1, 0, 0, 1, *scipy.linalg.expm(TWIST * np.pi / 2).ravel()],
        6e-4,
    ),
    (
        "ellipsoid",
        {"l1": 0.4, "l2": 0.3, "theta1": 0, "theta2": 90},
        0,
        [*J.ravel(), *np.linalg.svd(J, compute_uv=False), np.linalg.det(J)],
        6e-4,
    ),
    # From rest to rest: 3/2 and 15/8 of the mean velocity, 6 and 10/√3 of h/T² (Lynch & Park, §9.2.2).
    ("spline", {"kind": "cubic", "start": 0, "end": 90, "duration": 2}, 2, [1.5 * 45, 6 * 22.5], 0.1),
    ("spline", {"kind": "quintic", "start": 0, "end": 90, "duration": 2}, 2, [1.875 * 45, 5.7735 * 22.5], 0.1),
]
"""Sliders, where they begin, and the numbers that they then show from a certain one on."""


@pytest.mark.parametrize(("name", "start", "first", "expected", "tol"), NUMBERS)
def test_the_numbers_of_a_slider(
    name: str, start: dict[str, Any], first: int, expected: Any, tol: float, bench: Any
) -> None:
    assert np.allclose(numbers(bench(name, **start))[first : first + len(expected)], expected, atol=tol)


def test_the_two_link_arm_and_its_other_solution(bench: Any) -> None:
    page = bench("two_link", l1=0.4, l2=0.3, theta1=30, theta2=60)

    def tip(first: float, second: float) -> Any:
        a, b = np.radians([first, first + second])
        return np.array([0.4 * np.cos(a) + 0.3 * np.cos(b), 0.4 * np.sin(a) + 0.3 * np.sin(b)])

    x, y, r, _, _, first, second = numbers(page)[:7]
    assert np.allclose([x, y], tip(30, 60), atol=6e-4)
    assert np.isclose(r, np.hypot(x, y), atol=2e-3)
    assert np.isclose(second, -60, atol=0.1)
    assert np.allclose(tip(first, second), [x, y], atol=3e-3)


@pytest.mark.parametrize("name", ["two_link", "ellipsoid"])
def test_the_elbow_and_the_tool_are_dragged(name: str, bench: Any) -> None:
    page = bench(name, l1=0.4, l2=0.3, theta1=0, theta2=90)

    def angles() -> list[float]:
        return [float(page.locator("input[type=range]").nth(k).input_value()) for k in range(2)]

    def drag(handle: str, x: float, y: float) -> None:
        """To a point of the drawing [m]."""
        page.locator(f"[data-handle={handle}]").hover()
        page.mouse.down()
        scale = 115 / 0.7
        page.mouse.move(*page.evaluate(
            "([x, y]) => { const at = new DOMPoint(x, y).matrixTransform(document.querySelector('.bench svg')"
            ".getScreenCTM()); return [at.x, at.y]; }", [scale * x, -scale * y]))  # fmt: skip
        page.mouse.up()

    drag("elbow", 0.0, 0.2)
    assert angles() == [90, 90]
    drag("tool", 0.4, 0.3)
    assert np.allclose(angles(), [0, 90], atol=0.6), "the elbow stays on its side"
    drag("tool", -2.0, 0.0)
    assert np.allclose(np.abs(angles()), [180, 0], atol=0.6), "out of reach it stretches"


@pytest.mark.parametrize(("kind", "freedoms"), [("revolute", 1), ("helical", 1), ("cylindrical", 2), ("planar", 3)])
def test_a_joint_takes_away_what_it_does_not_leave(kind: str, freedoms: int, bench: Any) -> None:
    page = bench("joint")
    page.locator("select").select_option(kind)
    assert numbers(page)[:2] == [freedoms, 6 - freedoms]
