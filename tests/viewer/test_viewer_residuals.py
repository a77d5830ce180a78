"""Needles of a calibration's residuals: they begin where the tool is predicted, and say which way it was missed."""

from pathlib import Path

import numpy as np
import pytest
import umsgpack

from catalogue import load
from twistarm import Arm, InputError, Viewer, calibrate
from twistarm.calibration import Measurements
from twistarm.cli.application import run
from twistarm.viewer.scene.drawing import RED
from twistarm.viewer.scene.residuals import draw_residuals
from viewer_page import Page, stored


def test_needles_lead_from_the_predicted_to_the_measured_place(arm: Arm, viewer: Viewer) -> None:
    theta, off = arm.random_theta(0, 60), np.array([0.0, 0.003, 0.004])
    places = arm.fk(theta)[:, :3, 3]
    tracker = np.diag([-1.0, -1.0, 1.0])  # half a turn about z, and a shift along it
    measured = places @ tracker + [0.0, 0.0, 2.0]
    measured[7] += tracker @ off
    measured += np.random.default_rng(0).normal(scale=1e-5, size=measured.shape)
    found = calibrate(arm, Measurements(theta, measured), tool="held")
    packed, words = draw_residuals(found)
    times = float(words.split()[1])
    geometry = umsgpack.unpackb(packed)["object"]["geometries"][0]["data"]["attributes"]
    corners = np.frombuffer(geometry["position"]["array"].data, "<f4").reshape(60, 4, 3)
    colours = np.frombuffer(geometry["color"]["array"].data, "<f4").reshape(60, 4, 3)
    foot, tip = corners[:, :3].mean(axis=1), corners[:, 3]
    assert np.allclose(foot, places, atol=3e-5)
    assert np.allclose(tip[7] - foot[7], times * off, atol=2e-2 * times * 0.005)
    assert np.linalg.norm(np.delete(tip - foot, 7, axis=0), axis=1).max() < 5e-5 * times
    assert np.allclose(colours[7], RED[:3])

    viewer.show_residuals(found)
    viewer.show_residuals(found)
    with Page(viewer) as page:
        page.until(lambda: words in page.latest.get("scene", {"notes": ()})["notes"])
    assert sum("residuals" in note for note in page.latest["scene"]["notes"]) == 1


def test_what_cannot_be_drawn_is_refused(arm: Arm, viewer: Viewer) -> None:
    theta = arm.random_theta(0, 60)
    p = arm.fk(theta)[:, :3, 3]
    length = np.linalg.norm(p - [0.1, 0.2, 0.3], axis=1)
    with pytest.raises(InputError, match="no residual to draw"):
        viewer.show_residuals(calibrate(arm, Measurements(theta, wire=["nail"] * 60, length=length)))


def test_the_command_shows_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    arm, shown = load("rr_planar"), []
    theta = arm.random_theta(0, 30)
    header = ",".join([*arm.joint_names, "x", "y", "z"])
    rows = np.hstack([theta, arm.fk(theta)[:, :3, 3] + np.random.default_rng(0).normal(scale=1e-3, size=(30, 3))])
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header=header, comments="")
    monkeypatch.setattr(Viewer, "open_page", lambda view: True)
    monkeypatch.setattr(Viewer, "wait", lambda view: shown.append(view.save_html(tmp_path / "page.html")))
    assert run(["calibrate", "rr_planar", str(tmp_path / "log.csv"), "--view"]) == 1
    assert "times as long" in stored(shown[0].read_text("utf-8"))["notes"][-1]
