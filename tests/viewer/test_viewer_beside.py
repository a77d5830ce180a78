"""A second arm in the scene: its rods are where forward kinematics puts them, and follow joints of the same kind."""

from __future__ import annotations

import base64

import numpy as np
import pytest

from catalogue import load
from twistarm import InputError, Viewer
from twistarm.viewer.scene.placement import Beside
from twistarm.viewer.stage import Stage

pytest.importorskip("meshcat")


@pytest.mark.parametrize(
    ("name", "followed"),
    [
        ("ur5", [1, 2, 3, 4]),  # the rover's slide has no slide to follow it
        ("rr_planar", [1, 2]),
        ("stanford", [1, 2, 0, 3, 4, None]),
    ],
)
def test_it_follows_turning_joints_and_slides_in_order(rover, name, followed):
    arm = load(name)
    theta = rover.random_theta(3)
    x = arm.ready.copy()
    for i, its in enumerate(followed):
        x[i] = x[i] if its is None else theta[its]
    x = np.clip(x, arm.limits.lower, arm.limits.upper)
    stage = Stage(rover, theta, None, Beside(arm, rover))
    moved = {path: g for path, g in stage._placement.at(theta, {})["transforms"].items() if path.startswith("/beside/")}
    last = np.reshape(moved[f"/beside/rod:{arm.screws.shape[1] - 1}"], (4, 4)).T
    assert last @ arm.home == pytest.approx(arm.fk(x), abs=1e-9)
    drawn = b"".join(Beside(arm, rover).objects)
    assert all(path.encode() in drawn for path in moved)


def test_live_pages_alone_show_both(rover):
    with Viewer(rover, open_browser=False, beside=load("ur5")) as viewer:
        assert sum(b"/beside/" in each for each in viewer._server.scene.objects) > 6
        saved = viewer._exhibit(None).data()["objects"]
        assert saved
        assert not any(b"/beside/" in base64.b64decode(each) for each in saved)
        with pytest.raises(InputError):
            Viewer(rover, open_browser=False, beside="ur5")
