"""Figures as SVG in a page, the drawings for paper, and what lessons may not ask for."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from twistarm import Arm, InputError, arm_from_screws, guide, joints
from twistarm.guide.teaching import outlet, stills, svg
from twistarm.guide.teaching.saying import SLIDERS
from twistarm.guide.teaching.style import COLOURS


def figure(label: str) -> str:
    fig, ax = guide.axes2(xlabel="x", ylabel="y")
    ax.plot([0, 1], [0, 1], label=label)
    ax.legend()
    return svg.of(fig)


def test_colours_follow_the_page_and_names_collide_with_none() -> None:
    one, other = figure("one"), figure("other")
    assert "var(--blue," in one
    assert "var(--ink," in one
    assert not re.search(r"#000000|<style|<metadata|http://purl|<\?xml", one)
    named = [set(re.findall(r' id="([^"]+)"', each)) for each in (one, other)]
    assert named[0]
    assert not named[0] & named[1]
    for names, text in zip(named, (one, other), strict=True):
        assert set(re.findall(r'(?:href="|url\()#([^")]+)', text)) <= names
    assert one == figure("one"), "the same figure is the same text"


def test_what_is_drawn_later_has_the_style_too() -> None:
    """Legends, titles and words are made after the axes, and matplotlib asks for their style then."""
    fig, ax = guide.axes2()
    ax.plot([0, 1], [0, 1], label="a")
    legend = ax.legend()
    assert not legend.get_frame_on()
    drawn = [*legend.get_texts(), ax.set_title("title"), ax.text(0, 0, "words")]
    assert {text.get_color() for text in drawn} == {COLOURS["ink"]}
    assert "#000000" not in svg.of(fig)


def test_no_white_space_and_nothing_cut() -> None:
    """A line within a cube, and one that leaves it: without a box, the picture is as large as they are."""
    heights = []
    for length in (1.0, 1.4):
        fig, ax = guide.axes3(box=False)
        ax.plot([0.5, 0.5], [0.5, 0.5], [0, length])
        guide.fit(ax, [[0, 0, 0], [1, 1, 1]])
        heights.append(picture_height(svg.of(fig)))
    assert np.isclose(heights[1] / heights[0], 1.4, rtol=0.1)


def picture_height(element: str) -> float:
    return float(re.search(r'viewBox="0 0 [\d.]+ ([\d.]+)"', element)[1])  # type: ignore[index]


@pytest.mark.parametrize(
    "name", ["two_link", *(pytest.param(k, marks=pytest.mark.slow) for k in SLIDERS if k != "two_link")]
)
def test_each_slider_has_a_drawing_for_paper(name: str) -> None:
    fig, words = stills.SLIDERS[name](SLIDERS[name])
    assert len(words) > 20
    assert svg.of(fig).startswith("<svg ")


@pytest.mark.parametrize("kind", ["revolute", "prismatic", "helical", "cylindrical", "planar", "spherical"])
def test_each_joint_is_drawn(kind: str) -> None:
    assert kind in stills.SLIDERS["joint"]({"type": kind})[1]


def test_the_cubic_meets_its_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    wanted = {"start": 10.0, "end": 40.0, "duration": 2.0, "velocity_start": 5.0, "velocity_end": -3.0}
    for kind in ("cubic", "quintic"):
        fig, _ = stills.SLIDERS["spline"]({"kind": kind, **wanted})
        angle, velocity = (fig.axes[k].lines[0].get_ydata() for k in (0, 1))
        assert np.allclose([angle[0], angle[-1], velocity[0], velocity[-1]], [10, 40, 5, -3])


def test_an_arm_without_a_description_is_drawn_by_its_axes(rover: Arm) -> None:
    by_hand = arm_from_screws(np.hstack([joints.revolute([0, 0, 1], [0, 0, 0]), joints.revolute([0, 0, 1], [1, 0, 0])]),
                              np.eye(4) + np.eye(4, k=3) * 1.5)  # fmt: skip
    points = guide.arm_points(by_hand, [np.pi / 2, 0.0])
    assert np.allclose(points, [[0, 0, 0], [0, 0, 0], [0, 1, 0], [0, 1.5, 0]])
    assert np.allclose(guide.arm_points(rover, rover.ready)[-1], rover.fk(rover.ready)[:3, 3])


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: guide.figure(guide.axes2()[0], " "), "a figure needs alt"),
        (lambda: guide.slider("wheel", "?", "!"), "there is no slider 'wheel'; there are 'frame', "),
        (lambda: guide.slider("frame", "?", "!", delta=1), "the slider 'frame' takes .*; got 'delta'"),
        (lambda: guide.table(["a", "b"], [[1]]), "as many cells as its head, 2"),
    ],
)
def test_what_cannot_be_shown_is_refused(call: Any, words: str) -> None:
    with pytest.raises(InputError, match=words), outlet.installed(lambda shown: None):
        call()
