"""The motors in the C++ header of an arm: what Python's `Actuators` gives, to the rounding of a product."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from catalogue import load
from test_cpp_header import STRICT, compile_one, compiler  # noqa: F401  (a fixture)
from twistarm import Actuators, Arm
from twistarm.export.cpp_header import core_headers, cpp_header

PROGRAM = """
// Reads theta and as many counts as there are motors; writes everything between them, of each arm.
#include <cstdio>
#include "wrist.hpp"
#include "spare.hpp"
#include "few.hpp"
template <int Size> void show(const double (&numbers)[Size]) {
    for (double number : numbers) std::printf("%.17g ", number);
}
template <class Drive, int N, int K> void there(const Drive& drive, const double (&theta)[N], double (&motor)[K]) {
    double counts[K];
    drive.to_motor(theta, motor);
    show(motor);
    drive.to_counts(motor, counts);
    show(counts);
    drive.velocity_to_motor(theta, motor);
    show(motor);
}
template <class Drive, int N, int K> void back(const Drive& drive, double (&theta)[N], const double (&counts)[K]) {
    double motor[K];
    drive.from_counts(counts, motor);
    show(motor);
    drive.to_theta(motor, theta);
    show(theta);
    drive.velocity_to_theta(motor, theta);
    show(theta);
}
int main() {
    double theta[wrist::n], counts[spare::motors], motor[spare::motors], five[wrist::motors], two[few::motors];
    for (double& angle : theta)
        if (std::scanf("%lf", &angle) != 1) return 1;
    for (double& count : counts)
        if (std::scanf("%lf", &count) != 1) return 1;
    for (int i = 0; i < wrist::motors; ++i) five[i] = counts[i];
    there(few::actuators<double>, theta, two);
    there(spare::actuators<double>, theta, motor);
    double five_motors[wrist::motors];
    there(wrist::actuators<double>, theta, five_motors);
    back(spare::actuators<double>, theta, counts);
    back(wrist::actuators<double>, theta, five);
#ifdef UNDRIVEN
    few::actuators<double>.to_theta(two, theta);
#endif
    for (int i = 0; i < wrist::motors; ++i)
        std::printf("%s,%s,%s ", wrist::motor_names[i], wrist::motor_units[i], wrist::count_units[i]);
}
"""


def driven(name: str, G: list[list[float]], units: tuple[str, ...]) -> Arm:
    """The rover arm under another name, with motors."""
    arm, k = load("rover_arm"), len(G)
    ticks = np.where(np.array(units) == "tick", 4096.0, np.nan)
    offset = np.linspace(-0.4, 0.9, k)
    motors = Actuators(tuple(f"m{i}" for i in range(k)), arm.joint_names, np.array(G), offset, units, ticks)
    return replace(arm, name=name, actuators=motors)


DIFFERENTIAL: list[list[float]] = [[0, 0, 0, 60.0, 60.0], [0, 0, 0, 57.0, -57.0]]
FIRST: list[list[float]] = [[400.0, 0, 0, 0, 0], [0, -100.0, 0, 0, 0], [0, 12.5, -80.0, 0, 0]]


@pytest.fixture(scope="module")
def arms(compiler: str, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Arm]]:  # noqa: F811
    """A differential wrist; the same with a second motor at the shoulder; the wrist's two motors alone."""
    folder = tmp_path_factory.mktemp("motors")
    made = [
        driven("few", DIFFERENTIAL, ("tick", "deg")),
        driven("spare", [*FIRST, *DIFFERENTIAL, [0, 50.0, 0, 0, 0]], ("mm", "rad", "turn", "tick", "deg", "tick")),
        driven("wrist", [*FIRST, *DIFFERENTIAL], ("mm", "rad", "turn", "tick", "tick")),
    ]
    for arm in made:
        (folder / f"{arm.name}.hpp").write_text(cpp_header(arm))
    (folder / "motors.cpp").write_text(PROGRAM, encoding="utf-8")
    return folder, made


def command(compiler: str, folder: Path) -> list[str]:  # noqa: F811
    return [compiler, *STRICT, f"-I{folder}", f"-I{core_headers()}", str(folder / "motors.cpp")]


def test_there_and_back(compiler: str, arms: tuple[Path, list[Arm]]) -> None:  # noqa: F811
    folder, (few, spare, wrist) = arms
    compile_one([*command(compiler, folder), "-o", str(folder / "motors")])
    rng = np.random.default_rng(4)
    for _ in range(20):
        theta, counts = wrist.random_theta(rng), rng.normal(scale=1000.0, size=6)
        given = " ".join(map(repr, [*theta.tolist(), *counts.tolist()]))
        done = subprocess.run([folder / "motors"], input=given, capture_output=True, text=True, check=True, timeout=60)
        words = done.stdout.split()
        expected = []
        for arm in (few, spare, wrist):
            motors = arm.actuators
            motor = motors.to_motor(theta)
            expected += [motor, motors.to_counts(motor), motors.velocity_to_motor(theta)]
        for arm in (spare, wrist):
            motors = arm.actuators
            motor = motors.from_counts(counts[: len(motors.names)])
            expected += [motor, motors.to_theta(motor), motors.velocity_to_theta(motor)]
        every = np.concatenate(expected)
        assert np.allclose(np.array(words[: len(every)], float), every, rtol=1e-12, atol=1e-12)
    assert words[len(every) :] == ["m0,m,mm", "m1,rad,rad", "m2,rad,turn", "m3,rad,tick", "m4,rad,tick"]


def test_joints_that_no_motor_determines_do_not_compile(compiler: str, arms: tuple[Path, list[Arm]]) -> None:  # noqa: F811
    folder, _ = arms
    done = subprocess.run(
        [*command(compiler, folder), "-DUNDRIVEN", "-fsyntax-only"], capture_output=True, text=True, check=False
    )
    assert "leave a joint undriven" in done.stderr
    assert done.returncode != 0
