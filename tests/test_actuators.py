"""motor = G theta + o: by hand on a differential wrist, back and forth, and what cannot be told apart."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from twistarm import Actuators, InputError


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


def test_back_and_forth_in_batches() -> None:
    motors = differential()
    theta = np.random.default_rng(0).uniform(-1, 1, (4, 5, 3))
    assert motors.to_motor(theta).shape == (4, 5, 3)
    assert np.allclose(motors.to_theta(motors.to_motor(theta)), theta, atol=1e-14)
    assert np.allclose(motors.from_counts(motors.to_counts(motors.to_motor(theta))), motors.to_motor(theta))


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


def test_more_motors_than_joints_give_the_least_squares() -> None:
    motors = Actuators(("a", "b"), ("j",), [[2.0], [1.0]], [0.0, 1.0], ("rad", "rad"), [np.nan, np.nan])  # type: ignore[arg-type]
    # d/dθ of (2θ − 3)² + (θ + 1 − 2)² is zero at θ = 7/5.
    assert np.allclose(motors.to_theta([3.0, 2.0]), [1.4])


def test_joints_that_the_motors_do_not_determine_are_named() -> None:
    idle = differential(G=[[400.0, 0, 0], [0, 60, 60], [0, 120, 120]])
    assert idle.undriven == ("pitch", "roll")
    assert np.allclose(idle.to_motor([0.0, 0.1, 0.0]), [0.0, 6.5, 11.5])
    with pytest.raises(InputError, match="do not determine joint 'pitch', 'roll': G must have full column rank"):
        idle.to_theta([0.0, 0.0, 0.0])
    assert differential(G=[[1e-3, 0, 0], [0, 1e5, 1e5], [0, 1e5, -1e5]]).undriven == ()
    one = Actuators(("a",), ("j", "k"), [[2.0, 0.0]], [0.0], ("rad",), [np.nan])  # type: ignore[arg-type]
    assert one.undriven == ("k",)


REFUSED = {
    "G of another shape": ({"G": np.eye(2)}, r"G of 3 actuators and 3 joints must have shape \(3, 3\)"),
    "an offset that is none": ({"offset": [0.0, np.nan, 0.0]}, "offset must be finite"),
    "an unknown unit": ({"units": ("turns", "tick", "deg")}, "'rail' counts in 'turns'; allowed: rad, deg, turn"),
    "negative ticks": ({"ticks_per_turn": [np.nan, -4.0, np.nan]}, "'left': ticks_per_turn must be positive; got -4"),
    "ticks without a number": ({"ticks_per_turn": [np.nan] * 3}, "'left' counts in ticks: give its ticks_per_turn"),
    "turns of what slides": (
        {"units": ("m", "tick", "deg"), "ticks_per_turn": [8.0, 4096.0, np.nan]},
        "'rail' counts in m and makes no turns",
    ),
    "too few units": ({"units": ("rad",)}, "3 actuators need 3 units"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_is_refused(case: str) -> None:
    changes, message = REFUSED[case]
    with pytest.raises(InputError, match=message):
        differential(**changes)


def test_wrong_sizes_are_told_with_the_names() -> None:
    with pytest.raises(InputError, match=r"theta must have shape \(..., 3\): slide, pitch, roll; got \(2,\)"):
        differential().to_motor([0.0, 0.0])
    with pytest.raises(InputError, match=r"motor must have shape \(..., 3\): rail, left, right"):
        differential().to_theta(0.0)


def test_its_arrays_are_read_only_also_after_pickling() -> None:
    for motors in (differential(), pickle.loads(pickle.dumps(differential()))):
        with pytest.raises(ValueError, match="read-only"):
            motors.G[0, 0] = 1.0
        assert motors.names == ("rail", "left", "right")
