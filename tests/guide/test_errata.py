"""The errata: what the pages state of each slip is so, by numbers from elsewhere."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from twistarm.guide.building.errata import slips

BY_TITLE = {slip.title.partition(" (")[0]: slip for slip in slips()}


def test_each_slip_shows_a_number() -> None:
    assert len(BY_TITLE) == 16
    assert all(any(letter.isdigit() for letter in slip.shown) for slip in BY_TITLE.values())


def test_the_order_of_two_turns() -> None:
    a, b = (Rotation.from_euler(axis, angle, degrees=True) for axis, angle in (("z", 40), ("y", 30)))
    apart = np.degrees(((a * b).inv() * (b * a)).magnitude())
    assert f"differ by {apart:.1f}°" in BY_TITLE["From which frame to which, and about which axes"].shown


def test_rodrigues_with_a_long_axis() -> None:
    W = np.array([[0, -2.0, 0], [2.0, 0, 0], [0, 0, 0]])
    careless = np.eye(3) + W / 2 + W @ W * (1 - np.sqrt(3) / 2)
    shown = BY_TITLE["Rodrigues' formula needs a unit axis"].shown
    assert f"determinant {np.linalg.det(careless):.3f}, no rotation" in shown


def test_mixed_signs_miss() -> None:
    """By the geometry: the elbow's mirror image about the line to the target, with the second link left as it was."""
    shown = BY_TITLE["The signs of the two-link arm go together"].shown
    l1, l2, r = 0.4, 0.3, np.hypot(0.35, 0.3)
    beta = np.arccos((r**2 + l1**2 - l2**2) / (2 * l1 * r))
    inner = np.arccos((l1**2 + l2**2 - r**2) / (2 * l1 * l2))
    # From the line to the target: the elbow at +β, and the forearm folded to the wrong side.
    tip = l1 * np.exp(1j * beta) + l2 * np.exp(1j * (beta + np.pi - inner))
    assert f"mixed ones {abs(tip - r):.3f} m" in shown.replace("with mixed", "mixed")
