"""The C++ header of an arm, compiled and run: forward kinematics, Jacobians and answers against Pinocchio."""

from __future__ import annotations

import json
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from catalogue import load
from needed import COMPILER, absent
from twistarm import (
    Approach,
    Arm,
    ArmBuilder,
    Pose,
    Position,
    TolerancedPose,
    TwistarmError,
    arm_from_screws,
    load_arm,
    solve_ik,
)
from twistarm.arm import engine
from twistarm.arm.baking import digest_of
from twistarm.cli.application import run
from twistarm.export.cpp_header import core_headers, cpp_header, namespace_of
from urdf_text import joint, robot, write

STRICT = ["-std=c++17", "-fno-exceptions", "-fno-rtti", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]

SEPARATE = """
#include "arm.hpp"
using T = REAL;
twistarm::solution<T, ARM::n> answer(const twistarm::frame<T>& goal, T tolerance) {
    static const auto ranges = ARM::ranges<T>();
    twistarm::search_settings<T> settings;
    settings.position_tolerance = settings.orientation_tolerance = tolerance;
    return ARM::solve_ik(ranges, twistarm::pose_target(goal), ARM::poses<T>[0], settings);
}
"""

PROGRAM = """
// Reads theta and a goal (4, 4), writes g, J^s and J^b by columns, the answer, and whether it converged; again.
#include <cstdio>
#include "arm.hpp"
using T = REAL;
twistarm::solution<T, ARM::n> answer(const twistarm::frame<T>& goal, T tolerance);

template <int Size> void show(const T (&numbers)[Size]) {
    for (T number : numbers) std::printf("%.17g ", static_cast<double>(number));
}
void show(const twistarm::column<T> (&J)[ARM::n]) {
    for (const auto& column : J) {
        show(column.v);
        show(column.w);
    }
}

int main() {
    double given[ARM::n + 16];
    for (;;) {
        for (double& number : given)
            if (std::scanf("%lf", &number) != 1) return 0;
        T theta[ARM::n], pose[16];
        for (int k = 0; k < ARM::n; ++k) theta[k] = static_cast<T>(given[k]);
        twistarm::column<T> spatial[ARM::n], body[ARM::n];
        twistarm::frame_to_rows(twistarm::forward(ARM::chain<T>, theta), pose);
        twistarm::forward_with_spatial_jacobian(ARM::chain<T>, theta, spatial);
        twistarm::forward_with_body_jacobian(ARM::chain<T>, theta, body);
        show(pose);
        show(spatial);
        show(body);
        const auto found = answer(twistarm::frame_from_rows<T>(given + ARM::n), static_cast<T>(TOLERANCE));
        show(found.theta);
        std::printf("%d\\n", found.converged ? 1 : 0);
    }
}
"""

NAMES = """
#include <cstdio>
#include <initializer_list>
#include "arm.hpp"
int main() {
    std::printf("%s%c", ARM::digest, 0);
    for (const char* name : ARM::joint_names) std::printf("%s%c", name, 0);
    for (int k = 0; k < ARM::pose_count; ++k) {
        std::printf("%s%c", ARM::pose_names[k], 0);
        for (double angle : ARM::poses<double>[k]) std::printf("%.17g%c", angle, 0);
    }
    for (const double* limit : {ARM::lower, ARM::upper, ARM::velocity, ARM::acceleration, ARM::effort})
        for (int k = 0; k < ARM::n; ++k) std::printf("%.17g%c", limit[k], 0);
}
"""

# Operators new and new[], C's own, and throwing: names that an object file would hold.
HEAP = (b"_Znwm", b"_Znam", b"malloc", b"calloc", b"__cxa_throw")


@pytest.fixture(scope="module")
def compiler() -> str:
    """The system's C++ compiler; it must be there where everything is required, as must the core."""
    if engine.core() is None or not COMPILER:
        absent(engine.why_not() or "there is no C++ compiler")
    return COMPILER


def mimic_arm(folder: Path) -> Arm:
    """Five joints follow four coordinates: the fourth goes −0.7 times and 0.2 rad beside the second."""
    links = ("base_link", "a", "b", "c", "d", "tool0")
    axes, kinds = ("0 0 1", "0 1 0", "1 0 0", "0 1 0", "0 0 1"), ("revolute",) * 4 + ("continuous",)
    limit = '<limit lower="-2" upper="2" velocity="1" effort="1"/>'
    follows = '<mimic joint="j1" multiplier="-0.7" offset="0.2"/>'
    joints = [
        joint(
            f"j{i}",
            *links[i : i + 2],
            xyz=f"0.1 0.05 {0.2 + 0.03 * i}",
            rpy=f"0.1 {0.2 * i} 0",
            kind=kinds[i],
            inside=f'<axis xyz="{axes[i]}"/>{"" if kinds[i] == "continuous" else limit}{follows if i == 3 else ""}',
        )
        for i in range(5)
    ]
    return load_arm(write(folder, robot(*joints, links=links, name="mimic arm")))


def helical_arm(folder: Path) -> Arm:
    """A thread, a turn, a slide and two turns: built as URDF, so that Pinocchio has it too."""
    builder = ArmBuilder("2 threads")
    builder = builder.helical("thread", (0, 0, 1), (0, 0, 0), 0.05, lower=-3, upper=3)
    builder = builder.revolute("turn", (0, 1, 0), (0, 0, 0.3), lower=-2, upper=2)
    builder = builder.prismatic("slide", (1, 0, 0), lower=0, upper=0.4)
    builder = builder.revolute("pitch", (0, 1, 0), (0.4, 0, 0.3), lower=-2, upper=2)
    home = np.eye(4)
    home[:3, 3] = (0.6, 0.02, 0.3)
    return builder.revolute("roll", (1, 0, 0), (0.4, 0, 0.3)).tool(home).build()


ARMS = {
    "rover_arm": lambda _: load("rover_arm"),
    "so101": lambda _: load("so101"),
    "mimic": mimic_arm,
    "helical": helical_arm,
}


@dataclass(frozen=True)
class Built:
    """A compiled program and the arm that it is about."""

    arm: Arm
    real: str
    program: Path
    object_file: Path

    def __call__(self, theta: np.ndarray, goals: np.ndarray) -> list[np.ndarray]:
        """g (N, 4, 4), J^s and J^b (N, 6, n), answers (N, n), converged (N,)."""
        rows = np.hstack([theta, goals.reshape(-1, 16)])
        text = "\n".join(" ".join(map(repr, row.tolist())) for row in rows)
        done = subprocess.run([self.program], input=text, capture_output=True, text=True, check=True, timeout=60)
        n = self.arm.n
        numbers = np.array(done.stdout.split(), float).reshape(len(theta), 16 + 13 * n + 1)
        g, spatial, body, answers, met = np.split(numbers, np.cumsum([16, 6 * n, 6 * n, n]), axis=1)
        columns = (np.swapaxes(J.reshape(-1, n, 6), 1, 2) for J in (spatial, body))
        return [g.reshape(-1, 4, 4), *columns, answers, met[:, 0] == 1]


def compile_program(compiler: str, arm: Arm, folder: Path, real: str, tolerance: float, optimised: str) -> Built:
    """The answer in a file of its own: including the header twice shows that it may stand in several."""
    defines = {"REAL": real, "TOLERANCE": tolerance}
    answer = build(compiler, arm, folder, "answer.o", SEPARATE, optimised, "-c", **defines)
    program = build(compiler, arm, folder, "run", PROGRAM, optimised, str(answer), **defines)
    return Built(arm, real, program, answer)


def build(compiler: str, arm: Arm, folder: Path, name: str, source: str, *flags: str, **defines: object) -> Path:
    """A program compiled beside the header of the arm; -DARM is its namespace."""
    (folder / "arm.hpp").write_text(cpp_header(arm))
    (folder / f"{name}.cpp").write_text(source, encoding="utf-8")
    known = [f"-D{key}={value}" for key, value in {"ARM": namespace_of(arm.name), **defines}.items()]
    where = [f"-I{folder}", f"-I{core_headers()}", "-o", str(folder / name)]
    compile_one([compiler, *STRICT, *known, str(folder / f"{name}.cpp"), *flags, *where])
    return folder / name


def compile_one(command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr


def reference(arm: Arm, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pinocchio's poses and Jacobians, spatial and body."""
    return arm.pinocchio.kinematics(theta, arm.base, arm.tip_link)


# How close kinematics come, and to what inverse kinematics solves.
PRECISIONS = {"double": (1e-12, 1e-6), "float": (1e-5, 1e-4)}
# Compiling takes seconds: `make test` has each number type and each kind of joint, unoptimised, which compiles in half
# the time, `make test-all` every pair.
QUICK = {("rover_arm", "float"), ("mimic", "double"), ("helical", "double")}

PAIRS = [
    pytest.param((name, real), id=f"{name}-{real}", marks=() if (name, real) in QUICK else pytest.mark.slow)
    for name in ARMS
    for real in PRECISIONS
]


@pytest.fixture(scope="module", params=PAIRS)
def built(request: pytest.FixtureRequest, compiler: str, tmp_path_factory: pytest.TempPathFactory) -> Built:
    (name, real), folder = request.param, tmp_path_factory.mktemp("arm")
    optimised = "-O0" if request.param in QUICK else "-O1"
    return compile_program(compiler, ARMS[name](folder), folder, real, PRECISIONS[real][1], optimised)


def test_against_pinocchio(built: Built) -> None:
    """Targets are Pinocchio's own poses of configurations inside the limits, and Pinocchio judges the answers."""
    arm, (close, tolerance) = built.arm, PRECISIONS[built.real]
    theta = arm.random_theta(np.random.default_rng(5), 40)
    goals, spatial, body = reference(arm, theta)
    g, J_s, J_b, answers, met = built(theta, goals)
    assert np.abs(g - goals).max() < close
    assert np.abs(J_s - spatial).max() < close
    assert np.abs(J_b - body).max() < close
    assert met.mean() > 0.9
    reached, _, _ = reference(arm, answers[met])
    assert arm.limits.contains(answers[met], close).all()
    assert np.linalg.norm(reached[:, :3, 3] - goals[met][:, :3, 3], axis=1).max() < tolerance + close
    turned = np.swapaxes(reached[:, :3, :3], 1, 2) @ goals[met][:, :3, :3]
    # ‖R − I‖ = 2√2 sin(φ/2).
    assert np.linalg.norm(turned - np.eye(3), axis=(1, 2)).max() < np.sqrt(2) * tolerance + 3 * close
    far, broken = np.eye(4), np.eye(4)
    far[:3, 3], broken[0, 3] = (9.0, 0.0, 0.0), np.nan
    *_, answers, met = built(np.array([arm.ready, arm.ready]), np.array([far, broken]))
    assert not met.any()
    assert arm.limits.contains(answers, {"double": 0.0, "float": 1e-6}[built.real]).all()
    np.testing.assert_allclose(answers[1], arm.ready, atol=1e-6)  # what is not finite is not searched for
    for taboo in HEAP:
        assert taboo not in built.object_file.read_bytes()


KINDS = """
// Reads a target as its kind and 23 numbers (g or p and two axes, tolerances, whether along the base's axes) and how
// the program knows the kind; writes the answer and whether it converged; again.
#include <cstdio>
#include "arm.hpp"
using namespace ARM;
template <class Target> twistarm::solution<double, n> answer(const Target& asked) {
    static const auto limits = ranges<double>();
    return solve_ik(limits, asked, poses<double>[0]);
}
twistarm::solution<double, n> answer(int kind, bool at_run_time, const double* given) {
    const auto pose = twistarm::pose_target(twistarm::frame_from_rows<double>(given));
    const auto position = twistarm::position_target(given);
    const auto approach = twistarm::approach_target(given, given + 3, given + 6);
    const auto task = twistarm::task_target(twistarm::frame_from_rows<double>(given), given + 16, given[22] != 0.0);
    if (at_run_time) {
        const twistarm::target<double> any[] = {pose, position, approach, task};
        return answer(any[kind]);
    }
    return kind == 0 ? answer(pose) : kind == 1 ? answer(position) : kind == 2 ? answer(approach) : answer(task);
}
int main() {
    int kind, at_run_time;
    double given[23];
    while (std::scanf("%d %d", &kind, &at_run_time) == 2) {
        for (double& number : given)
            if (std::scanf("%lf", &number) != 1) return 1;
        const auto found = answer(kind, at_run_time != 0, given);
        for (double angle : found.theta) std::printf("%.17g ", angle);
        std::printf("%d\\n", found.converged ? 1 : 0);
    }
}
"""

OF_EVERY_SIZE = [
    pytest.param(name, marks=() if name == "rover_arm" else pytest.mark.slow)
    for name in ("mimic", "rover_arm", "rover_arm_6dof", "panda")
]
"""Four to seven coordinates."""


def drawn_targets(arm: Arm, count: int) -> list[Pose | Position | Approach | TolerancedPose]:
    """Targets of every kind at Pinocchio's poses of configurations inside the limits."""
    goals, _, _ = reference(arm, arm.random_theta(np.random.default_rng(6), count))
    along, about = (0.01, 0.02, 0.0, 0.2, 0.0, np.inf), (0.0, np.inf, 0.0, 3.0, 0.1, 0.1)
    kinds = (
        Pose,
        lambda g: Position(g[:3, 3]),
        lambda g: Approach(g[:3, 3], 2 * g[:3, :3] @ arm.tool_axis, arm.tool_axis),
        lambda g: TolerancedPose(g, along, "target"),
        lambda g: TolerancedPose(g, about, "base"),
    )
    return [kind(g) for g in goals for kind in kinds]


@pytest.mark.parametrize("name", OF_EVERY_SIZE)
def test_every_kind_of_target(name: str, compiler: str, tmp_path: Path) -> None:
    """Each target is met where Python's own solver meets it, by the same configuration, and Pinocchio judges it."""
    arm = ARMS[name](tmp_path) if name in ARMS else load(name)
    # Eight solvers in one file: unoptimised they compile in a third of the time.
    program = build(compiler, arm, tmp_path, "kinds", KINDS)
    targets = drawn_targets(arm, 30)
    rows = [[*target.numbers.flat, *np.zeros(23 - target.numbers.size)] for target in targets]
    text = "\n".join(
        f"{target.kind} {i // 5 % 2} {' '.join(map(repr, map(float, row)))}"
        for i, (target, row) in enumerate(zip(targets, rows, strict=True))
    )
    done = subprocess.run([program], input=text, capture_output=True, text=True, check=True, timeout=60)
    numbers = np.array(done.stdout.split(), float).reshape(len(targets), arm.n + 1)
    answers, met = numbers[:, :-1], numbers[:, -1] == 1
    theirs = [solve_ik(arm, target) for target in targets]
    assert met.tolist() == [solution.converged for solution in theirs]
    assert met.mean() > 0.95
    assert arm.limits.contains(answers, 1e-12).all()
    reached, _, _ = reference(arm, answers)
    for target, g in zip(np.array(targets)[met], reached[met], strict=True):
        assert target.position_error(g) < 1.001e-6
        assert target.orientation_error(g) < 1.001e-6
    apart = np.abs(answers - [solution.theta for solution in theirs]).max(axis=1)
    assert (apart < 1e-6).mean() > 0.985  # where another search wins by a rounding, another root may be the answer


WRONG = """
#include "arm.hpp"
using namespace ARM;
void ask(const twistarm::frame<double>& g, const twistarm::frame<float>& single, const double* theta0) {
    const auto limits = ranges<double>();
    solve_ik(limits, g, theta0);
    solve_ik(limits, twistarm::pose_target(single), theta0);
    solve_ik<twistarm::target_kind::pose>(limits, twistarm::position_target(g.p), theta0);
    solve_ik<3>(limits, twistarm::pose_target(g), theta0);
    twistarm::pose_target(g).kind = twistarm::target_kind::position;
}
"""


def test_what_cannot_work_does_not_compile(compiler: str, rover: Arm, tmp_path: Path) -> None:
    (tmp_path / "arm.hpp").write_text(cpp_header(rover))
    (tmp_path / "wrong.cpp").write_text(WRONG, encoding="utf-8")
    command = [compiler, "-std=c++17", "-fsyntax-only", "-DARM=rover_arm", f"-I{tmp_path}", f"-I{core_headers()}"]
    done = subprocess.run([*command, str(tmp_path / "wrong.cpp")], capture_output=True, text=True, check=False)
    said = [line for line in done.stderr.splitlines() if " error: " in line]
    whys = ("pose_target, position_target", "leave out <Kind>", "2, 4 or 8 searches", "read-only|cannot assign")
    assert [sum(bool(re.search(why, line)) for line in said) for why in whys] == [2, 1, 1, 1]
    assert len(said) == 5


def test_names_poses_and_limits(compiler: str, tmp_path: Path) -> None:
    """Names that C++ has to be told about carefully come out as they went in."""
    names = ('a "quoted" \\ one', "%s ?? */ //", "größe\n関節")
    screws = np.column_stack([[0.0, 0, 0, 0, 0, 1], [0, 0, 0.5, 0, 1, 0], [1, 0, 0, 0, 0, 0]])
    limits = {"lower": {names[0]: -1.25}, "upper": {names[0]: 0.1}, "velocity": 2.5, "effort": {names[2]: 7.0}}
    arm = arm_from_screws(screws, np.eye(4), joints=names, limits=limits, name="*/ ü\\")
    program = build(compiler, arm, tmp_path, "names", NAMES)
    done = subprocess.run([program], capture_output=True, check=True, timeout=60)
    digest, *said = done.stdout.decode("utf-8").split("\0")[:-1]
    assert digest == digest_of(arm)
    assert tuple(said[:3]) == names
    assert said[3] == "ready"
    assert np.array_equal(np.array(said[4:7], float), arm.ready)
    bounds = [getattr(arm.limits, field) for field in ("lower", "upper", "velocity", "acceleration", "effort")]
    assert np.array_equal(np.array(said[7:], float), np.concatenate(bounds))


@pytest.mark.parametrize(
    ("name", "namespace"),
    [("__my--arm__", "my_arm"), ("6dof", "arm_6dof"), ("int", "arm_int"), ("関節", "arm"), ("", "arm")],
)
def test_the_namespace_is_an_identifier(name: str, namespace: str) -> None:
    assert namespace_of(name) == namespace


@pytest.mark.usefixtures("compiler")
def test_more_joints_than_the_core_holds() -> None:
    with pytest.raises(TwistarmError, match="its chains have at most 64 joints; snake has 66"):
        cpp_header(arm_from_screws(np.tile(np.eye(6)[:, 3:], 22), np.eye(4), name="snake"))


def test_the_command_names_the_folder(compiler: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, baked = tmp_path / "arm.hpp", tmp_path / "arm.json"
    assert run(["bake", "rover_arm", "-o", str(path)]) == 0
    assert f"-I {core_headers()}" in capsys.readouterr().out
    assert [file.name for file in tmp_path.iterdir()] == ["arm.hpp"]
    assert run(["bake", "rover_arm", "-o", str(path)]) == 2
    assert "--force" in capsys.readouterr().err
    assert run(["bake", "rover_arm", "-o", str(baked), "-o", str(path), "--force", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["written"] == [str(baked), str(path)]
    assert answer["include"] == str(core_headers())
    assert answer["digest"] in path.read_text("utf-8")
    assert answer["digest"] == json.loads(baked.read_text("utf-8"))["digest"]
