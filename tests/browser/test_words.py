"""What the page says: two lines at most in its panel, with the rest in one fold."""

from __future__ import annotations

import json
from typing import Any

import pytest

from twistarm.viewer import Viewer
from waiting import settled

pytestmark = pytest.mark.browser

LINES = """(id) => {
  const place = document.getElementById(id);
  const { lineHeight, paddingTop, paddingBottom } = getComputedStyle(place);
  return (place.clientHeight - parseFloat(paddingTop) - parseFloat(paddingBottom)) / parseFloat(lineHeight);
}"""

LONG = "the elbow would turn beyond its limit on the way to the next pose, and then " * 6

NOTES = {"notes": [LONG, LONG, "last"], "objects": 1, "left": 0}

MET = {"given": {}, "met": True, "words": f"arm: {LONG}\n3 iterations"}

FOUND = {"asked": True, "places": [], "ghosts": [], "words": f"x\n2 found, 3 of 64 searches met it\n{LONG}"}

SAY = {
    "error": f"twistarm.panel.showError('{LONG}')",
    "notice": f"twistarm.parts.notice.show({json.dumps({'words': LONG, 'wrong': True})})",
    "notes": f"twistarm.parts.progress.learn({json.dumps(NOTES)})",
    "target-words": f"twistarm.parts.target.verdict.show({json.dumps(MET)})",
    "solutions-words": f"twistarm.parts.solutions.show({json.dumps(FOUND)})",
}


@pytest.mark.smoke
def test_messages_have_two_lines_and_one_fold(page: Any, viewer: Viewer) -> None:
    settled(page, viewer.url)
    for place, say in SAY.items():
        page.evaluate(say)
        said = page.locator(f"#{place}")
        assert page.evaluate(LINES, place) < 2.3, place
        assert "iterations" not in said.inner_text()
        assert "searches" not in said.inner_text()
        fold = said.locator("details")
        assert fold.count() == 1, place
        fold.locator("summary").press("Enter")
        assert page.evaluate(LINES, place) > 2.9, place
        if place == "target-words":
            assert "3 iterations" in said.inner_text()
    page.evaluate("twistarm.panel.showError('short')")
    assert page.locator("#error summary").evaluate("(summary) => summary.tabIndex") == -1
    assert page.locator("#error").inner_text().strip() == "short"
