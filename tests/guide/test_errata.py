"""The errata: what the page states of each slip is so, by numbers from elsewhere."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from twistarm.guide.building.lesson import outcome
from twistarm.guide.course import ERRATA, lesson_file


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What is computed below each title, which is told without its number."""
    made = outcome(Path(lesson_file(ERRATA)), tmp_path_factory.mktemp("scenes"))
    assert not made["failed"]
    parts = [part.split('<div class="text">')[1] for part in made["body"].split("<h2 id=")[1:]]
    titles = (title.partition(". ")[2].partition(" (")[0] for _, title in made["sections"])
    return dict(zip(titles, parts, strict=True))


def test_each_slip_shows_a_number(shown: dict[str, str]) -> None:
    assert len(shown) == 16
    said = [part.partition("</div>")[0] for part in shown.values()]
    assert all(any(letter.isdigit() for letter in words) for words in said)


def test_the_order_of_two_turns(shown: dict[str, str]) -> None:
    a, b = (Rotation.from_euler(axis, angle, degrees=True) for axis, angle in (("z", 40), ("y", 30)))
    apart = np.degrees(((a * b).inv() * (b * a)).magnitude())
    assert f"differ by {apart:.1f}°" in shown["From which frame to which, and about which axes"]


def test_rodrigues_with_a_long_axis(shown: dict[str, str]) -> None:
    W = np.array([[0, -2.0, 0], [2.0, 0, 0], [0, 0, 0]])
    careless = np.eye(3) + W / 2 + W @ W * (1 - np.sqrt(3) / 2)
    assert f"determinant {np.linalg.det(careless):.3f}, no rotation" in shown["Rodrigues' formula needs a unit axis"]


def test_mixed_signs_miss(shown: dict[str, str]) -> None:
    """By the geometry: the elbow's mirror image about the line to the target, with the second link left as it was."""
    l1, l2, r = 0.4, 0.3, np.hypot(0.35, 0.3)
    beta = np.arccos((r**2 + l1**2 - l2**2) / (2 * l1 * r))
    inner = np.arccos((l1**2 + l2**2 - r**2) / (2 * l1 * l2))
    # From the line to the target: the elbow at +β, and the forearm folded to the wrong side.
    tip = l1 * np.exp(1j * beta) + l2 * np.exp(1j * (beta + np.pi - inner))
    assert f"mixed ones {abs(tip - r):.3f} m" in shown["The signs of the two-link arm go together"]
