"""The ros2_control controller's update function, compiled and run without ROS; its files say the same things."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from catalogue import load
from test_cpp_header import HEAP, STRICT, compile_one, compiler  # noqa: F401  (a fixture)
from twistarm.control.servo import JogCommand, ServoState, servo_step
from twistarm.export.cpp_header import core_headers, cpp_header

PACKAGE = Path(__file__).parents[2] / "examples" / "ros2" / "twistarm_controller"

PROGRAM = """
// Reads cycles: theta, state_age, command_age, dt, enabled, rates; writes theta, theta_dot, valid and the reason.
#include <cstdio>
#include "arm.hpp"
#include "twistarm_controller/servo_update.hpp"
namespace controller = twistarm_controller;
using namespace rover_arm;
bool read(double* numbers, int count) {
    for (int k = 0; k < count; ++k)
        if (std::scanf("%lf", numbers + k) != 1) return false;
    return true;
}
int main() {
    controller::update_settings<double> settings{};
    settings.period = 0.01;
    controller::update_memory<double, n> memory{};
    controller::update_input<double, n> in{};
    double rest[4];
    while (read(in.theta, n) && read(rest, 4) && read(in.command.rates, n)) {
        in.command.kind = twistarm::servo_kind::jog;
        in.state_age = rest[0];
        in.command_age = rest[1];
        in.dt = rest[2];
        in.enabled = rest[3] != 0.0;
        controller::update_output<double> out{};
        controller::update(chain<double>, servo_bounds<double>, settings, in, memory, out);
        for (double angle : memory.state.theta) std::printf("%.17g ", angle);
        for (double rate : memory.state.theta_dot) std::printf("%.17g ", rate);
        std::printf("%d|%s\\n", out.valid ? 1 : 0, controller::text(out.reason));
    }
}
"""

RATES = [0.2, -0.3, 0.1, 0.5, 0.4]
FRESH = {"state_age": 0.0, "command_age": 0.0, "dt": 0.01, "enabled": 1.0}


@pytest.fixture(scope="module")
def controller(compiler: str, tmp_path_factory: pytest.TempPathFactory) -> Path:  # noqa: F811
    folder = tmp_path_factory.mktemp("controller")
    (folder / "arm.hpp").write_text(cpp_header(load("rover_arm")))
    (folder / "drive.cpp").write_text(PROGRAM, encoding="utf-8")
    include = [f"-I{folder}", f"-I{core_headers()}", f"-I{PACKAGE / 'include'}"]
    compile_one([compiler, *STRICT, "-O1", *include, "-c", str(folder / "drive.cpp"), "-o", str(folder / "drive.o")])
    compile_one([compiler, str(folder / "drive.o"), "-o", str(folder / "drive")])
    for taboo in HEAP:
        assert taboo not in (folder / "drive.o").read_bytes()
    return folder / "drive"


class Run:
    """What the controller answers to cycles, each `FRESH` but for what is given."""

    def __init__(self, program: Path, cycles: list[dict[str, object]]) -> None:
        ready = load("rover_arm").ready
        rows = []
        for given in cycles:
            cycle = {**FRESH, **given}
            numbers = [
                *np.asarray(cycle.pop("theta", ready)),
                *(cycle[name] for name in FRESH),
                *cycle.get("rates", RATES),
            ]
            rows.append(" ".join(map(repr, map(float, numbers))))
        said = subprocess.run([program], input="\n".join(rows), capture_output=True, text=True, check=True, timeout=60)
        lines = [line.split("|") for line in said.stdout.splitlines()]
        numbers = np.array([row.split() for row, _ in lines], float)
        self.theta, self.rates, self.valid = numbers[:, :5], numbers[:, 5:10], numbers[:, 10] == 1.0
        self.reasons = [reason for _, reason in lines]


def test_it_moves_as_the_servo_does(controller: Path) -> None:
    arm, cycles = load("rover_arm"), 20
    run = Run(controller, [{}] * cycles)
    state = ServoState.at(arm, arm.ready)
    for theta, rates in zip(run.theta, run.rates, strict=True):
        state, _ = servo_step(arm, state, JogCommand(RATES), 0.01)
        np.testing.assert_allclose(theta, state.theta, atol=1e-9)
        np.testing.assert_allclose(rates, state.theta_dot, atol=1e-9)
    assert run.valid.all()
    assert set(run.reasons) == {""}


@pytest.mark.parametrize(
    ("bad", "why"),
    [
        ({"command_age": 0.3}, "the command is too old"),
        ({"state_age": 0.3}, "the joint state is too old"),
        ({"theta": [np.nan] * 5}, "the joint state is too old"),
        ({"enabled": 0.0}, "motion is not enabled"),
        ({"dt": 0.5}, "the cycle came too late"),
    ],
)
def test_what_is_bad_brings_the_arm_to_rest_along_its_limits(
    controller: Path, bad: dict[str, object], why: str
) -> None:
    moving, stopping = 15, 40
    run = Run(controller, [{}] * moving + [bad] * stopping)
    assert set(run.reasons[moving:]) == {why}
    assert not run.rates[-1].any()
    jumps = np.abs(np.diff(run.rates, axis=0)) / 0.01
    assert (jumps <= load("rover_arm").limits.acceleration * (1.0 + 1e-9)).all()
    assert np.isfinite(run.theta).all()


def test_nothing_is_said_before_the_joints_say_numbers(controller: Path) -> None:
    run = Run(controller, [{"theta": [np.nan] * 5}] * 3 + [{}] * 3)
    assert run.valid.tolist() == [False] * 3 + [True] * 3
    assert run.reasons == ["no joint state has arrived"] * 3 + [""] * 3


def test_an_arm_that_strayed_waits_until_it_is_enabled_anew(controller: Path) -> None:
    away = {"theta": load("rover_arm").ready + [0.0, 0.3, 0.0, 0.0, 0.0]}
    released = {**away, "enabled": 0.0, "rates": [0.0] * 5}
    run = Run(controller, [{}] * 5 + [away] * 30 + [released] * 2 + [away] * 2)
    assert "not where it was commanded" in run.reasons[34]
    assert not run.rates[34].any()
    assert run.reasons[-1] == ""
    np.testing.assert_allclose(run.theta[-1], away["theta"], atol=0.01)


@pytest.mark.parametrize("release", [{"rates": [0.0] * 5}, {"command_age": 0.3}])
def test_a_stick_held_while_it_is_enabled_moves_nothing(controller: Path, release: dict[str, object]) -> None:
    run = Run(controller, [{"enabled": 0.0}] * 3 + [{}] * 5 + [release] + [{}] * 5)
    assert set(run.reasons[3:8]) == {"release the controls first: they were held when the arm was enabled"}
    assert not run.rates[:9].any()
    assert run.rates[-1].any()


def test_a_robot_that_was_off_is_not_told_to_jump_back(controller: Path) -> None:
    elsewhere = load("rover_arm").ready + [0.0, 0.5, 0.0, 0.0, 0.0]
    run = Run(controller, [{}] * 5 + [{"state_age": 1.0}] * 40 + [{"theta": elsewhere}] * 2)
    np.testing.assert_allclose(run.theta[-1], elsewhere, atol=0.01)
    assert run.reasons[-1] == ""


def test_the_class_around_it_fits_what_ros2_control_declares(compiler: str, tmp_path: Path) -> None:  # noqa: F811
    """On stand-ins of the headers: names, signatures and const are checked, nothing is run."""
    (tmp_path / "arm.hpp").write_text(cpp_header(load("rover_arm")))
    stand_ins = Path(__file__).parents[1] / "data" / "ros2_control"
    include = [f"-I{folder}" for folder in (tmp_path, stand_ins, core_headers(), PACKAGE / "include")]
    warnings = [flag for flag in STRICT if flag not in ("-fno-exceptions", "-fno-rtti")]
    source = str(PACKAGE / "src" / "servo_controller.cpp")
    compile_one([compiler, *warnings, "-fsyntax-only", "-DTWISTARM_ARM=rover_arm", *include, source])
