"""The servo in the C++ header of an arm: the same drive as in Python, motors' limits among it, without heap."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from catalogue import load
from test_cpp_header import HEAP, build, compile_one, compiler  # noqa: F401  (a fixture)
from twistarm import Actuators, Arm, JointLimits, TwistarmError
from twistarm.control.servo import AnyCommand, JogCommand, PoseCommand, ServoState, TwistCommand, servo_step
from twistarm.export.cpp_header import cpp_header

PROGRAM = """
// Reads theta, then each step's command as kind, flags and 24 numbers; writes theta, theta_dot, scale and whose limit.
#include <cstdio>
#include "arm.hpp"
using namespace rover_arm;
bool read(double* numbers, int count) {
    for (int k = 0; k < count; ++k)
        if (std::scanf("%lf", numbers + k) != 1) return false;
    return true;
}
int main() {
    twistarm::servo_state<double, n> state{};
    int kind, flags;
    double given[24];
    if (!read(state.theta, n)) return 1;
    while (std::scanf("%d %d", &kind, &flags) == 2 && read(given, 24)) {
        twistarm::servo_command<double, n> command{};
        command.kind = static_cast<twistarm::servo_kind>(kind);
        command.base_axes = (flags & 1) != 0;
        for (int k = 0; k < 6; ++k) command.held[k] = (flags >> (k + 1) & 1) != 0;
        const bool pose = command.kind == twistarm::servo_kind::pose;
        for (int k = 0; k < n; ++k) command.rates[k] = given[k];
        for (int k = 0; k < 6; ++k) command.twist[k] = given[pose ? 16 + k : k];
        command.goal = twistarm::frame_from_rows<double>(given);
        command.linear_speed = given[22];
        command.angular_speed = given[23];
        twistarm::servo_output<double> out;
        twistarm::servo_step(chain<double>, servo_bounds<double>, command, 0.01, state, out);
        for (double angle : state.theta) std::printf("%.17g ", angle);
        for (double rate : state.theta_dot) std::printf("%.17g ", rate);
        const bool limit = out.row >= 0 && out.cause != twistarm::servo_cause::singularity;
        std::printf("%.17g %s\\n", out.scale, limit ? row_names[out.row] : "-");
    }
}
"""

SLOW_MOTOR = 0.6  # [rad/s]: less than the wrist's joints may do.


def with_wrist_motors() -> Arm:
    """The rover arm with a differential wrist, one of whose motors is slow."""
    arm = load("rover_arm")
    most = np.full(2, np.inf)
    limits = JointLimits(np.full(2, -30.0), np.full(2, 30.0), np.array([SLOW_MOTOR, 3.0]), np.full(2, 20.0), most, most)
    G = np.array([[0.0, 0, 0, 2, 2], [0, 0, 0, 2, -2]])
    motors = Actuators(
        ("left", "right"), arm.joint_names, G, np.array([0.1, 0.2]), ("rad",) * 2, np.full(2, np.nan), limits
    )
    return replace(arm, actuators=motors)


def drive(arm: Arm) -> list[AnyCommand | None]:
    g = arm.fk(arm.ready)
    g[:3, 3] += (0.05, 0.1, -0.05)
    commands: list[AnyCommand | None] = [
        TwistCommand(np.array([0.1, 0, 0, 0, 0, 0.3]), "tool"),
        TwistCommand(np.array([0, 0.1, -0.1, 0, 0, 0]), "base", "orientation"),
        JogCommand(np.array([0.2, -0.3, 0.1, 0.5, 0.4])),
        PoseCommand(g),
        TwistCommand(np.array([0.5, 0, 0, 0, 0, 0]), "base"),
        None,
    ]
    return [command for command in commands for _ in range(60)]


def written(command: AnyCommand | None) -> str:
    if command is None:
        return "0 0" + " 0" * 24
    numbers = np.zeros(24)
    numbers[: command.numbers.size] = command.numbers
    return f"{command.kind} {command.flags} " + " ".join(map(repr, numbers.tolist()))


def test_the_same_drive(compiler: str, tmp_path: Path) -> None:  # noqa: F811
    arm = with_wrist_motors()
    drive_o = build(compiler, arm, tmp_path, "drive.o", PROGRAM, "-O0", "-c")
    compile_one([compiler, str(drive_o), "-o", str(tmp_path / "drive")])
    commands = drive(arm)
    given = "\n".join([" ".join(map(repr, arm.ready.tolist())), *map(written, commands)])
    done = subprocess.run(
        [tmp_path / "drive"], input=given, capture_output=True, text=True, check=True, timeout=60
    ).stdout.splitlines()
    assert len(done) == len(commands)
    state, slowed = ServoState.at(arm, arm.ready), set()
    for line, command in zip(done, commands, strict=True):
        state, output = servo_step(arm, state, command, 0.01)
        *numbers, name = line.split()
        theirs = np.array(numbers, float)
        np.testing.assert_allclose(theirs[:5], state.theta, atol=1e-9)
        np.testing.assert_allclose(theirs[5:10], state.theta_dot, atol=1e-9)
        if command is not None:
            assert theirs[10] == pytest.approx(output.scale, abs=1e-9)
            if output.status == "SLOWED_LIMIT":
                assert name == output.joint
                slowed.add(name)
    assert "left" in slowed
    for taboo in HEAP:
        assert taboo not in drive_o.read_bytes()


def test_more_motors_than_the_core_holds() -> None:
    arm, k = load("rover_arm"), 65
    names = tuple(f"m{i}" for i in range(k))
    motors = Actuators(names, arm.joint_names, np.ones((k, 5)), np.zeros(k), ("rad",) * k, np.full(k, np.nan))
    with pytest.raises(TwistarmError, match="the servo drives at most 64 joints or motors; this arm has 65"):
        cpp_header(replace(arm, actuators=motors))
