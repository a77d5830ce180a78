"""Calibration by simulated truth: what was put into an arm is found in its log."""

import json
from dataclasses import replace

import numpy as np
import pytest

from family_arms import family_arm
from twistarm import InputError, load_arm
from twistarm.calibration import Measurements, calibrate, corrected_urdf, read_measurements
from twistarm.calibration.geometry import Geometry
from twistarm.cli.application import run
from twistarm.limits import Actuators
from twistarm.theory import poe
from twistarm.theory.screws import adjoint, exp

NOISE = 5e-5


def moved(arm, rng, size=1.0):
    """The arm with every screw carried along by a small motion of its own (Okamura & Park), and a moved home."""
    d = rng.normal(scale=[5e-4] * 3 + [2e-3] * 3, size=(arm.screws.shape[1] + 1, 6)) * size
    screws = np.stack([adjoint(exp(motion)) @ xi for motion, xi in zip(d, arm.screws.T, strict=False)], axis=1)
    return screws, exp(d[-1]) @ arm.home


def away(rng):
    """The base in the frame of a tracker."""
    return exp(np.r_[rng.normal(size=3), rng.normal(size=3)])


@pytest.fixture(scope="module", params=["rover_arm", pytest.param("family", marks=pytest.mark.slow)])
def log(request):
    rng = np.random.default_rng(3)
    arm = load_arm("rover_arm") if request.param == "rover_arm" else family_arm("parallel 2-3-4")
    screws, home = moved(arm, rng)
    base, theta = away(rng), arm.random_theta(rng, 150)
    true = lambda x: base @ poe.fk(screws, home, x @ arm.coupling.A.T)  # noqa: E731
    positions = true(theta)[:, :3, 3] + rng.normal(scale=NOISE, size=(150, 3))
    return arm, theta, positions, true


def test_the_corrected_arm_predicts_what_was_not_measured(log):
    arm, theta, positions, true = log
    r = calibrate(arm, Measurements(theta, positions), position_noise=NOISE)
    fresh = arm.random_theta(99, 300)
    error = np.linalg.norm(r.predict(fresh) - true(fresh)[:, :3, 3], axis=1)
    assert error.max() < 5 * NOISE
    assert r.confirmed
    assert r.held_out < 2.5 * NOISE < r.held_out_before / 4
    assert not r.outliers
    assert not r.warnings
    assert np.allclose((r.base @ r.arm.fk(fresh) @ r.tool)[:, :3, 3], r.predict(fresh), atol=1e-12)


def test_parameters_come_back_within_their_deviations(log):
    arm, theta, positions, _ = log
    first = calibrate(arm, Measurements(theta, positions), position_noise=NOISE)
    geometry, rng = first.problem.geometry, np.random.default_rng(8)
    size = np.array([5e-4 if e.parameter.unit == "m" else 2e-3 for e in first.estimates])
    truth = np.where([e.seen for e in first.estimates], rng.normal(scale=size), 0.0)
    truth[:12] = 0.0
    positions = geometry.poses(truth, theta)[:, :3, 3] + rng.normal(scale=NOISE, size=theta[:, :3].shape)
    r = calibrate(arm, Measurements(theta, positions), position_noise=NOISE)
    seen = [(e.value - t) / e.std for e, t in list(zip(r.estimates, truth, strict=True))[12:] if e.seen]
    assert np.abs(seen).max() < 3.5
    assert np.sqrt(np.mean(np.square(seen))) < 1.4
    assert all(e.value == 0.0 for e in r.estimates if not e.seen)


def test_derivatives_are_those_of_finite_differences():
    arm, rng = family_arm("SCARA, slide last"), np.random.default_rng(0)
    geometry = Geometry(arm, away(rng), np.eye(4), scales=True)
    p = rng.normal(scale=1e-2, size=len(geometry.parameters))
    theta, h = arm.random_theta(1, 3), 1e-6
    g, V = geometry.twists(p, theta)
    assert np.allclose(g, geometry.poses(p, theta), atol=1e-12)
    for j, step in enumerate(h * np.eye(len(p))):
        slope = (geometry.poses(p + step, theta) - geometry.poses(p - step, theta)) / (2 * h)
        twist = slope @ np.linalg.inv(g)
        found = np.stack(
            [*np.moveaxis(twist[:, :3, 3], -1, 0), twist[:, 2, 1], twist[:, 0, 2], twist[:, 1, 0]], axis=-1
        )
        assert np.allclose(found, V[:, :, j], atol=1e-6), geometry.parameters[j]


def test_mixed_measurements_rest_touch_and_reach(log):
    arm, theta, positions, true = log
    if arm.description is None:
        pytest.skip("one arm is enough")
    anchor, K = np.array([0.1, 0.2, 0.3]), 40
    far = arm.random_theta(50, K)
    length = np.linalg.norm(true(far)[:, :3, 3] - anchor, axis=1)
    both = Measurements(
        np.vstack([theta, far]),
        np.vstack([positions, np.full((K, 3), np.nan)]),
        wire=("",) * len(theta) + ("nail",) * K,
        length=np.r_[np.full(len(theta), np.nan), length],
    )
    r = calibrate(arm, both, position_noise=NOISE)
    assert np.allclose(r.places["nail"], anchor, atol=5e-4)


def test_a_plane_beside_positions_is_found_and_more_logs_are_one(log, tmp_path):
    arm, theta, positions, true = log
    n, d = np.array([0.6, 0.0, 0.8]), 0.35
    table = arm.random_theta(60, 4000)
    table = table[np.argsort(np.abs(true(table)[:, :3, 3] @ n - d))[:60]]
    for _ in range(20):  # onto the plane, by Newton's method in the first joint that moves across it
        p = true(table)[:, :3, 3]
        slope = np.stack([(true(table + h)[:, :3, 3] - p) @ n for h in 1e-6 * np.eye(arm.n)], axis=1) / 1e-6
        table = table - slope * ((p @ n - d) / (slope**2).sum(axis=1))[:, None]
    touched, rest = Measurements(table, plane=("table",) * 60), Measurements(theta[:60], positions[:60])
    both = calibrate(arm, [rest, touched], position_noise=NOISE)
    alone = calibrate(arm, rest, position_noise=NOISE)
    fresh = arm.random_theta(61, 300)
    left = [np.linalg.norm(r.predict(fresh) - true(fresh)[:, :3, 3], axis=1).mean() for r in (both, alone)]
    assert left[0] < min(left[1], 2 * NOISE)
    assert both.problem.log.label[60] == "row 1"


def test_motors_take_the_zeros(log):
    arm, theta, positions, _ = log
    r = calibrate(arm, Measurements(theta, positions), position_noise=NOISE)
    with pytest.raises(InputError, match="no actuators"):
        r.motor_offsets()
    n = arm.n
    motors = Actuators(arm.joint_names, arm.joint_names, 2.0 * np.eye(n), np.ones(n), ("rad",) * n, np.full(n, np.nan))
    driven = calibrate(replace(arm, actuators=motors), Measurements(theta, positions), position_noise=NOISE)
    corrected = replace(motors, offset=np.array(list(driven.motor_offsets().values())))
    y = motors.to_motor(theta[:5])
    assert np.allclose(corrected.to_theta(y), theta[:5] + driven.zeros)


def test_an_outlier_and_a_base_that_moved_are_named(log):
    arm, theta, positions, _ = log
    spoilt = positions.copy()
    spoilt[7] += 0.02
    assert calibrate(arm, Measurements(theta, spoilt), position_noise=NOISE).outliers == (8,)
    spoilt[80:] += [0.003, 0.0, 0.001]
    (said,) = calibrate(arm, Measurements(theta, spoilt), position_noise=NOISE).warnings
    assert "moved near row" in said
    assert abs(int(said.split("near row ")[1].split(":")[0]) - 81) < 12


@pytest.mark.parametrize("name", ["rover_arm", "ur5"])
def test_swapped_columns_and_a_base_that_moved_far_are_faults_and_nothing_is_written(name):
    """The rover's mirror image is an arm of its own, so its fit is perfect."""
    arm = load_arm(name)
    theta = arm.random_theta(0, 80)
    p = arm.fk(theta)[:, :3, 3] + np.random.default_rng(1).normal(scale=1e-4, size=(80, 3))
    pushed = p + np.where(np.arange(80) < 40, 0.0, 0.02)[:, None]
    flipped = theta * np.where(np.arange(arm.n) == 2, -1.0, 1.0)
    for log, word in (
        (Measurements(theta, p[:, [1, 0, 2]]), ""),
        (Measurements(theta[:, [1, 0, *range(2, arm.n)]], p), ""),
        (Measurements(flipped, p), ""),
        (Measurements(theta, pushed), "row 41"),
    ):
        r = calibrate(arm, log)
        assert word in r.faults[0]
        assert not r.confirmed_here
        assert not r.confirmed
        with pytest.raises(InputError):
            corrected_urdf(r, here=True)


@pytest.mark.parametrize(("name", "j"), [("rover_arm_6dof", 4), ("panda", 5), ("scara", 1)])
def test_a_wrong_zero_is_a_zero_and_no_moved_bracket(name, j):
    arm, z = load_arm(name), np.zeros(load_arm(name).n)
    z[j] = np.radians(1.0)
    theta = arm.random_theta(j, 80)
    p = arm.fk(theta + z)[:, :3, 3] + np.random.default_rng(j).normal(scale=1e-4, size=(80, 3))
    r = calibrate(arm, Measurements(theta, p))
    assert r.zeros[j] == pytest.approx(z[j], abs=1e-3)
    axes = [e for e in r.estimates if e.seen and e.of_joint and e.parameter.what != "zero"]
    assert max(abs(e.value) for e in axes) < 5e-4


def test_one_placement_of_points_confirms_the_correction_there_only():
    arm, rng = load_arm("panda"), np.random.default_rng(3)
    screws, home = moved(arm, rng)
    true = lambda x: poe.fk(screws, home, x)  # noqa: E731
    theta = arm.random_theta(rng, 2)
    rows = {}
    for k, name in enumerate("ab"):
        spot, near = true(theta[k : k + 1])[0, :3, 3], theta[k] + 0.3 * (arm.random_theta(5, 60) - theta[k])
        for _ in range(60):  # onto the spot, by Gauss and Newton
            off = spot - true(near)[:, :3, 3]
            J = np.stack([true(near + h)[:, :3, 3] - true(near)[:, :3, 3] for h in 1e-6 * np.eye(arm.n)], axis=2) / 1e-6
            near = near + np.clip((np.linalg.pinv(J, rcond=1e-2) @ off[:, :, None])[:, :, 0], -0.1, 0.1)
        inside = (np.linalg.norm(off, axis=1) < 1e-6) & (np.abs(near) < np.pi).all(axis=1)
        rows[name] = Measurements(near[inside], point=(name,) * int(inside.sum()))
    one, two = calibrate(arm, rows["a"]), calibrate(arm, [rows["a"], rows["b"]])
    assert (one.confirmed_here, one.confirmed) == (True, False)
    assert two.confirmed
    with pytest.raises(InputError):
        corrected_urdf(one)
    assert corrected_urdf(one, here=True).startswith("<")


def test_bad_logs_are_refused_or_named(tmp_path):
    arm = load_arm("rover_arm")
    theta = arm.random_theta(0, 40)
    p = arm.fk(theta)[:, :3, 3]
    with pytest.raises(InputError, match="mm"):
        calibrate(arm, Measurements(theta, 1000 * p))
    with pytest.raises(InputError, match="degrees"):
        calibrate(arm, Measurements(np.degrees(theta), p))
    with pytest.raises(InputError, match="measure more"):
        calibrate(arm, Measurements(theta[:3], p[:3]))
    still = theta.copy()
    still[:, 2] = 0.3 + 1e-3 * np.sin(np.arange(40))
    locked = calibrate(arm, Measurements(still, arm.fk(still)[:, :3, 3]))
    assert arm.joint_names[2] in locked.faults[0]
    units = {"rad": "deg", "m": "mm"}
    joints = [f"{name} [{units[unit]}]" for name, unit in zip(arm.joint_names, arm.units, strict=True)]
    header = ",".join([*joints, "x [mm]", "y [mm]", "z [mm]"])
    scale = np.where(np.array(arm.units) == "rad", 180 / np.pi, 1000.0)
    np.savetxt(tmp_path / "log.csv", np.hstack([theta * scale, 1000 * p]), delimiter=",", header=header, comments="")
    read = read_measurements(tmp_path / "log.csv", arm)
    assert np.allclose(read.theta, theta)
    assert np.allclose(read.position, p)


def test_a_sound_arm_needs_no_correction(here, capsys):
    arm = load_arm("ur5")
    theta = arm.random_theta(0, 80)
    p = arm.fk(theta)[:, :3, 3] + np.random.default_rng(1).normal(scale=1e-4, size=(80, 3))
    r = calibrate(arm, Measurements(theta, p)).require()
    assert r.sound
    assert not r.zeros.any()
    assert np.allclose(r.arm.fk(theta), arm.fk(theta), atol=1e-12)
    head = ",".join([*arm.joint_names, "x", "y", "z"])
    np.savetxt("log.csv", np.hstack([theta, p]), delimiter=",", header=head, comments="")
    assert run(["calibrate", "ur5", "log.csv", "-o", "same.urdf"]) == 0
    assert "confirmed: the arm needs no correction" in capsys.readouterr().out
    assert np.allclose(load_arm("same.urdf", base=arm.base, tip=arm.tip_link).fk(theta), arm.fk(theta), atol=1e-12)


def test_rows_that_determine_nothing_confirm_nothing():
    arm, rng = load_arm("ur5"), np.random.default_rng(0)
    theta = arm.random_theta(0, 6)
    p = arm.fk(theta + rng.normal(scale=3e-3, size=6))[:, :3, 3] + rng.normal(scale=1e-3, size=(6, 3))
    assert not calibrate(arm, Measurements(theta, p)).confirmed


def test_the_corrected_urdf_is_the_corrected_arm(log, tmp_path):
    arm, theta, positions, _ = log
    r = calibrate(arm, Measurements(theta, positions), position_noise=NOISE)
    if arm.description is None:
        with pytest.raises(InputError, match="description"):
            corrected_urdf(r)
        return
    (tmp_path / "corrected.urdf").write_text(corrected_urdf(r), encoding="utf-8")
    again = load_arm(tmp_path / "corrected.urdf", base=arm.base, tip=arm.tip_link)
    fresh = arm.random_theta(4, 50)
    assert np.allclose(again.fk(fresh) @ arm.tool, r.arm.fk(fresh), atol=1e-9)
    (tmp_path / "axes.urdf").write_text(corrected_urdf(r, zeros=False), encoding="utf-8")
    axes = load_arm(tmp_path / "axes.urdf", base=arm.base, tip=arm.tip_link)
    assert np.abs(r.zeros).max() > 1e-4
    assert np.allclose(axes.fk(fresh + r.zeros) @ arm.tool, r.arm.fk(fresh), atol=1e-9)
    with pytest.raises(InputError):
        corrected_urdf(replace(r, held_out=1.0))


def test_the_command_writes_what_it_found(log, here, capsys):
    arm, theta, positions, _ = log
    if arm.description is None:
        pytest.skip("one arm is enough")
    head = ",".join([*arm.joint_names, "x (mm)", "y (mm)", "z (mm)"])
    for name, rows in (("a.csv", slice(0, 75)), ("b.csv", slice(75, 150))):
        table = np.hstack([theta[rows], 1000 * positions[rows]])
        table[3, 5:] += 30.0 * (name == "b.csv")
        np.savetxt(name, table, delimiter=",", header=head, comments="")
    written = ["-o", "fixed.urdf"]
    assert run(["calibrate", "rover_arm", "a.csv", "b.csv", *written, "--next", "2"]) == 0
    out = capsys.readouterr().out
    assert "rows that do not fit: b.csv:5\n" in out
    assert "to measure next" in out
    assert out.splitlines()[-2] == "confirmed"
    assert load_arm("fixed.urdf", base=arm.base, tip=arm.tip_link).n == arm.n
    assert run(["calibrate", "rover_arm", "a.csv", "-o", "zeros.toml"]) == 2
    capsys.readouterr()
    assert run(["calibrate", "rover_arm", "a.csv", "--json", "--position-noise", "1e-4"]) == 0
    assert json.loads(capsys.readouterr().out)["held_out"] < 3e-4
