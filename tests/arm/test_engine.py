"""The compiled core and the exponentials against Pinocchio on every arm, and what is said where the core is missing."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tarfile
import threading
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import twistarm
from needed import COMPILER, absent
from twistarm import poe, screws
from twistarm.arm import engine
from twistarm.cli.application import run

ROOT = Path(__file__).parents[2]
TOL = 1e-13


@pytest.fixture(scope="module")
def core() -> ModuleType:
    """The compiled core; it may be missing only where nothing could have compiled it."""
    module = engine.core()
    if module is None:
        (pytest.fail if COMPILER else absent)(engine.why_not())
    return module


@pytest.fixture
def fresh() -> Iterator[None]:
    """The core is looked for again, before and after."""
    for remembered in (engine._found, engine._say_once):
        remembered.cache_clear()
    yield
    for remembered in (engine._found, engine._say_once):
        remembered.cache_clear()


def chains(core: ModuleType, arm: twistarm.Arm) -> list[Any]:
    """One for every instruction set of this processor."""
    return [made(core, arm, name) for name in core.instruction_sets()]


def made(core: ModuleType, arm: twistarm.Arm, name: str = "", **change: Any) -> Any:
    """The chain of an arm, with some of its arguments changed."""
    lower, upper = arm.sampling_bounds
    arguments = {
        "screws": np.ascontiguousarray(arm.screws),
        "home": arm.home,
        "coupling": arm.coupling.A,
        "lower": arm.limits.lower,
        "upper": arm.limits.upper,
        "start_lower": lower,
        "start_upper": upper,
        "reach": arm.reach,
    }
    return core.Chain(**(arguments | change), instruction_set=name)


def test_every_arm_on_every_instruction_set(core: ModuleType, catalogue_arm: twistarm.Arm) -> None:
    """19 configurations: two full rounds of eight lanes and a part of one."""
    arm = catalogue_arm
    theta = arm.random_theta(np.random.default_rng(1), 19)
    g, spatial, J = arm.by_pinocchio(theta)
    for chain in chains(core, arm):
        pose, body = chain.fk_and_body_jacobian(theta)
        assert np.abs(pose - g).max() < TOL, chain.instruction_set
        assert np.abs(body - J).max() < TOL
        assert np.abs(chain.fk(theta) - g).max() < TOL
        assert np.abs(chain.body_jacobian(theta) - J).max() < TOL
        assert np.abs(chain.spatial_jacobian(theta) - spatial).max() < TOL


def test_helical_and_slow_joints(core: ModuleType) -> None:
    """Pitch and a twist of length 2, against the matrix exponential of the hatted twist."""
    from scipy.linalg import expm

    screws = np.array([[0.1, 0.0, 0.05, 0.0, 0.0, 1.0], [0.2, 0.0, 0.6, 0.0, 2.0, 0.0], [0.0, 3.0, 4.0, 0, 0, 0]]).T
    home = np.eye(4)
    home[:3, 3] = (0.4, -0.2, 0.3)
    theta = np.array([0.7, -1.1, 0.25])
    expected = np.eye(4)
    for xi, x in zip(screws.T, theta, strict=True):
        expected = expected @ expm(twistarm.screws.hat(xi) * x)
    for chain in chains(core, twistarm.arm_from_screws(screws, home)):
        assert np.abs(chain.fk(theta) - expected @ home).max() < TOL


def test_coupling_and_more_than_eight_joints(core: ModuleType) -> None:
    """Twelve joints follow five coordinates: the general path, against products of exponentials by the chain rule."""
    rng = np.random.default_rng(3)
    screws, A, home = rng.normal(size=(6, 12)), rng.normal(size=(12, 5)), np.eye(4)
    theta, bound = rng.normal(size=(9, 5)), np.full(5, 3.0)
    x = theta @ A.T
    spatial, body = poe.spatial_jacobian(screws, x) @ A, poe.body_jacobian(screws, home, x) @ A
    scale = np.abs(spatial).max()
    for name in core.instruction_sets():
        coupled = core.Chain(screws, home, A, -bound, bound, -bound, bound, 1.0, instruction_set=name)
        assert np.abs(coupled.fk(theta) - poe.fk(screws, home, x)).max() < TOL * scale
        assert np.abs(coupled.spatial_jacobian(theta) - spatial).max() < 10 * TOL * scale
        assert np.abs(coupled.body_jacobian(theta) - body).max() < 10 * TOL * scale


@pytest.mark.usefixtures("core")
def test_every_arm_of_up_to_64_joints_is_compiled(catalogue_arm: twistarm.Arm) -> None:
    def snake(n: int) -> twistarm.Arm:
        axes = [twistarm.joints.revolute([i % 2, 1 - i % 2, 0], [0, 0, 0.1 * i]) for i in range(n)]
        return twistarm.arm_from_screws(np.hstack(axes), np.eye(4))

    assert catalogue_arm.compiled is not None
    assert snake(65).compiled is None
    for arm in (snake(33), snake(64)):
        g = arm.by_exponentials(np.full(arm.n, 0.1))[0]
        assert np.abs(arm.by_exponentials(twistarm.solve_ik(arm, g, np.zeros(arm.n)).require())[0] - g).max() < 1e-5


def test_one_alone_gets_the_bits_it_gets_among_others(core: ModuleType, catalogue_arm: twistarm.Arm) -> None:
    theta = catalogue_arm.random_theta(np.random.default_rng(5), 11)
    for chain in chains(core, catalogue_arm):
        assert (chain.fk(theta) == np.stack([chain.fk(row) for row in theta])).all()


@pytest.mark.parametrize("size", [1e-300, 1e-9, np.pi / 4, np.pi / 2, 9999.0, 10001.0, 1e15])
def test_any_angle(core: ModuleType, size: float) -> None:
    """Near every switch of the sine: small, the quarters' edges, and where libm takes over."""
    angles = np.concatenate([size * (1 + np.arange(-4, 5) * 1e-15), -size * (1 + np.arange(-4, 5) * 1e-15)])
    about_z = twistarm.arm_from_screws([[0.0], [0.0], [0.0], [0.0], [0.0], [1.0]], np.eye(4))
    for chain in chains(core, about_z):
        g = chain.fk(angles[:, None])
        assert np.abs(g[:, 0, 0] - np.cos(angles)).max() < 1e-15
        assert np.abs(g[:, 1, 0] - np.sin(angles)).max() < min(1e-15, 1e-15 * size)
        assert np.abs(chain.fk(angles[None, :1])[0, 1, 0] - np.sin(angles[0])) < min(1e-15, 1e-15 * size)


def test_any_array_of_numbers(core: ModuleType, rover: twistarm.Arm) -> None:
    theta = rover.random_theta(np.random.default_rng(4), 10)
    g = rover.fk(theta)
    sealed = theta.copy()
    sealed.flags.writeable = False
    for same in (np.asfortranarray(theta), np.repeat(theta, 2, axis=1)[:, ::2], sealed, theta.tolist()):
        assert (rover.fk(same) == g).all()
    assert (rover.fk(theta.astype(">f8")) == g).all()
    assert np.abs(rover.fk(theta.astype(np.float32)) - g).max() < 1e-6
    assert rover.fk(np.zeros(rover.n, int)).tolist() == rover.fk(np.zeros(rover.n)).tolist()
    assert rover.fk(theta.reshape(2, 5, 5)).tolist() == g.reshape(2, 5, 4, 4).tolist()
    assert rover.fk(theta[:0]).shape == (0, 4, 4)
    assert rover.body_jacobian(theta[:0]).shape == (0, 6, rover.n)


@pytest.mark.parametrize("theta", [[0.0] * 5, np.zeros(4), np.zeros((2, 3, 5)), np.zeros(5, np.float32), 1.0, None, "a",
                                   np.array([0, 0, np.nan, 0, 0]), np.array([0, 0, 0, 0, np.inf])])  # fmt: skip
def test_what_is_not_plain_is_left_to_python(core: ModuleType, rover: twistarm.Arm, theta: Any) -> None:
    chain = made(core, rover)
    for kernel in (chain.fk, chain.spatial_jacobian, chain.body_jacobian, chain.fk_and_body_jacobian):
        assert kernel(theta) is None


def test_a_batch_lets_other_threads_run(core: ModuleType, rover: twistarm.Arm) -> None:
    """No thread is made to give way, so `start` returns while the batch runs only if the batch gives way itself."""
    chain = made(core, rover)
    theta = np.tile(rover.ready, (1_000_000, 1))
    thread = threading.Thread(target=chain.fk, args=(theta,))
    interval = sys.getswitchinterval()
    sys.setswitchinterval(60.0)
    try:
        thread.start()
        running = thread.is_alive()
        thread.join()
    finally:
        sys.setswitchinterval(interval)
    assert running


@pytest.mark.usefixtures("fresh")
def test_where_it_was_not_built(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setitem(sys.modules, "twistarm._core", None)
    assert engine.core() is None
    assert engine.instruction_set() == ""
    assert "get a C++17 compiler" in engine.why_not()
    assert run(["info", "rover_arm"]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert f"engine: NumPy; no compiled core: {engine.why_not()}" in shown
    assert len([record for record in caplog.records if engine.why_not() in record.getMessage()]) == 1
    assert run(["info", "rover_arm", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert (answer["engine"], answer["core"]) == ("NumPy", None)


@pytest.mark.usefixtures("fresh")
def test_where_it_cannot_be_loaded(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delitem(sys.modules, "twistarm._core", raising=False)
    broken = ImportError("libstdc++.so.6: version `GLIBCXX_3.4.30' not found")
    monkeypatch.setattr(engine.importlib, "import_module", lambda name: (_ for _ in ()).throw(broken))
    assert engine.core() is None
    assert engine.why_not().startswith(f"twistarm._core cannot be loaded ({broken}); pip install --force-reinstall")


@pytest.mark.usefixtures("fresh")
def test_one_of_other_sources_is_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    old = ModuleType("twistarm._core")
    monkeypatch.setitem(sys.modules, "twistarm._core", old)
    assert engine.core() is None
    words = f"was built from other sources (interface None, needed {engine.INTERFACE}); pip install"
    assert words in engine.why_not()


@pytest.mark.slow
@pytest.mark.parametrize("lacking", ["a compiler that works", "any compiler"])
def test_without_a_compiler_the_installation_is_pure_python(lacking: str, tmp_path: Path) -> None:
    """From the source distribution, as the registry's users get it; pip fetches the build's own requirements."""
    environment = {name: value for name, value in os.environ.items() if name not in ("CC", "CXX")}
    if lacking == "any compiler":
        environment["PATH"] = str(tmp_path)
    else:
        environment["CXX"] = str(shutil.which("false"))
    command = [sys.executable, "-m", "build", "--outdir", str(tmp_path / "dist"), str(ROOT)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    (wheel,), (source,) = (tmp_path / "dist").glob("*.whl"), (tmp_path / "dist").glob("*.tar.gz")
    with tarfile.open(source) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert {"core/CMakeLists.txt", "core/bindings/module.cpp", "core/include/twistarm/kinematics/chain.hpp"} <= names
    assert wheel.name.endswith("-py3-none-any.whl")
    target = tmp_path / "site"
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", str(target), str(wheel)]
    subprocess.run(command, check=True, capture_output=True, timeout=300)
    # -S: without `site`, because the import hook of an editable installation would answer before any path.
    environment["PYTHONPATH"] = os.pathsep.join([str(target), *filter(None, sys.path)])
    program = (
        "import twistarm; from twistarm.arm import engine; "
        "print(twistarm.__file__, engine.core(), twistarm.load_arm('rover_arm').n, engine.why_not())"
    )
    command = [sys.executable, "-S", "-c", program]
    done = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(str(target))
    assert " None 5 twistarm was installed where it could not be compiled" in done.stdout


POSE_TOL = 1e-12  # Double precision over some ten joints.

SAMPLES = 50


def raw_q(model: pin.Model, values: dict[str, float]) -> np.ndarray:
    """Pinocchio's own configuration: continuous joints as (cos, sin)."""
    q = pin.neutral(model)
    for name, value in values.items():
        j = model.getJointId(name)
        i = model.idx_qs[j]
        if model.nqs[j] == 2:
            q[i : i + 2] = np.cos(value), np.sin(value)
        else:
            q[i] = value
    return q


def joint_values(arm: twistarm.Arm, theta: np.ndarray) -> dict[str, float]:
    """Every moving joint's value from theta, masters outside the chain at 0, by the mimic elements themselves."""
    assert arm.description is not None
    known = dict(zip(arm.joint_names, theta, strict=True))

    def value(name: str) -> float:
        mimic = arm.description.joints[name].mimic
        return known.get(name, 0.0) if mimic is None else mimic.multiplier * value(mimic.joint) + mimic.offset

    return {name: value(name) for name, joint in arm.description.joints.items() if joint.moving}


def compare(arm: twistarm.Arm, text: str) -> None:
    """Product of exponentials, and what `arm` answers, against a model made from `text` alone."""
    model = pin.buildModelFromXML(text)
    data = model.createData()
    base, tip = (model.getFrameId(link, pin.FrameType.BODY) for link in (arm.base, arm.tip_link))
    A = arm.coupling.A
    for theta in arm.random_theta(np.random.default_rng(11), SAMPLES):
        q = raw_q(model, joint_values(arm, theta))
        pin.computeJointJacobians(model, data, q)
        pin.framesForwardKinematics(model, data, q)
        expected = (data.oMf[base].inverse() * data.oMf[tip]).homogeneous
        assert np.abs(poe.fk(arm.screws, arm.home, A @ theta) - expected).max() <= POSE_TOL
        assert np.abs(arm.fk(theta) - expected).max() <= POSE_TOL
        columns = [model.idx_vs[model.getJointId(joint.name)] for joint in chain(arm)]
        local = pin.getFrameJacobian(model, data, tip, pin.ReferenceFrame.LOCAL)[:, columns] @ A
        world = pin.getFrameJacobian(model, data, tip, pin.ReferenceFrame.WORLD)[:, columns] @ A
        spatial = data.oMf[base].toActionMatrixInverse() @ world
        assert np.abs(poe.body_jacobian(arm.screws, arm.home, A @ theta) @ A - local).max() <= POSE_TOL
        assert np.abs(poe.spatial_jacobian(arm.screws, A @ theta) @ A - spatial).max() <= POSE_TOL
        assert np.abs(arm.body_jacobian(theta) - local).max() <= POSE_TOL
        assert np.abs(arm.spatial_jacobian(theta) - spatial).max() <= POSE_TOL
        assert np.abs(screws.adjoint(arm.fk(theta)) @ local - spatial).max() <= POSE_TOL


def chain(arm: twistarm.Arm) -> list[twistarm.description.tree.Joint]:
    assert arm.description is not None
    return [joint for joint in arm.description.chain(arm.base, arm.tip_link) if joint.moving]


def test_catalogue_arms_equal_pinocchio_on_the_raw_urdf(catalogue_arm: twistarm.Arm) -> None:
    assert catalogue_arm.description is not None
    compare(catalogue_arm, catalogue_arm.description.text)
