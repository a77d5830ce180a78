"""A base that is not where it was measured: faults are named in spite of it, and no sound motor is blamed for it."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from twistarm import InputError, check_wiring
from wiring_logs import FAULTS, outcome, planted

ARMS = ("rover_arm", "rover_arm_6dof", "elbow", "scara", "stanford", "ur5", "panda", "so101")
FAR = 8.0
"""A fault that moves the tool by fewer standard deviations may stay hidden."""


def counted(seeds: range, poses: bool, base: tuple[float, float]) -> Counter[str]:
    """How the reports of such logs come out, a fault in four of five."""
    outcomes: Counter[str] = Counter()
    for seed in seeds:
        case = planted(ARMS, seed, fault=FAULTS[seed % len(FAULTS)], poses=poses, base=base)
        told = outcome(case, check_wiring(case.arm, case.log))
        outcomes[f"hidden {told}" if told != "accused" and case.miss < FAR else told] += 1
        assert told != "accused", case.words
    return outcomes


@pytest.mark.parametrize("poses", [False, True], ids=["positions", "poses"])
@pytest.mark.parametrize(
    "base",
    [
        pytest.param((0.0, 0.0), id="exact", marks=pytest.mark.slow),
        pytest.param((0.01, 0.0), id="1cm"),
        pytest.param((0.01, np.radians(2.0)), id="1cm2deg", marks=pytest.mark.slow),
    ],
)
def test_faults_are_named_and_no_sound_motor_is_accused(poses: bool, base: tuple[float, float]) -> None:
    outcomes = counted(range(500, 503), poses, base)
    assert outcomes["unexplained"] + outcomes["missed"] + outcomes["left open"] <= 1


@pytest.mark.slow
@pytest.mark.parametrize("part", range(10))
def test_no_sound_motor_is_accused_in_two_thousand_logs_of_positions(part: int) -> None:
    counted(range(10_000 + 200 * part, 10_200 + 200 * part), False, (0.0, 0.0))


@pytest.mark.slow
@pytest.mark.parametrize("poses", [False, True], ids=["positions", "poses"])
def test_single_faults_with_a_base_that_is_a_centimetre_off(poses: bool) -> None:
    outcomes = counted(range(20_000, 20_400), poses, (0.01, 0.0))
    clear = [count for told, count in outcomes.items() if not told.startswith("hidden")]
    assert outcomes["named"] >= 0.95 * sum(clear)


def test_the_base_is_found_and_told() -> None:
    """An arm with every motor sound: exit code, words and offset say where the base is, to the noise."""
    case = planted(["ur5"], 3, fault="none", poses=True, base=(0.03, np.radians(3.0)))
    report = check_wiring(case.arm, case.log)
    assert report.base is not None
    assert np.linalg.norm(report.base.position) == pytest.approx(0.03, abs=0.01)
    assert np.linalg.norm(report.base.rotation) == pytest.approx(np.radians(3.0), abs=np.radians(1.0))
    assert report.what.startswith("with the base ")
    assert not any(motor.faults for motor in report.motors)


def test_a_zero_of_the_first_joint_looks_like_a_turned_base() -> None:
    case = planted(["ur5"], 3, fault="none", poses=True, base=(0.0, 0.0))
    motors = case.arm.actuators
    assert motors is not None
    turned = motors.offset + motors.G[:, 0] * np.radians(4.0)
    arm = replace(case.arm, actuators=replace(motors, offset=turned))
    doubted = check_wiring(arm, case.log)
    assert doubted.motors[0].verdict == "possible fault"
    assert "or the base is" in doubted.what
    assert "--base-orientation-noise" in doubted.motors[0].remedy
    known = check_wiring(arm, case.log, base_position_noise=0.0, base_orientation_noise=0.0)
    assert (known.motors[0].verdict, known.motors[0].faults, known.base) == ("fault", ("zero offset",), None)


def test_a_zero_that_only_the_base_hides_has_the_base_measured() -> None:
    case = planted(["rover_arm"], 4, fault="flipped sign", poses=False, base=(0.01, 0.0))
    rail = check_wiring(case.arm, case.log).motors[0]
    assert (rail.verdict, rail.unseen) == ("cannot tell", ("zero",))
    assert rail.remedy.startswith("measure the base anew")


def test_a_noise_that_is_larger_than_was_said_is_tried_and_named() -> None:
    case = planted(["rover_arm"], 1, fault="none", poses=False, base=(0.0, 0.0))
    report = check_wiring(case.arm, case.log, position_noise=0.0002)
    assert report.verdict == "unexplained"
    assert "with --position-noise 0.00" in report.what


def test_a_noise_of_the_base_is_a_number_and_not_negative() -> None:
    case = planted(["rover_arm"], 1, fault="none", poses=False, base=(0.0, 0.0))
    for bad in (-0.01, np.nan, "much"):
        with pytest.raises(InputError, match="base_position_noise"):
            check_wiring(case.arm, case.log, base_position_noise=bad)  # type: ignore[arg-type]
