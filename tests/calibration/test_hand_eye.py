"""Hand-eye calibration: rvec and tvec of a simulated camera, whose corners are projected by algebra of this file."""

import json

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from twistarm import InputError, load_arm
from twistarm.calibration import Measurements, calibrate
from twistarm.calibration.camera import Camera
from twistarm.cli.application import run
from twistarm.theory.screws import exp

SIDE, NOISE = 0.08, 0.5 / 600
CORNERS = np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]) * SIDE / 2


def project(rvec, tvec):
    x = CORNERS @ Rotation.from_rotvec(rvec).as_matrix().T + tvec
    return x[:, :2] / x[:, 2:]


def solve_pnp(corners, start):
    """The pose (6,) of least reprojection error, as SOLVEPNP_ITERATIVE."""
    return least_squares(lambda q: (project(q[:3], q[3:]) - corners).ravel(), start).x


def simulated(mount, K=24, zeros=0.0, name="ur5", noise=NOISE, seed=0):
    """Arm, theta, rvec, tvec and the true pose of the camera in the tip or the base."""
    arm, rng = load_arm(name), np.random.default_rng(seed)
    carried = exp(np.r_[0.02, -0.03, 0.05, 0.2, -0.1, 0.3])
    ready = arm.random_theta(3, 1)[0]
    view = np.diag([1.0, -1.0, -1.0, 1.0])  # a tag that faces the camera
    view[:3, :3] = Rotation.from_rotvec([0.3, 0.2, 0.0]).as_matrix() @ view[:3, :3]
    view[:3, 3] = [0.0, 0.0, 0.45]
    theta = ready + rng.uniform(-0.5, 0.5, (4000, arm.n))
    g, at = arm.fk(theta + zeros), arm.fk(ready) @ carried
    beside = at @ view if mount == "tool" else at @ np.linalg.inv(view)
    T = np.linalg.inv(g @ carried) @ beside if mount == "tool" else np.linalg.inv(beside) @ g @ carried
    centred = np.linalg.norm(T[:, :2, 3], axis=1) < 0.3 * T[:, 2, 3]
    facing = -(T[:, :3, 2] * T[:, :3, 3]).sum(axis=1) > 0.5 * np.linalg.norm(T[:, :3, 3], axis=1)
    rows = np.flatnonzero(centred & facing & (T[:, 2, 3] > 0.2) & (T[:, 2, 3] < 0.8))[:K]
    assert len(rows) == K
    exact = np.column_stack([Rotation.from_matrix(T[rows, :3, :3]).as_rotvec(), T[rows, :3, 3]])
    seen = [solve_pnp(project(q[:3], q[3:]) + rng.normal(scale=noise, size=(4, 2)), q) for q in exact]
    rvec, tvec = np.split(np.array(seen), 2, axis=1)
    return arm, theta[rows], rvec, tvec, carried if mount == "tool" else beside


def off(found, true):
    """[mm, °]"""
    turn = Rotation.from_matrix(true[:3, :3].T @ found[:3, :3]).magnitude()
    return 1e3 * np.linalg.norm(found[:3, 3] - true[:3, 3]), np.degrees(turn)


def fitted(arm, theta, rvec, tvec, mount):
    return calibrate(arm, Measurements(theta, rvec=rvec, tvec=tvec), camera=mount, tag_size=SIDE)


@pytest.mark.parametrize("mount", ["tool", "base"])
def test_the_camera_is_found_without_a_guess_and_as_well_as_it_says(mount):
    *log, true = simulated(mount)
    found = fitted(*log, mount).hand_eye
    shift, turn = off(found.camera, true)
    assert shift < 4e3 * found.camera_std[0] < 6.0
    assert turn < 4 * np.degrees(found.camera_std[1]) < 0.6
    assert found.parent == (log[0].tip_link if mount == "tool" else log[0].base)
    xyz, rpy = (np.array(found.urdf.split(f'{name}="')[1].split('"')[0].split(), float) for name in ("xyz", "rpy"))
    assert np.allclose(xyz, found.camera[:3, 3], atol=1e-6)
    assert np.allclose(Rotation.from_euler("xyz", rpy).as_matrix(), found.camera[:3, :3], atol=1e-5)


@pytest.mark.parametrize("mount", ["tool", "base"])
def test_wrong_zeros_are_found_with_the_camera_and_a_flipped_tag_is_named(mount):
    zeros = np.radians([0.0, 2.0, -1.5, 1.0, 2.5, 0.0])
    arm, theta, rvec, tvec, true = simulated(mount, K=40, zeros=zeros)
    rvec[5] = (Rotation.from_rotvec(rvec[5]) * Rotation.from_rotvec([0.0, 0.0, np.pi / 2])).as_rotvec()
    r = fitted(arm, theta, rvec, tvec, mount)
    assert r.hand_eye.corrected
    assert r.outliers == (6,)
    assert np.allclose(r.zeros, zeros, atol=np.radians(0.5))
    shift, turn = off(r.hand_eye.camera, true)
    assert shift < 6.0
    assert turn < 0.6
    more = r.next_postures(3)
    assert more.shape == (3, arm.n)
    with pytest.raises(InputError, match="count"):
        r.next_postures(-1)


def test_a_tag_that_moved_by_5_mm_is_named_and_noise_is_not():
    """Errors of 5 mm and 2° in all directions; depth and tilts alike, as solvePnP does not measure them."""
    arm, theta, rvec, tvec, _ = simulated("tool", noise=0.0, seed=7)
    rng = np.random.default_rng(7)
    tvec = tvec + rng.normal(scale=5e-3, size=tvec.shape)
    rvec = (
        Rotation.from_rotvec(rng.normal(scale=np.radians(2.0), size=rvec.shape)) * Rotation.from_rotvec(rvec)
    ).as_rotvec()
    assert fitted(arm, theta, rvec, tvec, "tool").faults == ()
    arm, theta, rvec, tvec, _ = simulated("tool", K=40)
    tvec[20:] += Rotation.from_rotvec(rvec[20:]).apply([0.004, 0.003, 0.0])
    (fault,) = fitted(arm, theta, rvec, tvec, "tool").faults
    assert "moved near row 21" in fault


def test_few_rows_do_not_determine_the_camera():
    *log, _ = simulated("tool", K=5)
    found = fitted(*log, "tool").hand_eye
    assert not found.determined
    assert np.isinf(found.camera_std[0])


def test_slopes_of_the_image_are_those_of_finite_differences():
    rng, h = np.random.default_rng(1), 1e-6
    for mount in ("tool", "base"):
        camera, T = Camera(mount, SIDE, NOISE), exp(rng.normal(scale=0.3, size=6) + [0, 0, 0.6, 0, 0, 0])
        M = np.linalg.inv(T) if mount == "tool" else T
        u, slope = camera.image(M[None])
        assert np.allclose(u[0], project(Rotation.from_matrix(T[:3, :3]).as_rotvec(), T[:3, 3]).ravel())
        for j, step in enumerate(h * np.eye(6)):
            moved = M.copy()
            moved[:3, 3] += step[:3]
            moved[:3, :3] = Rotation.from_rotvec(step[3:]).as_matrix() @ M[:3, :3]
            assert np.allclose((camera.image(moved[None])[0] - u)[0] / h, slope[0, :, j], atol=1e-4)


def test_bad_logs_of_a_camera_are_refused_with_the_reason():
    arm, theta, rvec, tvec, _ = simulated("tool")
    R = Rotation.from_rotvec(rvec)
    still, spun = np.tile(theta[:1], (24, 1)), np.tile(theta[:1], (24, 1))
    spun[:, 5] += np.linspace(-1, 1, 24)
    for log, match in (
        ((theta, rvec, 1e3 * tvec), r"tx \[mm\]"),
        ((theta, np.degrees(rvec), tvec), r"rx \[deg\]"),
        ((theta, rvec, -tvec), "behind the camera"),
        ((theta, R.inv().as_rotvec(), np.abs(R.inv().apply(tvec))), "inverse"),
        ((still, rvec, tvec), "one axis at most"),
        ((spun, rvec, tvec), "one axis at most"),
        ((theta, rvec, np.where(np.arange(24)[:, None] == 3, np.nan, tvec)), "row 4"),
        ((theta[:2], rvec[:2], tvec[:2]), "measure more"),
    ):
        with pytest.raises(InputError, match=match):
            fitted(arm, *log, "tool")
    with pytest.raises(InputError, match="eye-in-hand"):
        calibrate(arm, Measurements(theta, rvec=rvec, tvec=tvec))
    with pytest.raises(InputError, match="tag_size"):
        calibrate(arm, Measurements(theta, arm.fk(theta)[:, :3, 3]), tag_size=SIDE)
    with pytest.raises(InputError, match="inverse"):
        fitted(arm, theta, rvec, tvec, "base")


def test_the_command_writes_the_joint_to_paste(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    arm, theta, rvec, tvec, true = simulated("tool")
    head = ",".join([*(f"{name} [deg]" for name in arm.joint_names), "rx", "ry", "rz", "tx [mm]", "ty [mm]", "tz [mm]"])
    table = np.hstack([np.degrees(theta), rvec, 1e3 * tvec])
    np.savetxt("log.csv", table, delimiter=",", header=head, comments="")
    given = ["calibrate", "ur5", "log.csv", "--camera", "tool", "--tag-size", "80 mm"]
    assert run([*given, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["hand_eye"]
    assert off(np.array(found["camera"]), true)[0] < 5.0
    assert run(given) == 0
    assert found["urdf"].splitlines()[1] in capsys.readouterr().out
    np.savetxt("few.csv", table[:3], delimiter=",", header=head, comments="")
    assert run([*given[:2], "few.csv", *given[3:], "-o", "out.urdf"]) == 1
    shown = capsys.readouterr().out
    assert "not determined" in shown
    assert "<joint" not in shown
    np.savetxt("half.csv", table[:, :-1], delimiter=",", header=head.rpartition(",")[0], comments="")
    assert run([*given[:2], "half.csv", *given[3:]]) == 2
    assert "belong together" in capsys.readouterr().err
