"""Servo, motors and closed form in the C++ header of an arm: the same as in Python, without heap."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from catalogue import load
from test_cpp_header import HEAP, STRICT, build, compile_one, compiler  # noqa: F401  (a fixture)  # noqa: F401  (a fixture)  # noqa: F401  (a fixture)
from twistarm import Actuators, Approach, Arm, JointLimits, Pose, TwistarmError
from twistarm.control.servo import AnyCommand, JogCommand, PoseCommand, ServoState, TwistCommand, servo_step
from twistarm.export.cpp_header import core_headers, cpp_header
from twistarm.ik import solve_ik_all
from twistarm.ik.targets import target_for

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


PROGRAM_MOTORS = """
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
    (folder / "motors.cpp").write_text(PROGRAM_MOTORS, encoding="utf-8")
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


PROGRAM_CLOSED_FORM = """
// Reads the numbers of a target; writes how many configurations are inside the limits, and each of them; again.
#include <cstdio>
#include "arm.hpp"
using namespace ARM;
using T = REAL;
int main() {
    const auto limits = ranges<T>();
    T given[COUNT];
    for (;;) {
        for (T& number : given) {
            double read;
            if (std::scanf("%lf", &read) != 1) return 0;
            number = static_cast<T>(read);
        }
        const auto found = solve_ik_all(limits, TARGET, poses<T>[0], T(TOLERANCE), T(TOLERANCE));
        std::printf("%d\\n", found.inside);
        for (int i = 0; i < found.inside; ++i)
            for (T value : found.found[i].theta) std::printf("%.17g\\n", static_cast<double>(value));
    }
}
"""

POSE = "twistarm::pose_target(twistarm::frame_from_rows<T>(given))"
APPROACH = "twistarm::approach_target(given, given + 3, given + 6)"

BUILDS = [
    pytest.param("rover_arm", "double", "approach", id="rover_arm"),
    pytest.param("ur5", "float", "pose", id="ur5-float"),
    pytest.param("panda", "double", "pose", id="panda", marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("name", "real", "kind"), BUILDS)
def test_as_in_python(name: str, real: str, kind: str, compiler: str, tmp_path: Path) -> None:  # noqa: F811
    """Of an arm with more joints than a pose determines the last stands where theta0 has it."""
    arm = load(name)
    tolerance, close = {"double": (1e-9, 1e-6), "float": (1e-4, 2e-2)}[real]
    target, count = (POSE, 16) if kind == "pose" else (APPROACH, 9)
    defines = {"REAL": real, "TARGET": target, "COUNT": count, "TOLERANCE": tolerance}
    program = build(compiler, arm, tmp_path, "all", PROGRAM_CLOSED_FORM, "-O1" if name == "panda" else "-O0", **defines)
    assert not any(taboo in program.read_bytes() for taboo in HEAP)
    theta = np.array(arm.random_theta(3, 10))
    given = {arm.joint_names[6]: float(arm.ready[6])} if arm.n > 6 else None
    theta[:, 6:] = arm.ready[6:]
    poses = arm.fk(theta)
    along = [Approach(g[:3, 3], g[:3, :3] @ arm.tool_axis) for g in poses]
    targets = [Pose(g) for g in poses] if kind == "pose" else [target_for(arm, approach) for approach in along]
    asked = "\n".join(" ".join(map(repr, target.numbers.ravel().tolist())) for target in targets)
    done = subprocess.run([program], input=asked, capture_output=True, text=True, timeout=60, check=True)
    numbers = iter(map(float, done.stdout.split()))
    for target in targets:
        found = np.array([[next(numbers) for _ in range(arm.n)] for _ in range(int(next(numbers)))])
        wanted = solve_ik_all(arm, target, fixed_joints=given)
        assert len(found) == len(wanted)
        apart = np.abs(found[:, None] - wanted.theta[None]).max(axis=2)
        assert (apart.min(axis=0) < close).all()
        assert (apart.min(axis=1) < close).all()


def test_an_arm_without_a_family_says_so() -> None:
    text = cpp_header(load("rover_arm_6dof"))
    assert "pose_family" not in text
    assert "position_family" in text
