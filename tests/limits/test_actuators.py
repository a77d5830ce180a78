"""Gears and differentials by hand, and the limits of motors."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from twistarm import Actuators, InputError, JointLimits
from twistarm.limits import MotionLimits


def differential(**changes: object) -> Actuators:
    """A geared slide, and the two motors of a wrist: left = 60 pitch + 60 roll, right = 60 pitch - 60 roll."""
    given = {
        "names": ("rail", "left", "right"),
        "joint_names": ("slide", "pitch", "roll"),
        "G": [[400.0, 0.0, 0.0], [0.0, 60.0, 60.0], [0.0, 60.0, -60.0]],
        "offset": [0.0, 0.5, -0.5],
        "units": ("turn", "tick", "deg"),
        "ticks_per_turn": [np.nan, 4096.0, np.nan],
    }
    return Actuators(**{**given, **changes})  # type: ignore[arg-type]


def test_a_differential_wrist_by_hand() -> None:
    motors = differential()
    # Both motors alike move the pitch, against each other the roll.
    assert np.allclose(motors.to_motor([0.1, 0.2, 0.0]), [40.0, 12.5, 11.5])
    assert np.allclose(motors.to_motor([0.0, 0.0, 0.3]), [0.0, 18.5, -18.5])
    assert np.allclose(motors.to_theta([40.0, 12.5, 11.5]), [0.1, 0.2, 0.0], atol=1e-15)


def test_gears_of_very_different_size_are_told_apart() -> None:
    """1e8 beside 1e-8: by singular values alone, the smaller would be rounding of the greater."""
    motors = Actuators(("m", "n"), ("a", "b"), [[1e8, 0.0], [0.0, 1e-8]], [0.0, 0.0], ("rad", "rad"), [np.nan] * 2)  # type: ignore[arg-type]
    assert motors.undriven == ()
    assert np.allclose(motors.to_theta([3e8, -2e-8]), [3.0, -2.0], rtol=1e-12)
    # Rows too: the second motor of a wrist, counted in something 1e16 times coarser.
    wrist = Actuators(("m", "n"), ("a", "b"), [[1e8, 1e8], [1e-8, -1e-8]], [0.0, 0.0], ("rad", "rad"), [np.nan] * 2)  # type: ignore[arg-type]
    assert np.allclose(wrist.to_theta([5e8, 1e-8]), [3.0, 2.0], rtol=1e-12)
    # And a slide beside a turn, with a motor to spare.
    spare = [[1e9, 0.0], [0.0, 1e-8], [0.0, 1e-8]]
    three = Actuators(("m", "n", "o"), ("a", "b"), spare, [0.0] * 3, ("rad",) * 3, [np.nan] * 3)  # type: ignore[arg-type]
    assert np.allclose(three.to_theta([3e9, 1e-8, 3e-8]), [3.0, 2.0], rtol=1e-12)


def test_counts_are_what_the_drive_reads() -> None:
    motors = differential()
    # One turn of each motor: 1 turn, 4096 ticks, 360 degrees.
    assert np.allclose(motors.to_counts(np.full(3, 2 * np.pi)), [1.0, 4096.0, 360.0])
    screws = differential(units=("mm", "m", "rad"), ticks_per_turn=[np.nan] * 3)
    assert np.allclose(screws.to_counts([0.25, 0.25, 0.25]), [250.0, 0.25, 0.25])


def test_velocities_are_the_slopes_of_positions() -> None:
    motors = differential()
    theta, theta_dot = np.random.default_rng(1).uniform(-1, 1, (2, 6, 3))
    h = 1e-4
    slope = (motors.to_motor(theta + h * theta_dot) - motors.to_motor(theta - h * theta_dot)) / (2 * h)
    assert np.allclose(motors.velocity_to_motor(theta_dot), slope, atol=1e-8)
    assert np.allclose(motors.velocity_to_theta(slope), theta_dot, atol=1e-8)


def test_torques_by_hand_and_by_their_power() -> None:
    motors = differential()
    # 0.1 N m of each wrist motor: 12 N m of pitch; against each other: of roll. 0.5 N m at the rail's 400 rad/m: 200 N.
    assert np.allclose(motors.torque_to_theta([0.5, 0.1, 0.1]), [200.0, 12.0, 0.0])
    assert np.allclose(motors.torque_to_theta([0.0, 0.1, -0.1]), [0.0, 0.0, 12.0])
    assert np.allclose(motors.torque_to_motor([200.0, 12.0, 0.0]), [0.5, 0.1, 0.1])
    tau_motor, theta_dot = np.random.default_rng(2).uniform(-1, 1, (2, 4, 5, 3))
    power = np.sum(tau_motor * motors.velocity_to_motor(theta_dot), axis=-1)
    tau = motors.torque_to_theta(tau_motor)
    assert tau.shape == (4, 5, 3)
    assert np.allclose(np.sum(tau * theta_dot, axis=-1), power)
    assert np.allclose(motors.torque_to_motor(tau), tau_motor)


def test_more_motors_than_joints_give_the_least_squares_and_share_a_torque() -> None:
    motors = Actuators(("a", "b"), ("j",), [[2.0], [1.0]], [0.0, 1.0], ("rad", "rad"), [np.nan, np.nan])  # type: ignore[arg-type]
    # d/dθ of (2θ − 3)² + (θ + 1 − 2)² is zero at θ = 7/5.
    assert np.allclose(motors.to_theta([3.0, 2.0]), [1.4])
    # 2 a + b = 10 with the least a² + b²: Lagrange gives a = 2 b, so b = 2.
    assert np.allclose(motors.torque_to_motor([10.0]), [4.0, 2.0])
    assert np.allclose(motors.torque_to_theta([4.0, 2.0]), [10.0])
    # Least squares of the velocities: 2 (2 v − 5) + (v − 5) = 0.
    assert np.allclose(motors.velocity_to_theta([5.0, 5.0]), [3.0])


def test_joints_that_the_motors_do_not_determine_are_named() -> None:
    idle = differential(G=[[400.0, 0, 0], [0, 60, 60], [0, 120, 120]])
    assert idle.undriven == ("pitch", "roll")
    assert np.allclose(idle.to_motor([0.0, 0.1, 0.0]), [0.0, 6.5, 11.5])
    with pytest.raises(InputError, match="'pitch', 'roll'"):
        idle.to_theta([0.0, 0.0, 0.0])
    for back in (idle.velocity_to_theta, idle.torque_to_motor):
        with pytest.raises(InputError, match="'pitch', 'roll'"):
            back([0.0, 0.0, 0.0])
    assert np.allclose(idle.torque_to_theta([0.0, 1.0, 0.0]), [0.0, 60.0, 60.0])
    assert np.isinf(idle.joint_limits.effort).all()
    assert differential(G=[[1e-3, 0, 0], [0, 1e5, 1e5], [0, 1e5, -1e5]]).undriven == ()
    one = Actuators(("a",), ("j", "k"), [[2.0, 0.0]], [0.0], ("rad",), [np.nan])  # type: ignore[arg-type]
    assert one.undriven == ("k",)


@pytest.mark.parametrize(
    ("changes", "culprit"),
    [
        ({"G": np.eye(2)}, "G of 3"),
        ({"units": ("turns", "tick", "deg")}, "'rail'.*'turns'"),
        ({"ticks_per_turn": [np.nan] * 3}, "'left'"),
        ({"units": ("m", "tick", "deg"), "ticks_per_turn": [8.0, 4096.0, np.nan]}, "'rail'"),
        ({"limits": JointLimits.unbounded(2)}, "limits of 3"),
        ({"ticks_per_turn": [np.nan, -4.0, np.nan]}, "'left'.*-4"),
        ({"units": ("rad",)}, "3 units"),
    ],
)
def test_what_cannot_be_is_refused(changes: dict[str, object], culprit: str) -> None:
    with pytest.raises(InputError, match=culprit):
        differential(**changes)


def test_limits_that_leave_a_joint_no_place_are_refused() -> None:
    ends = {"lower": {"rail": 10.0, "left": 10.0}}
    limits = JointLimits.unbounded(3).with_(ends, ("rail", "left", "right"))
    with pytest.raises(InputError, match="'slide'"):
        differential(G=[[400.0, 0, 0], [-400.0, 0, 0], [0, 60, 60]], limits=limits)


def limited() -> Actuators:
    changes = {
        "lower": {"rail": -100.0, "left": -90.0}, "upper": {"rail": 200.0}, "velocity": {"rail": 80.0, "left": 90.0},
        "acceleration": {"right": 300.0}, "effort": {"rail": 2.0, "left": 0.1, "right": 0.2},
    }  # fmt: skip
    return differential(limits=JointLimits.unbounded(3).with_(changes, ("rail", "left", "right")))


def test_what_the_motors_allow_each_joint_alone() -> None:
    alone = limited().joint_limits
    # The wrist's positions hang on each other: none of their own.
    assert alone.lower.tolist() == [-0.25, -np.inf, -np.inf]
    assert alone.upper.tolist() == [0.5, np.inf, np.inf]
    assert np.allclose(alone.velocity, [0.2, 1.5, 1.5])
    assert alone.acceleration.tolist() == [np.inf, 5.0, 5.0]
    # Both motors push alike for a torque of one joint: twice the weaker one's.
    assert np.allclose(alone.effort, [800.0, 12.0, 12.0])
    assert all(np.isinf(getattr(differential().joint_limits, name)).all() for name in ("lower", "velocity", "effort"))
    # A negative ratio turns the ends around.
    turned = differential(G=[[-400.0, 0, 0], [0, 60, 60], [0, 60, -60]], limits=limited().limits).joint_limits
    assert (turned.lower[0], turned.upper[0]) == (-0.5, 0.25)
    shifted = differential(offset=[20.0, 0.5, -0.5], limits=limited().limits).joint_limits
    assert (shifted.lower[0], shifted.upper[0]) == (-0.3, 0.45)


def test_wrong_sizes_are_named_with_the_joints() -> None:
    with pytest.raises(InputError, match="slide, pitch, roll"):
        differential().to_motor([0.0, 0.0])


def test_its_arrays_are_read_only_and_survive_pickling() -> None:
    with pytest.raises(ValueError, match="read-only"):
        differential().G[0, 0] = 1.0
    again = pickle.loads(pickle.dumps(differential()))
    assert np.array_equal(again.G, differential().G)
    assert again.names == ("rail", "left", "right")


def test_rows_that_do_not_fit_are_refused() -> None:
    with pytest.raises(InputError, match="must have the same number of rows"):
        MotionLimits(("a",), np.ones((2, 1)), np.zeros(1), JointLimits.unbounded(1))
    with pytest.raises(InputError, match="must have the same number of rows"):
        MotionLimits((), np.ones((0, 1)), np.zeros(0), JointLimits.unbounded(0))
    with pytest.raises(InputError, match="joints must be the limits of 3 joints \\('slide', 'pitch', 'roll'\\)"):
        differential().motion_limits(JointLimits.unbounded(2))
