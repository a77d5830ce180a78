"""twistarm answers the same inside a sourced ROS shell, or says in one line what stands before what."""

from __future__ import annotations

import ast
import inspect
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from stub_packages import metadata, package
from twistarm.description.expansion import module as xacro_module
from twistarm.model import pinocchio_model
from twistarm.support import shared_libraries

PROJECT = Path(__file__).parents[2]
COMMAND = "import sys; sys.argv[0] = 'twistarm'; from twistarm.cli import main; main()"
FK = ("fk", "rover_arm", "--theta", "zero", "--json")


def run(*arguments: str, program: str = COMMAND, **shell: str) -> subprocess.CompletedProcess[str]:
    """twistarm in a fresh interpreter, with the shell's variables."""
    environment = {name: value for name, value in os.environ.items() if name != shared_libraries.SEARCHED_FIRST}
    if "PYTHONPATH" in shell:
        shell["PYTHONPATH"] = os.pathsep.join(filter(None, [shell["PYTHONPATH"], environment.get("PYTHONPATH")]))
    return subprocess.run(
        [sys.executable, "-c", program, *arguments],
        capture_output=True,
        text=True,
        timeout=60,
        env=environment | shell,
        check=False,
    )


@pytest.fixture(scope="module")
def undisturbed() -> object:
    done = run(*FK)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def the_same(done: subprocess.CompletedProcess[str], undisturbed: object) -> None:
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout) == undisturbed


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        "raise ImportError('libboost_python310.so.1.74.0: cannot open shared object file')\n",
        "raise SystemError('compiled for another Python')\n",
        "",
        "__version__ = '2.6.4'\ndef buildModelFromXML(text): raise SystemError\n",
    ],
    ids=["no library", "other Python", "another project", "old"],
)
def test_a_foreign_pinocchio(tmp_path: Path, undisturbed: object, text: str) -> None:
    foreign = package(tmp_path, "pinocchio", text)
    for companion in ("eigenpy", "coal", "hppfcl"):
        package(tmp_path, companion, "raise ImportError('foreign')\n")
    the_same(run(*FK, PYTHONPATH=str(foreign)), undisturbed)


@pytest.mark.slow
def test_the_registrys_pinocchio(tmp_path: Path, undisturbed: object) -> None:
    namesake = package(tmp_path, "pinocchio", "", plugin="")
    metadata(namesake, "pinocchio", "0.4.3", ("pinocchio/__init__.py", "pinocchio/plugin.py"))
    the_same(run(*FK, PYTHONPATH=str(namesake)), undisturbed)


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        "from ament_index_python.packages import get_package_share_directory\n",
        "from roslaunch import substitution_args\n",
    ],
    ids=["ROS 2", "ROS 1"],
)
def test_a_foreign_xacro(tmp_path: Path, undisturbed: object, text: str) -> None:
    the_same(run(*FK, PYTHONPATH=str(package(tmp_path, "xacro", text))), undisturbed)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "darwin", reason="macOS puts DYLD_LIBRARY_PATH before absolute paths")
def test_foreign_libraries(tmp_path: Path, undisturbed: object) -> None:
    import pinocchio

    linked = shared_libraries._linked(Path(pinocchio.__file__))
    unrelated = next(file for file in linked if "qhull" in file.name)
    for file in linked:
        shutil.copy(unrelated, tmp_path / file.name)
    for name in ("libeigenpy.so", "libcoal.so", "libpinocchio_default.so"):
        assert (tmp_path / name).exists()
    shell = {shared_libraries.SEARCHED_FIRST: str(tmp_path)}
    assert "undefined symbol" in run(program="import pinocchio", **shell).stderr
    the_same(run(*FK, **shell), undisturbed)


def test_a_whole_ros_shell(tmp_path: Path, undisturbed: object) -> None:
    import pinocchio

    foreign = package(tmp_path, "pinocchio", "raise ImportError\n")
    package(foreign, "xacro", "import ament_index_python\n")
    shutil.copy(next(iter(shared_libraries._linked(Path(pinocchio.__file__)))), tmp_path / "libeigenpy.so")
    the_same(run(*FK, PYTHONPATH=str(foreign), LD_LIBRARY_PATH=str(tmp_path)), undisturbed)


def test_a_numpy_of_the_first_series(tmp_path: Path, undisturbed: object) -> None:
    """The wheels are built for NumPy 2 and run with 1.x as well."""
    import numpy

    text = f"__path__ = [{os.path.dirname(numpy.__file__)!r}]\n__file__ = __path__[0] + '/__init__.py'\n"
    text += "exec(compile(open(__file__).read(), __file__, 'exec'))\n__version__ = '1.26.4'\n"
    foreign = package(tmp_path, "numpy", text)
    assert run(program="import numpy; print(numpy.__version__)", PYTHONPATH=str(foreign)).stdout == "1.26.4\n"
    the_same(run(*FK, PYTHONPATH=str(foreign)), undisturbed)


@pytest.mark.parametrize("name", ["pinocchio", "xacro"])
def test_a_foreign_one_imported_by_the_program(tmp_path: Path, name: str) -> None:
    foreign = package(tmp_path, name, "")
    done = run(*FK, program=f"import {name}; {COMMAND}", PYTHONPATH=str(foreign))
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert done.stderr.startswith(f"error: {name} at {foreign}/{name}/__init__.py has no ")
    assert done.stderr.endswith(": load an arm before that import, or start with env -u PYTHONPATH twistarm …\n")


def test_ros_2s_xacro_imported_by_the_program_serves(tmp_path: Path, undisturbed: object) -> None:
    """It is the registry's code, at another place."""
    import xacro

    shutil.copytree(Path(xacro.__file__).parent, tmp_path / "xacro")
    program = f"import xacro; assert xacro.__file__.startswith({str(tmp_path)!r}); {COMMAND}"
    the_same(run(*FK, program=program, PYTHONPATH=str(tmp_path)), undisturbed)


def test_the_versions_are_those_of_the_installation() -> None:
    text = (PROJECT / "pyproject.toml").read_text()
    for wheel in (pinocchio_model._WHEEL, xacro_module._WHEEL):
        assert f'"{wheel.distribution}>={wheel.oldest}"' in text


def test_whatever_the_model_uses_is_asked_for() -> None:
    tree = ast.parse(inspect.getsource(pinocchio_model))
    used = {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and ast.unparse(node.value) in ("self._pin", "pin")
    }
    assert "buildModelFromXML" in used
    assert used <= set(pinocchio_model._WHEEL.needs)
