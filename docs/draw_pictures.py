"""Draws the pictures of README and docs: `make pictures`. Needs Chromium, Chrome or Edge."""

from __future__ import annotations

import io
import re
import runpy
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, PngImagePlugin
from playwright.sync_api import Page, sync_playwright

from twistarm import Approach, Arm, FreeMove, LineMove, Scene, Trajectory, Viewer, load_arm, plan, reach_map, save_png
from twistarm.viewer.screenshot import find_browser

DOCS = Path(__file__).parent
PICTURES = DOCS / "pictures"
FLAGS = ("--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
FRAMES, SIZE = 40, (648, 480)

CONTROLS_KEY = "Controls"
CONTROLS = """() => [...document.querySelectorAll("button, summary, input, select, textarea")].filter(
  (each) => each.tagName !== "SUMMARY" || !/\\d/.test(each.textContent)
).map((each) => [
  each.id || each.getAttribute("aria-label") || each.title || (each.labels?.[0] ?? each).textContent.trim(),
  each.checkVisibility({ visibilityProperty: true }),
])"""
"""Names of all controls of the page, and whether each is seen. A fold that tells numbers is no control."""


def layers() -> str:
    """The layers of the package as SVG, from the table that the architecture test checks."""
    table = runpy.run_path(str(DOCS.parent / "tests" / "whole" / "test_architecture.py"))
    floors = [[name for name in floor if name != "_core"] for floor in table["FLOORS"]]
    floors = [floor for floor in floors if floor]
    width, height, gap = 640, 34, 8
    drawn = []
    for row, floor in enumerate(floors):
        box = (width - gap * (len(floor) - 1)) / len(floor)
        y = row * (height + gap)
        for column, name in enumerate(floor):
            x = column * (box + gap)
            drawn.append(
                f'<rect x="{x:.0f}" y="{y}" width="{box:.0f}" height="{height}" rx="6" fill="#dbe9f6" stroke="#369"/>'
                f'<text x="{x + box / 2:.0f}" y="{y + 22}" text-anchor="middle">{name}</text>'
            )
    bottom = len(floors) * (height + gap) - gap
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="-2 -2 {width + 4} {bottom + 4}" width="{width}" '
        f'font-family="sans-serif" font-size="14" fill="#12283c">{"".join(drawn)}</svg>\n'
    )


def gallery() -> None:
    """The arms that come with twistarm."""
    for name in ("rover_arm", "rover_arm_6dof", "scara", "stanford"):
        save_png(load_arm(name), PICTURES / f"{name}.png", size=(720, 480))


def task(arm: Arm) -> Trajectory:
    """Down and to the side along lines, and back."""
    moves = [[0.0, 0.3, 0.0], [0.0, 0.0, -0.35], [0.0, -0.6, 0.0], [0.0, 0.0, 0.35], [0.0, 0.3, 0.0]]
    return plan(arm, [LineMove.by(move, frame="base") for move in moves])


def animation(page: Page, viewer: Viewer, motion: Trajectory) -> None:
    """The arm on its way with the tool's trace and its ellipsoid, as an animated WebP."""
    page.locator("#theory-layers").get_by_text("Trace", exact=True).check()
    page.locator("#theory-layers").get_by_text("Linear ellipsoid").check()
    frames = []
    for t in np.linspace(0.0, motion.duration, FRAMES):
        viewer.show(motion(t))
        page.wait_for_timeout(1500)
        picture = page.screenshot(clip={"x": 320, "y": 60, "width": 1080, "height": 800})
        frames.append(Image.open(io.BytesIO(picture)).convert("RGB").resize(SIZE))
    duration = int(1000 * motion.duration / FRAMES)
    frames[0].save(DOCS / "motion.webp", save_all=True, append_images=frames[1:], duration=duration, loop=0, quality=60)


def controls(page: Page, seen: bool = False) -> set[str]:
    """Names of the page's controls, or of those that are seen; # stands for a number."""
    named = ((re.sub(r"\d+", "#", name), shown) for name, shown in page.evaluate(CONTROLS))
    return {name for name, shown in named if name and (shown or not seen)}


def controls_in(path: Path) -> set[str]:
    """Names of the controls that a picture of the page shows."""
    with Image.open(path) as picture:
        return set(picture.info[CONTROLS_KEY].split("\n"))


def screenshot(page: Page, path: Path) -> None:
    """The page in 256 colours, which halves the file, with the names of the controls that it shows."""
    told = PngImagePlugin.PngInfo()
    told.add_itxt(CONTROLS_KEY, "\n".join(sorted(controls(page, seen=True))))
    picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    picture.quantize(256, dither=Image.Dither.NONE).save(path, optimize=True, pnginfo=told)


def recorded(page: Page, viewer: Viewer, motion: Trajectory) -> None:
    """Three poses recorded and a motion planned through them, on the page."""
    page.click("#tab-program")
    for share in (0.0, 0.25, 0.75):
        viewer.show(motion(share * motion.duration))
        page.wait_for_timeout(2000)
        page.click("#record")
        page.wait_for_timeout(1000)
    page.click("#plan")
    page.wait_for_timeout(5000)
    page.check("#drag-tool")


def live_page(arm: Arm, motion: Trajectory, browser: Any) -> None:
    """The page, with its panels Theory and Poses, and the animation."""
    with Viewer(arm, open_browser=False) as viewer:
        page = browser.new_page(viewport={"width": 1400, "height": 860}, color_scheme="light")
        page.goto(viewer.url)
        page.wait_for_timeout(5000)
        page.click("#tab-theory")
        animation(page, viewer, motion)
        page.locator("#theory-layers").get_by_text("Columns of J").first.check()
        page.wait_for_timeout(3000)
        screenshot(page, PICTURES / "theory.png")
        page.locator("#theory-layers").get_by_text("Trace", exact=True).uncheck()
        recorded(page, viewer, motion)
        page.wait_for_timeout(5000)
        screenshot(page, DOCS / "view.png")
        page.close()


def collisions(arm: Arm, browser: Any) -> None:
    """A free move round a table with the layer Collision, and the hand in the table."""
    scene = Scene(arm)
    scene.add_box("table", (0.4, 1.0, 0.04), (0.8, 0.0, 0.35))
    below = FreeMove(Approach([0.75, 0.2, 0.2], [1.0, 0.0, 0.0]))
    motion = plan(arm, below, scene=scene)
    with Viewer(arm, scene=scene, open_browser=False) as viewer:
        page = browser.new_page(viewport={"width": 1000, "height": 560}, color_scheme="light")
        page.goto(viewer.url)
        page.wait_for_timeout(5000)
        page.click("#tab-scene")
        page.get_by_label("Collision", exact=True).check()
        for layer in ("Screws", "Frames"):
            page.get_by_label(layer, exact=True).uncheck()
        viewer.show_path(motion)
        nearest = scene.clearance(motion)
        hit = plan(arm, LineMove.by([0.0, 0.0, -0.27], frame="base"))
        for name, theta in (("free_move", motion(nearest.time)), ("in_the_table", hit(hit.duration))):
            viewer.show(theta)
            page.wait_for_timeout(6000)
            screenshot(page, PICTURES / f"{name}.png")
        page.close()


def reach(arm: Arm) -> None:
    """Slices through a map, and the map on the page."""
    m = reach_map(arm, 0.05, 26)
    m.to_png(PICTURES / "reach.png")
    with Viewer(arm, open_browser=False) as viewer:
        viewer.show_reach(m)
        viewer.save_png(PICTURES / "reach_view.png", size=(720, 480))


def main() -> None:
    """Draw all pictures."""
    PICTURES.mkdir(exist_ok=True)
    (PICTURES / "layers.svg").write_text(layers(), "utf-8")
    arm = load_arm("rover_arm", limits={"acceleration": 2.0})
    motion = task(arm)
    save_png(arm, PICTURES / "motion.png", trajectory=motion, size=(720, 480))
    gallery()
    reach(load_arm("rover_arm_6dof"))
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=find_browser(), args=list(FLAGS))
        live_page(arm, motion, browser)
        collisions(arm, browser)
        browser.close()


if __name__ == "__main__":
    main()
