"""What a log cannot tell is said, and nothing is blamed for it: swaps, possible faults, too little, another unit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from catalogue import load
from twistarm import Actuators, Arm, check_wiring
from twistarm.calibration import WiringLog
from twistarm.support.checks import Array
from wiring_logs import faults, logged

MOTORS = Actuators(
    ("rail", "shoulder", "elbow", "left", "right"),
    ("slide", "shoulder", "elbow", "wrist_pitch", "wrist_roll"),
    np.array([[400.0, 0, 0, 0, 0], [0, 100, 0, 0, 0], [0, 0, -80, 0, 0], [0, 0, 0, 60, 60], [0, 0, 0, 60, -60]]),
    np.array([0.0, 0.4, 0.0, 0.0, 0.0]),
    ("turn", "rad", "rad", "tick", "tick"),
    np.array([np.nan, np.nan, np.nan, 4096.0, 4096.0]),
)
"""Two alike on the wrist: swapped, they turn the pitch as before, and the roll the other way."""


def rover(beside: float = 0.0) -> Arm:
    """The rover arm with a tool so far beside the axis of its roll [m]."""
    tool = np.eye(4)
    tool[1, 3] = beside
    return replace(load("rover_arm").with_tool(tool, "probe"), actuators=MOTORS)


def log_of(arm: Arm, *, theta: Array | int = 15, poses: bool = False) -> WiringLog:
    return logged(arm, MOTORS, theta, 0, poses=poses)


def swapped_wrist(log: WiringLog) -> WiringLog:
    return WiringLog(log.names, log.counts[:, [0, 1, 2, 4, 3]], log.measured)


@pytest.mark.parametrize("swapped", [False, True])
def test_a_swap_that_positions_on_the_axis_do_not_show(swapped: bool) -> None:
    log = log_of(rover())
    report = check_wiring(rover(), swapped_wrist(log) if swapped else log)
    assert (report.verdict, report.ok, faults(report)) == ("cannot tell", False, {})
    assert "nor whether 'left' and 'right' are swapped; what it does show is sound" in report.what
    left, right = report.motors[3:]
    assert (left.unseen, right.unseen) == (("zero", "swapped with right"), ("zero", "swapped with left"))
    assert left.remedy == "measure the tool's orientation too, or a point of the tool beside its axis"


def test_positions_beside_the_axis_and_poses_show_it() -> None:
    for arm, poses in ((rover(beside=0.05), False), (rover(), True)):
        log = log_of(arm, poses=poses)
        assert check_wiring(arm, log).verdict == "sound"
        assert faults(check_wiring(arm, swapped_wrist(log))) == {"left": ("swapped",), "right": ("swapped",)}


def test_a_roll_that_was_never_turned_hides_it_from_poses() -> None:
    theta = rover().random_theta(np.random.default_rng(1), 15)
    theta[:, 4] = 0.0
    report = check_wiring(rover(), log_of(rover(), theta=theta, poses=True))
    assert report.verdict == "cannot tell"
    assert report.motors[3].unseen == ("swapped with right",)
    assert report.motors[3].remedy == "log more moments in which each of wrist_pitch and wrist_roll moves by itself"


def test_a_zero_of_either_has_no_entry_until_orientations_tell() -> None:
    """3000 ticks of 60 · 4096 / 2π per rad are 4.39°, half of it pitch."""
    for poses, left, right in ((False, "possible fault", "possible fault"), (True, "fault", "sound")):
        log = log_of(rover(), poses=poses)
        report = check_wiring(rover(), WiringLog(log.names, log.counts + [0, 0, 0, 3000, 0], log.measured))
        assert report.verdict == "fault"
        assert [motor.verdict for motor in report.motors[3:]] == [left, right]
        assert report.motors[3].joint_offset["wrist_pitch"] == pytest.approx(-np.radians(4.39 / 2), abs=0.004)
        assert (report.motors[3].zero is None) == (not poses)
        assert ("[actuators." in report.motors[3].remedy) == poses
        assert (", or a fault of 'right': the log does not tell which" in report.motors[3].what) == (not poses)


def test_a_certain_fault_beside_a_possible_one_keeps_its_entry() -> None:
    log = log_of(rover())
    counts = log.counts * [1, 1, -1, 1, 1] + [0, 0, 0, 3000, 0]
    report = check_wiring(rover(), WiringLog(log.names, counts, log.measured))
    assert [motor.verdict for motor in report.motors[2:]] == ["fault", "possible fault", "possible fault"]
    assert report.motors[2].ratio == {"elbow": 80.0}
    assert report.what.startswith("the log shows what is wrong with 'elbow'; one thing is wrong and the log does not")


@pytest.mark.parametrize(("rows", "poses"), [(1, False), (10, True)])
def test_a_log_at_one_place_shows_nothing(rows: int, poses: bool) -> None:
    report = check_wiring(rover(), log_of(rover(), theta=np.zeros((rows, 5)), poses=poses))
    assert report.verdict == "cannot tell"
    assert report.what == "no motor was moved, so the log does not show the sign, ratio or zero of any"
    assert all(motor.unseen == ("sign", "ratio", "zero") for motor in report.motors)
    assert report.motors[2].remedy == "move it: log elbow at several places, 30° apart and more"


def test_nothing_but_zeros() -> None:
    report = check_wiring(rover(), WiringLog(MOTORS.names, np.zeros((3, 5)), np.zeros((3, 3))))
    assert (report.verdict, faults(report)) == ("cannot tell", {})
    assert report.what.endswith("of any; and the tool was not measured where the arm.toml puts it")


@pytest.mark.parametrize(
    ("unit", "metres"), [("millimetres", 0.001), pytest.param("inches", 0.0254, marks=pytest.mark.slow)]
)
def test_positions_in_another_unit(unit: str, metres: float) -> None:
    log = log_of(rover())
    counts = log.counts * [1, 1, -1, 1, 1]
    report = check_wiring(rover(), WiringLog(log.names, counts, log.measured / metres))
    assert report.verdict == "unexplained"
    assert report.what.startswith(f"the positions look like {unit}: log x, y, z in metres; read so, the log shows what")
    assert faults(report) == {"elbow": ("flipped sign",)}
    assert report.after.position < 0.003


def test_an_unexplained_log_blames_no_motor() -> None:
    log = log_of(rover())
    measured = log.measured + np.random.default_rng(2).normal(scale=0.3, size=log.measured.shape)
    told: list[float] = []
    report = check_wiring(rover(), WiringLog(log.names, log.counts, measured), progress=told.append)
    assert (report.verdict, faults(report)) == ("unexplained", {})
    assert all(motor.what == "" and np.isinf(motor.scale_std) for motor in report.motors)
    assert len(told) >= 6
    assert told == sorted(told)
    assert 0.0 < told[0] < told[-1] <= 1.0
