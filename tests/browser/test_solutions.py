"""All configurations of a target on the page: counted, stepped through, drawn as ghosts, and let go."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from arms import load
from twistarm import Approach, solve_ik_all
from twistarm.viewer import Viewer
from waiting import settled, until

pytestmark = pytest.mark.browser

START = np.radians([0.0, 29.64, -111.9, -97.74, 0.0]).tolist()
"""Of the rover arm's two configurations for where its tool points here, the other is outside the limits."""

GHOSTS = """twistarm.parts.solutions.arms.map(({ group, parts }) => ({
  drawn: group.children.length === parts.length && parts.length > 0,
  color: parts[0].copy.material.color.getHexString(),
}))"""


@pytest.mark.smoke
def test_all_configurations_are_stepped_through_and_drawn(page: Any) -> None:
    arm = load("rover_arm")
    flips = solve_ik_all(arm, Approach([0.8, 0.1, 0.7], direction=[1, 0, 0]))
    assert (len(flips), len(flips.outside)) == (2, 0)
    with Viewer(arm, flips[0], open_browser=False) as viewer:
        settled(page, viewer.url)
        page.get_by_role("button", name="All configurations").click()
        until(page, "twistarm.parts.solutions.at === 0")
        place = page.locator("#solution-place")
        assert place.inner_text() == "1 of 2"
        assert (
            "2 configurations inside the limits, each with wrist_roll free; all there are"
            in page.locator("#solutions-words").inner_text()
        )
        assert [ghost["drawn"] for ghost in page.evaluate(GHOSTS)] == [True], "the other one"
        page.get_by_role("button", name="Next configuration").click()
        until(page, "document.getElementById('solution-place').textContent === '2 of 2'")
        until(page, f"Math.abs(twistarm.state.frame.theta[2] - {flips[1][2]}) < 1e-9")
        assert_allclose(viewer.theta, flips[1], atol=1e-9)
        page.keyboard.press("n")
        until(page, "document.getElementById('solution-place').textContent === '1 of 2'")
        page.get_by_label("Ghosts").set_checked(False)
        assert page.evaluate(GHOSTS) == []
        page.get_by_role("button", name="Done").click()
        until(page, "document.getElementById('solutions').hidden")

        # One beyond the limits: said and drawn in red, and the arm stays.
        viewer.show(START)
        until(page, f"twistarm.state.frame.theta[1] === {START[1]}")
        page.get_by_label("Ghosts").evaluate("(box) => box.checked = true")
        page.locator("#pane").click(position={"x": 20, "y": 500})
        page.keyboard.press("n")
        until(page, "twistarm.parts.solutions.at === 0")
        page.keyboard.press("p")
        until(page, "twistarm.parts.solutions.at === 1")
        assert page.locator("#solution-words").inner_text().startswith("outside the limits: ")
        (ghost,) = page.evaluate(GHOSTS)
        warn = page.evaluate("getComputedStyle(document.documentElement).getPropertyValue('--warn').trim()")
        assert f"#{ghost['color']}" == warn
        assert np.abs(viewer.theta - START).max() < 1e-6
        viewer.show(arm.ready)
        until(page, "document.getElementById('solutions').hidden")
