"""The doctor's findings on the page: counted, read, pointed at in the view, and taken back."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from arms import DRAWN
from twistarm import Arm, diagnose, load_arm
from twistarm.viewer import Viewer
from twistarm.viewer.messages import page_words
from waiting import until

pytestmark = pytest.mark.browser

HEAVY = "<img src=x onerror='hacked=1'>" + "_of_a_very_long_name" * 8
ESCAPED = HEAVY.replace("<", "&lt;").replace(">", "&gt;")

URDF = f"""<robot name="patient">
  <link name="base_link"/>
  <link name="{ESCAPED}">
    <visual><geometry><box size="0.3 0.1 0.1"/></geometry></visual>
    <inertial><mass value="90000"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="fore"><visual><geometry><box size="0.3 0.1 0.1"/></geometry></visual></link>
  <link name="tool0"/><link name="left"/>
  <joint name="shoulder" type="revolute"><parent link="base_link"/>
    <child link="{ESCAPED}"/><origin xyz="0 0 0.3"/>
    <axis xyz="0 0 -2"/><limit lower="-90" upper="90" velocity="0" effort="0"/></joint>
  <joint name="elbow" type="revolute"><parent link="{ESCAPED}"/>
    <child link="fore"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
    <limit lower="0.1" upper="2.6" velocity="1" effort="-1"/></joint>
  <joint name="hand" type="fixed"><parent link="fore"/><child link="tool0"/><origin xyz="0.3 0 0"/></joint>
  <joint name="finger" type="prismatic"><parent link="tool0"/><child link="left"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.04" velocity="0.1" effort="1"/></joint>
</robot>"""

COPIES = """() => twistarm.highlight.copies.map(({ source, copy }) => {
  let above = source;
  while (above && above !== twistarm.highlight.node) above = above.parent;
  const shown = copy.parent.parent === twistarm.view.viewer.scene;
  return { below: above !== null, shown, matrix: copy.matrix.toArray() };
})"""


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Arm:
    path = tmp_path_factory.mktemp("arm") / "patient.urdf"
    path.write_text(URDF)
    return load_arm(path)


@pytest.fixture(scope="module")
def viewer(arm: Arm) -> Iterator[Viewer]:
    with Viewer(arm, open_browser=False) as served:
        yield served


@pytest.fixture
def live(opened: Any) -> Any:
    """The page with its list open, and nothing chosen."""
    until(opened, "document.getElementById('findings-note').textContent === ''")
    opened.evaluate("document.getElementById('findings').open = true")
    opened.keyboard.press("Escape")
    return opened


def about(page: Any, code: str) -> Any:
    return page.locator(".finding", has=page.get_by_text(code, exact=True))


def pointed_at(page: Any, path: str) -> bool:
    return bool(page.evaluate("(path) => twistarm.highlight.node === twistarm.view.node(path)", path))


def points_at_nothing(page: Any) -> bool:
    nothing = "twistarm.highlight.node === null && twistarm.highlight.group.children.length === 0"
    return bool(page.evaluate(nothing)) and page.locator(".finding[aria-pressed=true]").count() == 0


def test_findings_are_counted_and_there_in_words_and_nothing_in_them_is_markup(live: Any, arm: Arm) -> None:
    found = diagnose(arm)
    counts = Counter(one.severity for one in found)
    assert counts["warning"] > 1 < counts["info"]
    assert live.locator("#findings-count").inner_text() == f"{counts['warning']} warnings, {counts['info']} info"
    texts = live.locator(".finding").all_inner_texts()
    assert len(texts) == len(found)
    for text, one in zip(texts, found, strict=True):
        for part in (one.code, str(one.place), *map(page_words, (one.what, one.remedy))):
            assert part in text
    assert live.locator("#findings img").count() == 0
    assert live.evaluate("globalThis.hacked") is None


@pytest.mark.smoke
@pytest.mark.parametrize(
    ("code", "node"),
    [
        ("unit-doubtful", "/screws/screw:0"),
        ("axis-not-unit", "/screws/screw:0"),
        ("off-the-chain", "/arm/link:left"),  # nothing is drawn of it: an arrow alone
    ],
)
def test_a_click_points_and_another_takes_it_back(live: Any, code: str, node: str) -> None:
    about(live, code).click()
    assert pointed_at(live, node)
    assert about(live, code).get_attribute("aria-pressed") == "true"
    assert all(one["below"] and one["shown"] for one in live.evaluate(COPIES))
    assert (len(live.evaluate(COPIES)) > 0) == node.startswith("/screws/")
    assert live.evaluate("twistarm.highlight.arrow.parent === twistarm.highlight.group")
    about(live, code).click()
    assert points_at_nothing(live)


def test_a_link_stands_out_where_the_arm_has_it_and_moves_with_it(live: Any, arm: Arm, viewer: Viewer) -> None:
    about(live, "inertia-implausible").click()
    assert pointed_at(live, live.evaluate("(name) => twistarm.state.hello.links[name]", HEAVY))
    for theta in ([0.5, 0.3], [-1.0, 1.0]):
        viewer.show(theta)
        until(live, f"twistarm.state.frame.theta[0] === {theta[0]}")
        (copy,) = live.evaluate(COPIES)  # its box
        assert_allclose(np.reshape(copy["matrix"], (4, 4)).T, arm.poses(theta)[HEAVY], atol=DRAWN)
