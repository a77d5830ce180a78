"""Figures as SVG in a page, the drawings for paper, and what lessons may not ask for."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from twistarm import Arm, InputError, arm_from_screws, guide, joints
from twistarm.guide.teaching import output, stills, svg
from twistarm.guide.teaching.figures import COLOURS
from twistarm.guide.teaching.output import SLIDERS


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
    named = [set(re.findall(r' id="([^"]+)"', text)) for text in (one, other)]
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


def numbers(text: str) -> Any:
    return np.array(text.split(), float)


def test_a_page_finds_the_places_that_matplotlib_draws() -> None:
    """Places around the centre, turned to the direction of view, are the line. All stays in the picture."""
    fig, ax = guide.axes3(box=False, elev=30, azim=-50)
    ax.plot([0, 1, 1], [0, 0.5, -0.2], [0, 0.3, 0.8])
    element = svg.of(fig)
    eye, centre, at = (re.search(rf'data-{name}="([^"]+)"', element)[1] for name in ("eye", "centre", "at"))  # type: ignore[index]
    places = numbers(at).reshape(-1, 3)
    azim, elev = numbers(eye)
    seen = Rotation.from_euler("ZY", [azim, -elev], degrees=True).inv().apply(places)[:, 1:] * [1, -1]
    drawn = re.search(r'data-at=.*?<path d="([^"]+)"', element, re.DOTALL)[1]  # type: ignore[index]
    assert np.allclose(numbers(centre) + seen, numbers(re.sub("[ML]", "", drawn)).reshape(-1, 2), atol=0.2)
    sides = numbers(re.search(r'viewBox="0 0 ([^"]+)"', element)[1])  # type: ignore[index]
    assert 0.8 < 2 * np.linalg.norm(places, axis=1).max() / sides.min() < 1.0


def test_a_motion_is_at_its_end_on_paper() -> None:
    fig, ax = guide.axes3()
    places = np.array([[0.0, 0.0, 0.0], [0.2, 0.0, 0.1], [0.5, 0.1, 0.1]])
    guide.plot_motion(guide.plot_point, ax, places, "p")
    assert [np.ravel(line.get_data_3d()).tolist() for line in ax.lines] == [places[-1].tolist()]
    assert [len(track.split(";")) for track in re.findall(r'data-at="([^"]+)"', svg.of(fig))][-2:] == [3, 3]


@pytest.mark.parametrize(
    "name", ["two_link", *(pytest.param(k, marks=pytest.mark.slow) for k in SLIDERS if k != "two_link")]
)
def test_each_slider_has_a_drawing_for_paper(name: str) -> None:
    fig, words = stills.slider(name, SLIDERS[name])
    assert len(words) > 20
    assert svg.of(fig).startswith("<svg ")


@pytest.mark.parametrize("kind", ["revolute", "prismatic", "helical", "cylindrical", "planar", "spherical"])
def test_each_joint_is_drawn(kind: str) -> None:
    assert kind in stills.slider("joint", {"type": kind})[1]


def test_the_cubic_meets_its_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    wanted = {"start": 10.0, "end": 40.0, "duration": 2.0, "velocity_start": 5.0, "velocity_end": -3.0}
    for kind in ("cubic", "quintic"):
        fig, _ = stills.slider("spline", {"kind": kind, **wanted})
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
    with pytest.raises(InputError, match=words), output.installed(lambda shown: None):
        call()
