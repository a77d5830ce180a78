"""Planted faults are named, sound motors are left in peace, and what a log does not show is not claimed."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from catalogue import load
from twistarm import Actuators, Arm, ComparisonError, InputError, check_wiring, load_arm
from twistarm.calibration import Measurements, read_measurements
from twistarm.cli.application import run
from twistarm.support.checks import Array
from twistarm.theory.rotations import to_xyzw
from wiring_logs import FAULTS, faults, logged, outcome, planted

ARMS = ("rover_arm", "rover_arm_6dof", "elbow", "scara", "stanford", "ur5", "panda", "so101")
# A fault that the log shows by fewer standard deviations may stay hidden: a ratio or zero takes 6.1, √(1.5 · 25), and
# noise hides up to two.
CLEAR = 8.0

MOTORS = Actuators(
    ("rail", "shoulder", "elbow", "left", "right"),
    ("slide", "shoulder", "elbow", "wrist_pitch", "wrist_roll"),
    np.array([[400.0, 0, 0, 0, 0], [0, 100, 0, 0, 0], [0, 0, -80, 0, 0], [0, 0, 0, 60, 60], [0, 0, 0, 60, -60]]),
    np.array([0.0, 0.4, 0.0, 0.0, 0.0]),
    ("turn", "rad", "rad", "tick", "tick"),
    np.array([np.nan, np.nan, np.nan, 4096.0, 4096.0]),
)
"""Two alike on the wrist: swapped, they turn the pitch as before, and the roll the other way."""

EXACT = {"base_position_noise": 0.0, "base_orientation_noise": 0.0}


def rover(beside: float = 0.0) -> Arm:
    """The rover arm with a tool so far beside the axis of its roll [m]."""
    tool = np.eye(4)
    tool[1, 3] = beside
    return replace(load("rover_arm").with_tool(tool, "probe"), actuators=MOTORS)


def log_of(
    *wrong: tuple[int, float, float], seed: int = 0, theta: Array | int = 20, poses: bool = True
) -> Measurements:
    """A log of motors whose ratio is so many times the arm.toml's, and whose offset is larger by so much."""
    G, offset = MOTORS.G.copy(), MOTORS.offset.copy()
    for i, factor, added in wrong:
        G[i] *= factor
        offset[i] += added
    return logged(rover(), replace(MOTORS, G=G, offset=offset), theta, seed, poses=poses, turned=np.radians(0.5))


PLANTED: dict[str, tuple[tuple[tuple[int, float, float], ...], dict[str, tuple[str, ...]]]] = {
    "a sign": (((2, -1.0, 0.0),), {"elbow": ("flipped sign",)}),
    "three signs": (
        ((0, -1.0, 0.0), (1, -1.0, 0.0), (3, -1.0, 0.0)),
        dict.fromkeys(("rail", "shoulder", "left"), ("flipped sign",)),
    ),
    "ticks of quadrature": (((3, 4.0, 0.0),), {"left": ("wrong ratio",)}),
    "a zero by 3 degrees": (((2, 1.0, 80 * np.radians(3.0)),), {"elbow": ("zero offset",)}),
    "a zero of the slide": (((0, 1.0, 8.0),), {"rail": ("zero offset",)}),
    "a sign and a zero of one": (((2, -1.0, 30.0),), {"elbow": ("flipped sign", "zero offset")}),
    "a ratio and a zero": (((0, 2.0, 0.0), (2, 1.0, 20.0)), {"rail": ("wrong ratio",), "elbow": ("zero offset",)}),
    "two ratios": (((1, 0.5, 0.0), (4, 1.25, 0.0)), {"shoulder": ("wrong ratio",), "right": ("wrong ratio",)}),
}


@pytest.mark.parametrize("case", PLANTED)
def test_planted_faults_are_named_with_the_true_entries(case: str) -> None:
    wrong, expected = PLANTED[case]
    report = check_wiring(rover(), log_of(*wrong, seed=1), **EXACT)
    assert (report.verdict, faults(report)) == ("fault", expected)
    assert report.after < 0.003 < report.before
    true = {i: (factor, added) for i, factor, added in wrong}
    for i, motor in enumerate(report.motors):
        factor, added = true.get(i, (1.0, 0.0))
        assert motor.ratio is not None
        assert np.allclose(list(motor.ratio.values()), factor * MOTORS.G[i][MOTORS.G[i] != 0], rtol=0.02)
        assert motor.zero == pytest.approx(MOTORS.offset[i] + added, abs=np.abs(MOTORS.G[i]).max() * 0.02)
    with pytest.raises(ComparisonError):
        report.require()


def counted(seeds: range, poses: bool, base: tuple[float, float]) -> Counter[str]:
    """How the reports of such logs come out, a fault in four of five; no sound motor is accused."""
    outcomes: Counter[str] = Counter()
    for seed in seeds:
        case = planted(ARMS, seed, fault=FAULTS[seed % len(FAULTS)], poses=poses, base=base)
        told = outcome(case, check_wiring(case.arm, case.log))
        assert told != "accused", case.words
        outcomes[f"hidden {told}" if case.shown < CLEAR else told] += 1
    return outcomes


@pytest.mark.parametrize("poses", [False, True], ids=["positions", "poses"])
def test_faults_are_named_though_the_base_is_a_centimetre_off(poses: bool) -> None:
    assert counted(range(501, 503), poses, (0.01, 0.0)) == {"named": 2}


@pytest.mark.slow
@pytest.mark.parametrize(("poses", "base"), [(False, 0.01), (True, 0.01), (False, 0.0)])
def test_the_shares_of_four_hundred_logs(poses: bool, base: float) -> None:
    outcomes = counted(range(20_000, 20_400), poses, (base, 0.0))
    clear = sum(count for told, count in outcomes.items() if not told.startswith("hidden"))
    assert outcomes["named"] >= 0.95 * clear
    assert clear >= 200  # of 320 faults; positions on the axis of a roll do not tell the motors of a differential apart


def exchanged(log: Measurements, i: int, j: int) -> Measurements:
    order = np.arange(5)
    order[[i, j]] = j, i
    return replace(log, theta=log.theta[:, order])


@pytest.mark.parametrize(("i", "j"), [(0, 2), (3, 4)])
def test_swapped_motors(i: int, j: int) -> None:
    report = check_wiring(rover(), exchanged(log_of(), i, j))
    assert faults(report) == {MOTORS.names[i]: ("swapped",), MOTORS.names[j]: ("swapped",)}


@pytest.mark.parametrize("swapped", [False, True])
def test_a_swap_that_positions_on_the_axis_do_not_show(swapped: bool) -> None:
    log = log_of(poses=False)
    report = check_wiring(rover(), exchanged(log, 3, 4) if swapped else log)
    assert (report.verdict, report.ok, faults(report)) == ("cannot tell", False, {})
    left, right = report.motors[3:]
    assert left.what == "the log does not show its swap with 'right', zero"
    assert right.what == "the log does not show its swap with 'left', zero"
    assert "orientation" in left.remedy


def test_positions_beside_the_axis_show_it() -> None:
    arm = rover(beside=0.05)
    log = logged(arm, MOTORS, 15, 0, poses=False)
    assert check_wiring(arm, log).verdict == "sound"
    assert faults(check_wiring(arm, exchanged(log, 3, 4))) == {"left": ("swapped",), "right": ("swapped",)}


def test_a_zero_of_either_has_no_entry_until_orientations_show_it() -> None:
    """3000 ticks of 60 · 4096 / 2π per rad are 4.39°, half of it pitch."""
    for poses, left, right in ((False, "cannot tell", "cannot tell"), (True, "fault", "sound")):
        log = log_of(poses=poses)
        report = check_wiring(rover(), replace(log, theta=log.theta + [0, 0, 0, 3000, 0]))
        assert [motor.verdict for motor in report.motors[3:]] == [left, right]
        assert (report.motors[3].zero is None) == (not poses)


def test_a_motor_at_rest_may_have_another_zero_or_ratio() -> None:
    theta = rover().random_theta(3, 20)
    theta[:, 2] = 0.7
    report = check_wiring(rover(), log_of(seed=3, theta=theta))
    assert (report.verdict, faults(report)) == ("cannot tell", {})
    assert [motor.name for motor in report.motors if motor.verdict == "cannot tell"] == ["elbow"]
    assert "elbow" in report.motors[2].remedy
    off = check_wiring(rover(), log_of((2, 1.0, 30.0), seed=3, theta=theta)).motors[2]
    assert (off.verdict, off.ratio, off.zero) == ("cannot tell", None, None)


@pytest.mark.parametrize(("rows", "poses"), [(1, False), (10, True)])
def test_a_log_at_one_place_shows_nothing(rows: int, poses: bool) -> None:
    report = check_wiring(rover(), log_of(theta=np.zeros((rows, 5)), poses=poses))
    assert (report.verdict, faults(report)) == ("cannot tell", {})
    assert all(motor.verdict == "cannot tell" and "move it" in motor.remedy for motor in report.motors)


def test_a_log_that_nothing_explains_blames_no_motor_and_names_the_row() -> None:
    log, noise = log_of(seed=6), np.random.default_rng(2).normal(scale=0.3, size=(20, 3))
    noisy = check_wiring(rover(), replace(log, position=log.position + noise))
    assert (noisy.verdict, faults(noisy)) == ("cannot tell", {})
    position = log.position.copy()
    position[6] += (0.1, 0.05, 0.0)
    odd = check_wiring(rover(), replace(log, position=position))
    assert (odd.verdict, faults(odd)) == ("cannot tell", {})
    assert "row 7" in odd.what


def test_a_base_that_stands_elsewhere_is_found() -> None:
    case = planted(["ur5"], 3, fault="none", poses=True, base=(0.03, np.radians(3.0)))
    report = check_wiring(case.arm, case.log)
    assert not faults(report)
    assert report.base is not None
    assert np.linalg.norm(report.base[:3, 3]) == pytest.approx(0.03, abs=0.01)
    assert np.arccos((np.trace(report.base[:3, :3]) - 1) / 2) == pytest.approx(np.radians(3.0), abs=np.radians(1.0))


def test_a_zero_of_the_first_joint_looks_like_a_turned_base() -> None:
    case = planted(["ur5"], 3, fault="none", poses=True, base=(0.0, 0.0))
    motors = case.arm.actuators
    assert motors is not None
    turned = motors.offset + motors.G[:, 0] * np.radians(4.0)
    arm = replace(case.arm, actuators=replace(motors, offset=turned))
    assert check_wiring(arm, case.log).motors[0].verdict == "cannot tell"
    known = check_wiring(arm, case.log, **EXACT)
    assert (known.motors[0].verdict, known.motors[0].faults, known.base) == ("fault", ("zero offset",), None)


def test_more_motors_than_joints_must_not_contradict_each_other() -> None:
    both = Actuators(
        (*MOTORS.names, "second"), MOTORS.joint_names, np.vstack([MOTORS.G, [[0.0, 0.0, 50.0, 0.0, 0.0]]]),
        np.append(MOTORS.offset, 1.0), (*MOTORS.units, "rad"), np.append(MOTORS.ticks_per_turn, np.nan),
    )  # fmt: skip
    arm, G = replace(rover(), actuators=both), both.G.copy()
    assert check_wiring(arm, logged(arm, both, 20, 7)).ok
    G[5] *= -1.0
    assert faults(check_wiring(arm, logged(arm, replace(both, G=G), 20, 7))) == {"second": ("flipped sign",)}


def test_what_it_cannot_work_with() -> None:
    log = log_of()
    loose = MOTORS.G.copy()
    loose[4, 4] = 60.0
    half = log.rotation.copy()
    half[3] = np.nan
    for arm, wrong in (
        (load("rover_arm"), log),
        (replace(rover(), actuators=replace(MOTORS, G=loose)), log),
        (rover(), replace(log, theta=log.theta[:, :4])),
        (rover(), replace(log, position=1000.0 * log.position)),
        (rover(), replace(log, rotation=half)),
        (rover(), Measurements(np.zeros((3, 5)), point=("p",) * 3)),
        (rover(), Measurements(np.zeros((0, 5)))),
    ):
        with pytest.raises(InputError):
            check_wiring(arm, wrong)
    for name in ("position_noise", "orientation_noise", "base_position_noise"):
        with pytest.raises(InputError, match=name):
            check_wiring(rover(), log, **{name: -0.01})


# -- the command -------------------------------------------------------------------------------------------------------


def actuator(i: int) -> str:
    """A motor's table of arm.toml."""
    ratio = ", ".join(f"{joint} = {g}" for joint, g in zip(MOTORS.joint_names, MOTORS.G[i], strict=True) if g)
    ticks = "ticks_per_turn = 4096\n" * (MOTORS.units[i] == "tick")
    return (
        f"\n[actuators.{MOTORS.names[i]}]\nratio = {{ {ratio} }}\noffset = {MOTORS.offset[i]}\n"
        f'unit = "{MOTORS.units[i]}"\n{ticks}'
    )


HEADER = "rail [turn],shoulder,elbow [rad],left [tick], right [tick] ,x [m],y,z"
ROW = "1.5,2,-3,100,-100,0.5,0.1,0.7"


@pytest.fixture
def toml(tmp_path: Path) -> Path:
    """The rover arm with motors, in a folder of its own."""
    shutil.copytree(Path(__file__).parents[2] / "robots" / "rover_arm", tmp_path / "arm")
    path = tmp_path / "arm" / "arm.toml"
    path.write_text(path.read_text("utf-8") + "".join(map(actuator, range(5))), "utf-8")
    return path


def csv(folder: Path, *lines: str) -> Path:
    (folder / "log.csv").write_text("\n".join(lines) + "\n", "utf-8")
    return folder / "log.csv"


def test_columns_by_name_in_any_order_with_units(toml: Path, tmp_path: Path) -> None:
    arm = load_arm(toml)
    path = csv(
        tmp_path, "# by tape", "z [mm],y,x,left,right,elbow,shoulder,rail", "", "300,2,1,40,50,30,20,10", "# end"
    )
    log = read_measurements(path, arm, counts=True)
    assert (log.theta.tolist(), log.position.tolist()) == ([[10, 20, 30, 40, 50]], [[1, 2, 0.3]])
    turned = csv(tmp_path, HEADER + ",qw,qx,qy,qz", ROW + ",0.7071,0,0,0.7071")  # a quarter turn about z
    rotation = read_measurements(turned, arm, counts=True).rotation[0]
    assert np.allclose(rotation, [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-4)


@pytest.mark.parametrize(
    "rows",
    [(), (HEADER.replace("left", "lefty"), ROW), (HEADER + ",x", ROW + ",1"), (HEADER.replace("[turn]", "[rad]"), ROW),
     (HEADER, ROW, "1,2,3"), (HEADER + ",qx,qy,qz,qw", ROW + ",0,0,0,0")],
)  # fmt: skip
def test_a_log_that_cannot_be_used_is_refused(rows: tuple[str, ...], toml: Path, tmp_path: Path) -> None:
    assert run(["wiring", str(toml), str(csv(tmp_path, *rows))]) == 2


def test_the_command_names_the_fault(toml: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for wrong, poses, code in (((), True, 0), (((2, -1.0, 0.0),), True, 1), ((), False, 1)):
        log = log_of(*wrong, poses=poses)
        columns = [log.theta, log.position, *([to_xyzw(log.rotation)] if poses else [])]
        rows = [",".join(f"{x:.6f}" for x in row) for row in np.hstack(columns)]
        path = csv(tmp_path, HEADER + ",qx,qy,qz,qw" * poses, *rows)
        assert run(["wiring", str(toml), str(path)]) == code
        shown = capsys.readouterr().out
        assert ("ratio = { elbow = 80" in shown) == bool(wrong)
        assert run(["wiring", str(toml), str(path), "--json"]) == code
        report = json.loads(capsys.readouterr().out)
        assert (report["ok"], report["rows"]) == (code == 0, 20)
        assert [motor["faults"] for motor in report["motors"]] == [[], [], ["flipped sign"] if wrong else [], [], []]
