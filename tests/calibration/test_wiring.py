"""Planted faults of every kind are found and named, sound arms are left in peace, and what cannot be told is said."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from catalogue import load
from twistarm import Actuators, Arm, ComparisonError, InputError, UnitsWarning, check_wiring
from twistarm.calibration import WiringLog
from twistarm.support.checks import Array
from wiring_logs import faults, fitted, logged

ROVERS = ("rover_arm", "rover_arm_6dof")


def geared(name: str) -> Arm:
    """An arm of the catalogue with a gear on each joint and a differential wrist, counting in all units."""
    arm = load(name)
    n = arm.n
    G = np.diag([100.0 * (-1.0) ** i for i in range(n)])
    G[n - 2 :, n - 2 :] = [[60.0, 60.0], [60.0, -60.0]]
    names = tuple(f"m{i}" for i in range(n))
    units = ("rad", "tick", "deg", "rad", "turn", "rad")[:n]
    motors = Actuators(names, arm.joint_names, G, np.linspace(-3.0, 3.0, n), units, np.full(n, 4096.0))
    return replace(arm, actuators=motors)


def wired(arm: Arm, change: Callable[[Array, Array], object]) -> Actuators:
    """The motors as they really are: `change` alters G and the offset in place."""
    motors = fitted(arm)
    G, offset = motors.G.copy(), motors.offset.copy()
    change(G, offset)
    return replace(motors, G=G, offset=offset)


def log_of(arm: Arm, true: Actuators, seed: int, *, poses: bool = True, theta: Array | int = 20) -> WiringLog:
    return logged(arm, true, theta, seed, poses=poses, turned=np.radians(0.5))


def set_to(*rows: tuple[int, float, float]) -> Callable[[Array, Array], None]:
    """Multiplies a motor's row of G and adds to its offset."""

    def change(G: Array, offset: Array) -> None:
        for i, factor, added in rows:
            G[i] *= factor
            offset[i] += added

    return change


PLANTED: dict[str, tuple[Callable[[Array, Array], None], dict[str, tuple[str, ...]]]] = {
    "a sign": (set_to((2, -1.0, 0.0)), {"m2": ("flipped sign",)}),
    "three signs": (
        set_to((0, -1.0, 0.0), (1, -1.0, 0.0), (3, -1.0, 0.0)),
        dict.fromkeys(("m0", "m1", "m3"), ("flipped sign",)),
    ),
    "ticks of quadrature": (set_to((1, 4.0, 0.0)), {"m1": ("wrong ratio",)}),
    "a zero by 3 degrees": (set_to((2, 1.0, 100 * np.radians(3.0))), {"m2": ("zero offset",)}),
    "a zero of the slide": (set_to((0, 1.0, 2.0)), {"m0": ("zero offset",)}),
    "a sign and a zero of one": (set_to((2, -1.0, 30.0)), {"m2": ("flipped sign", "zero offset")}),
    "a sign and a zero": (set_to((1, -1.0, 0.0), (3, 1.0, 12.0)), {"m1": ("flipped sign",), "m3": ("zero offset",)}),
    "a ratio and a zero": (set_to((0, 2.0, 0.0), (2, 1.0, 20.0)), {"m0": ("wrong ratio",), "m2": ("zero offset",)}),
    "two ratios": (set_to((1, 0.5, 0.0), (4, 1.25, 0.0)), {"m1": ("wrong ratio",), "m4": ("wrong ratio",)}),
}


SLOW = {"a sign and a zero", "a ratio and a zero", "three signs"}


@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=[pytest.mark.slow] if case in SLOW else []) for case in PLANTED]
)
def test_planted_faults_are_named_with_the_true_entries(case: str) -> None:
    change, expected = PLANTED[case]
    arm = geared("rover_arm")
    true = wired(arm, change)
    report = check_wiring(arm, log_of(arm, true, seed=1), base_position_noise=0.0, base_orientation_noise=0.0)
    assert (report.verdict, faults(report)) == ("fault", expected)
    assert report.after.position < 0.003 < report.before.position
    for motor, row, zero in zip(report.motors, true.G, true.offset, strict=True):
        assert motor.ratio is not None
        assert np.allclose(list(motor.ratio.values()), row[row != 0], rtol=0.02)
        assert motor.zero == pytest.approx(zero, abs=100 * np.radians(1.0))
    with pytest.raises(ComparisonError, match=f"the wiring of rover_arm: .*{next(iter(expected))}: it"):
        report.require()


@pytest.mark.parametrize("poses", [True, False], ids=["poses", "positions"])
@pytest.mark.parametrize(
    ("name", "logs"), [("rover_arm", 12), *(pytest.param(name, 50, marks=pytest.mark.slow) for name in ROVERS)]
)
def test_no_false_alarm_on_honest_logs(name: str, logs: int, poses: bool) -> None:
    """With positions alone, the two motors of the wrist cannot be told apart, and that is said."""
    arm = geared(name)
    for seed in range(logs):
        report = check_wiring(arm, log_of(arm, fitted(arm), seed, poses=poses))
        assert faults(report) == {}
        assert report.verdict == ("sound" if poses else "cannot tell")
        unseen = [motor.name for motor in report.motors if motor.verdict == "cannot tell"]
        assert unseen == ([] if poses else list(fitted(arm).names[-2:]))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_random_pairs_on_the_six_joint_arm(seed: int) -> None:
    rng = np.random.default_rng(seed)
    arm = geared("rover_arm_6dof")
    i, j = (int(motor) for motor in rng.permutation(6)[:2])
    other = set_to((j, *[(0.75, 0.0), (1.0, 100 * np.radians(20.0))][seed % 2]))
    true = wired(arm, lambda G, offset: (set_to((i, -1.0, 0.0))(G, offset), other(G, offset)))
    report = check_wiring(arm, log_of(arm, true, seed))
    assert faults(report) == {f"m{i}": ("flipped sign",), f"m{j}": (("wrong ratio", "zero offset")[seed % 2],)}


@pytest.mark.parametrize(("i", "j"), [(0, 2), (3, 4)])
def test_swapped_motors(i: int, j: int) -> None:
    arm = geared("rover_arm")
    log = log_of(arm, fitted(arm), seed=2)
    order = np.arange(5)
    order[[i, j]] = j, i
    report = check_wiring(arm, WiringLog(log.names, log.counts[:, order], log.measured))
    assert faults(report) == {f"m{i}": ("swapped",), f"m{j}": ("swapped",)}
    assert f"it is swapped with 'm{j}'" in report.motors[i].what


def test_a_motor_that_was_not_moved_is_told_to_be_moved() -> None:
    arm = geared("rover_arm")
    theta = arm.random_theta(np.random.default_rng(3), 20)
    theta[:, 2] = 0.7
    report = check_wiring(arm, log_of(arm, fitted(arm), 3, theta=theta))
    assert (report.verdict, faults(report)) == ("cannot tell", {})
    assert [motor.remedy for motor in report.motors if motor.verdict == "cannot tell"] == [
        "move it: log elbow at several places, 30° apart and more"
    ]
    assert report.motors[2].scale_std > 1.0
    # Off by 0.3 rad it may be its zero or its ratio.
    off = check_wiring(arm, log_of(arm, wired(arm, set_to((2, 1.0, 30.0))), 3, theta=theta))
    elbow = off.motors[2]
    assert (off.verdict, elbow.verdict, elbow.ratio, elbow.zero) == ("fault", "possible fault", None, None)
    assert "add -17." in elbow.what
    assert ", or its ratio is 1.4" in elbow.what
    assert elbow.remedy == "move it: log elbow at several places, 30° apart and more"


def test_few_moments() -> None:
    arm = geared("rover_arm")
    theta = arm.random_theta(np.random.default_rng(5), 3)
    three = check_wiring(arm, log_of(arm, fitted(arm), 5, poses=False, theta=theta))
    assert any("log more moments, 10 at least" in motor.remedy for motor in three.motors)


def test_joints_turned_many_times_are_not_taken_for_degrees() -> None:
    """Those of a log nobody typed; the same numbers typed by a caller are remarked upon."""
    arm = load("rover_arm")
    theta = np.random.default_rng(0).uniform(-40.0, 40.0, (20, arm.n))
    with pytest.warns(UnitsWarning, match="^theta: angles of up to .* look like degrees"):
        arm.fk(theta.tolist())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnitsWarning)
        log = log_of(geared("rover_arm"), fitted(geared("rover_arm")), 0, theta=theta)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert check_wiring(geared("rover_arm"), log).verdict


def test_a_row_that_does_not_fit_is_named() -> None:
    arm = geared("rover_arm")
    log = log_of(arm, fitted(arm), 6)
    measured = log.measured.copy()
    measured[6, :3, 3] += (0.1, 0.05, 0.0)
    report = check_wiring(arm, WiringLog(log.names, log.counts, measured))
    assert (report.verdict, report.worst_row, faults(report)) == ("unexplained", 7, {})
    assert report.what == "row 7 of the log does not fit the others: measure it again, or leave it out"


def test_more_motors_than_joints() -> None:
    """Two motors on the elbow: they must not contradict each other, so that each is told by itself."""
    arm = geared("rover_arm")
    motors = fitted(arm)
    both = Actuators(
        (*motors.names, "second"),
        motors.joint_names,
        np.vstack([motors.G, [[0.0, 0.0, 50.0, 0.0, 0.0]]]),
        np.append(motors.offset, 1.0),
        (*motors.units, "rad"),
        np.append(motors.ticks_per_turn, np.nan),
    )
    arm = replace(arm, actuators=both)
    assert check_wiring(arm, log_of(arm, both, 7)).ok
    report = check_wiring(arm, log_of(arm, wired(arm, set_to((5, -1.0, 0.0))), 7))
    assert faults(report) == {"second": ("flipped sign",)}


def test_what_it_cannot_work_with() -> None:
    arm = geared("rover_arm")
    log = log_of(arm, fitted(arm), 9)
    with pytest.raises(InputError, match=r"rover_arm has no actuators: describe its motors as \[actuators.NAME\]"):
        check_wiring(load("rover_arm"), log)
    with pytest.raises(InputError, match="do not determine joint 'wrist_pitch', 'wrist_roll'"):
        check_wiring(replace(arm, actuators=wired(arm, lambda G, _: G.__setitem__((4, 4), 60.0))), log)
    for wrong, why in (
        (WiringLog(log.names[:4], log.counts[:, :4], log.measured), "no counts of motor 'm4'"),
        (WiringLog((*log.names[:4], "m9"), log.counts, log.measured), "a motor 'm9'; the arm's are 'm0'"),
        (WiringLog(log.names, np.zeros((0, 5)), np.zeros((0, 3))), "the log holds no moment"),
    ):
        with pytest.raises(InputError, match=why):
            check_wiring(arm, wrong)
    for name in ("position_noise", "orientation_noise"):
        with pytest.raises(InputError, match=name):
            check_wiring(arm, log, **{name: 0.0})


@pytest.mark.parametrize(
    ("names", "counts", "measured", "why"),
    [
        (("a", "b"), (3, 1), (3, 3), r"counts of 2 motors must have shape \(K, 2\); got \(3, 1\)"),
        (("a",), (3, 1), (2, 3), r"measured must be 3 positions \(3, 3\) or poses \(3, 4, 4\); got \(2, 3\)"),
        (("a", "a"), (3, 2), (3, 3), "a motor is named twice"),
        (("a",), (1, 1), (1, 4, 4), "measured is not in SE"),
    ],
)
def test_logs_that_are_none(
    names: tuple[str, ...], counts: tuple[int, ...], measured: tuple[int, ...], why: str
) -> None:
    with pytest.raises(InputError, match=why):
        WiringLog(names, np.zeros(counts), np.zeros(measured))
