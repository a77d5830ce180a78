"""A recorded motion as a trajectory: what was written, read back, and what the view makes of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from twistarm import load_arm, load_trajectory, plan_joint
from twistarm.cli.application import run
from viewer_page import stored

ARM = load_arm("scara")
MOTION = plan_joint(ARM, [0.2 * ARM.ready, ARM.ready], limits={"velocity": 1.0, "acceleration": 2.0}, kind="quintic")


def test_it_passes_every_line_with_its_rate_and_follows_the_motion_between(tmp_path: Path) -> None:
    read = load_trajectory(ARM, MOTION.to_csv(tmp_path / "a.csv", dt=0.05))
    t, theta, theta_dot, _ = MOTION.sample(0.05)
    assert read.joint_names == ARM.joint_names
    assert_allclose(read.duration, MOTION.duration)
    assert_allclose(read(t), theta, atol=1e-12)
    assert_allclose(read(t, 1), theta_dot, atol=1e-12)
    # A cubic with both ends and both rates is off by h⁴/384 of the fourth derivative at most.
    dense = np.linspace(0.0, MOTION.duration, 3001)
    fourth = np.abs(np.diff(MOTION(dense, 3), axis=0)).max() / (dense[1] - dense[0])
    assert np.abs(read(dense) - MOTION(dense)).max() <= 1.01 * 0.05**4 / 384 * fourth


def test_uneven_steps_and_rates_at_the_ends(tmp_path: Path) -> None:
    """theta = (t² + t)/20 at 0, 0.1, 0.4 s is a parabola, which every interval's cubic is."""
    joints = zip(ARM.joint_names, ARM.units, strict=True)
    columns = [f"{name}.{what}" for name, u in joints for what in (f"position [{u}]", f"velocity [{u}/s]")]
    rows = [[t, *[(t * t + t) / 20, (2 * t + 1) / 20] * ARM.n] for t in (0.0, 0.1, 0.4)]
    path = tmp_path / "a.csv"
    path.write_text("\n".join(",".join(map(str, line)) for line in [["time [s]", *columns], *rows]))
    for t in (0.03, 0.1, 0.25, 0.39):
        assert_allclose(load_trajectory(ARM, path)(t), (t * t + t) / 20, atol=1e-14)


def test_the_command_saves_a_page_that_plays_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    MOTION.to_csv("motion.csv")
    assert run(["view", "scara", "--play", "motion.csv", "-o", "view.html"]) == 0
    data = stored(Path("view.html").read_text())
    assert_allclose(data["samples"]["times"][-1], MOTION.duration)
    assert_allclose(data["samples"]["theta"][-1], ARM.ready, atol=1e-6)
    assert data["player"]["running"] is True
    capsys.readouterr()
    assert run(["view", "scara", "--play", "nowhere.csv", "--force", "-o", "view.html"]) == 2
    assert capsys.readouterr().err.startswith("error: cannot read nowhere.csv: no such file")
