"""The C++ header of an arm, compiled and run: forward kinematics, Jacobians and answers against Pinocchio."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from catalogue import load
from twistarm import Arm, ArmBuilder, InputError, TwistarmError, arm_from_screws, cpp_header, engine, load_arm
from twistarm.baking import digest_of
from twistarm.cli.application import run
from twistarm.cpp_header import core_headers, namespace_of, write_cpp_header
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

HEAP = (b"_Znwm", b"_Znam", b"malloc", b"calloc", b"__cxa_throw")
"""Operators new and new[], C's own, and throwing: names that an object file would hold."""


@pytest.fixture(scope="module")
def compiler() -> str:
    """The system's C++ compiler; it must be there where everything is required, as must the core."""
    found = next((name for name in ("c++", "g++", "clang++") if shutil.which(name)), None)
    lacking = engine.why_not() if engine.core() is None else "" if found else "there is no C++ compiler"
    if lacking:
        if os.environ.get("TWISTARM_REQUIRE_ALL"):
            pytest.fail(lacking)
        pytest.skip(lacking)
    assert found is not None
    return found


# -- the arms ----------------------------------------------------------------------------------------------------


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


def compile_program(compiler: str, arm: Arm, folder: Path, real: str, tolerance: float) -> Built:
    """The answer in a file of its own: including the header twice shows that it may stand in several."""
    write_cpp_header(arm, folder / "arm.hpp")
    defines = [f"-DREAL={real}", f"-DARM={namespace_of(arm.name)}", f"-DTOLERANCE={tolerance}"]
    common = [compiler, *STRICT, "-O1", *defines, f"-I{folder}", f"-I{core_headers()}"]
    for name, text in {"answer": SEPARATE, "program": PROGRAM}.items():
        (folder / f"{name}.cpp").write_text(text, encoding="utf-8")
        compile_one([*common, "-c", str(folder / f"{name}.cpp"), "-o", str(folder / f"{name}.o")])
    compile_one([compiler, *(str(folder / f"{name}.o") for name in ("answer", "program")), "-o", str(folder / "run")])
    return Built(arm, real, folder / "run", folder / "answer.o")


def compile_one(command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr


def reference(arm: Arm, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pinocchio's poses and Jacobians, one configuration at a time."""
    model = arm.pinocchio
    pairs = [model.pose_and_body_jacobian(row, arm.base, arm.tip_link) for row in theta]
    spatial = [model.spatial_jacobian(row, arm.base, arm.tip_link) for row in theta]
    return np.array([g for g, _ in pairs]), np.array(spatial), np.array([J for _, J in pairs])


# -- what it computes --------------------------------------------------------------------------------------------


PRECISIONS = {"double": (1e-12, 1e-6), "float": (1e-5, 1e-4)}
"""How close kinematics come, and to what inverse kinematics solves."""

QUICK = {("rover_arm", "float"), ("mimic", "double"), ("helical", "double")}
"""Compiling takes seconds: `make test` has each number type and each kind of joint, `make test-all` every pair."""

PAIRS = [
    pytest.param((name, real), id=f"{name}-{real}", marks=() if (name, real) in QUICK else pytest.mark.slow)
    for name in ARMS
    for real in PRECISIONS
]


@pytest.fixture(scope="module", params=PAIRS)
def built(request: pytest.FixtureRequest, compiler: str, tmp_path_factory: pytest.TempPathFactory) -> Built:
    (name, real), folder = request.param, tmp_path_factory.mktemp("arm")
    return compile_program(compiler, ARMS[name](folder), folder, real, PRECISIONS[real][1])


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
    for taboo in HEAP:
        assert taboo not in built.object_file.read_bytes()


def test_a_target_out_of_reach_is_not_converged(built: Built) -> None:
    far = np.eye(4)
    far[:3, 3] = (9.0, 0.0, 0.0)
    *_, answers, met = built(built.arm.ready[None], far[None])
    assert not met.any()
    assert built.arm.limits.contains(answers, {"double": 0.0, "float": 1e-6}[built.real]).all()


def test_every_kind_of_target_and_number_of_lanes(compiler: str, rover: Arm, tmp_path: Path) -> None:
    """A position and an approach at Pinocchio's pose; a target of another kind than was compiled is not met."""
    write_cpp_header(rover, tmp_path / "arm.hpp")
    theta = rover.random_theta(np.random.default_rng(6))
    (g,), _, _ = reference(rover, theta[None])
    p, z = (", ".join(map(repr, column.tolist())) for column in (g[:3, 3], g[:3, 2]))
    (tmp_path / "kinds.cpp").write_text(
        f"""
        #include <cstdio>
        #include "arm.hpp"
        using namespace rover_arm;
        using kind = twistarm::target_kind;
        template <kind Kind, int Lanes> void show(const twistarm::target<double>& asked) {{
            const auto found = solve_ik<Kind, Lanes>(ranges<double>(), asked, poses<double>[0]);
            std::printf("%d ", found.converged ? 1 : 0);
            for (double angle : found.theta) std::printf("%.17g ", angle);
            std::printf("\\n");
        }}
        int main() {{
            const double p[3] = {{{p}}}, direction[3] = {{{z}}}, axis[3] = {{0.0, 0.0, 1.0}};
            show<kind::position, 2>(twistarm::position_target(p));
            show<kind::position, 8>(twistarm::position_target(p));
            show<kind::approach, 2>(twistarm::approach_target(p, direction, axis));
            show<kind::approach, 4>(twistarm::approach_target(p, direction, axis));
            show<kind::approach, 2>(twistarm::position_target(p));
        }}
        """,
        encoding="utf-8",
    )
    # Four solvers in one file: unoptimised they compile in a third of the time.
    command = [compiler, *STRICT, f"-I{tmp_path}", f"-I{core_headers()}", str(tmp_path / "kinds.cpp")]
    compile_one([*command, "-o", str(tmp_path / "kinds")])
    done = subprocess.run([tmp_path / "kinds"], capture_output=True, text=True, check=True, timeout=60)
    met, answers = np.split(np.array(done.stdout.split(), float).reshape(5, 6), [1], axis=1)
    assert met[:, 0].tolist() == [1, 1, 1, 1, 0]
    reached, _, _ = reference(rover, answers[:4])
    assert np.linalg.norm(reached[:, :3, 3] - g[:3, 3], axis=1).max() < 1.1e-6
    assert np.linalg.norm(reached[2:, :3, 2] - g[:3, 2], axis=1).max() < 1.1e-6
    assert np.abs(answers[[0, 2]] - answers[[1, 3]]).max() < 1e-9


# -- what it says ------------------------------------------------------------------------------------------------


def test_names_poses_and_limits(compiler: str, tmp_path: Path) -> None:
    """Names that C++ has to be told about carefully come out as they went in."""
    names = ('a "quoted" \\ one', "%s ?? */ //", "größe\n関節")
    screws = np.column_stack([[0.0, 0, 0, 0, 0, 1], [0, 0, 0.5, 0, 1, 0], [1, 0, 0, 0, 0, 0]])
    limits = {"lower": {names[0]: -1.25}, "upper": {names[0]: 0.1}, "velocity": 2.5, "effort": {names[2]: 7.0}}
    arm = arm_from_screws(screws, np.eye(4), joints=names, limits=limits, name="*/ ü\\")
    write_cpp_header(arm, tmp_path / "arm.hpp")
    (tmp_path / "names.cpp").write_text(NAMES, encoding="utf-8")
    command = [compiler, *STRICT, f"-DARM={namespace_of(arm.name)}", f"-I{tmp_path}", f"-I{core_headers()}"]
    compile_one([*command, str(tmp_path / "names.cpp"), "-o", str(tmp_path / "names")])
    done = subprocess.run([tmp_path / "names"], capture_output=True, check=True, timeout=60)
    digest, *said = done.stdout.decode("utf-8").split("\0")[:-1]
    assert digest == digest_of(arm.kept)
    assert tuple(said[:3]) == names
    assert said[3] == "ready"
    assert np.array_equal(np.array(said[4:7], float), arm.ready)
    bounds = [getattr(arm.limits, field) for field in ("lower", "upper", "velocity", "acceleration", "effort")]
    assert np.array_equal(np.array(said[7:], float), np.concatenate(bounds))


@pytest.mark.parametrize(
    ("name", "namespace"),
    [
        ("rover_arm", "rover_arm"),
        ("UR 5", "UR_5"),
        ("__my--arm__", "my_arm"),
        ("6dof", "arm_6dof"),
        ("int", "arm_int"),
        ("std", "arm_std"),
        ("関節", "arm"),
        ("", "arm"),
    ],
)
def test_the_namespace_is_an_identifier(name: str, namespace: str) -> None:
    assert namespace_of(name) == namespace


def test_the_folder_of_the_headers() -> None:
    assert (core_headers() / "twistarm" / "twistarm.hpp").is_file()


def test_missing_headers_are_said(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(cpp_header, "__file__", str(tmp_path / "twistarm" / "cpp_header.py"))
    with pytest.raises(TwistarmError, match="the C\\+\\+ headers are missing in .*include; install twistarm again"):
        core_headers()


# -- what cannot be ----------------------------------------------------------------------------------------------


def test_without_the_core(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(engine, "core", lambda: None)
    monkeypatch.setattr(engine, "why_not", lambda: "it was not compiled; compile it")
    arm = arm_from_screws(np.eye(6)[:, 3:], np.eye(4))
    with pytest.raises(TwistarmError) as caught:
        write_cpp_header(arm, tmp_path / "arm.hpp")
    assert str(caught.value) == "a C++ header needs the compiled core: it was not compiled; compile it"
    assert not (tmp_path / "arm.hpp").exists()


def test_more_joints_than_the_core_holds(compiler: str, tmp_path: Path) -> None:
    arm = arm_from_screws(np.tile(np.eye(6)[:, 3:], 11), np.eye(4), name="snake")
    with pytest.raises(TwistarmError, match="its chains have at most 32 joints; snake has 33"):
        write_cpp_header(arm, tmp_path / "arm.hpp")


def test_another_name_is_refused(rover: Arm, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a C\+\+ header is named \*\.hpp, .*; got .*arm\.urdf"):
        write_cpp_header(rover, tmp_path / "arm.urdf")


# -- the command -------------------------------------------------------------------------------------------------


def test_the_command_names_the_folder(compiler: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "arm.hpp"
    assert run(["bake", "rover_arm", "-o", str(path)]) == 0
    said = capsys.readouterr().out
    assert said == f"{path}: rover_arm as namespace rover_arm; compile with -std=c++17 -I {core_headers()}\n"
    assert [file.name for file in tmp_path.iterdir()] == ["arm.hpp"]
    assert run(["bake", "rover_arm", "-o", str(path)]) == 2
    assert "exists; --force replaces it" in capsys.readouterr().err
    baked = tmp_path / "arm.json"
    assert run(["bake", "rover_arm", "-o", str(baked), "-o", str(path), "--force", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["written"] == [str(baked), str(path)]
    assert answer["include"] == str(core_headers())
    assert answer["digest"] in path.read_text("utf-8")
    assert answer["digest"] == json.loads(baked.read_text("utf-8"))["digest"]
