"""The wheel's module is loaded whatever stands before it; where that cannot be, one line says why and what to do."""

from __future__ import annotations

import importlib
import os
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from stub_packages import metadata, package
from twistarm.support import shared_libraries, wheels
from twistarm.support.errors import TwistarmError
from twistarm.support.wheels import Wheel

ENGINE = Wheel("shadow_engine", "shadow-engine-wheel", needs=("solve", "parts.bolt"), oldest="2.0")
GOOD = "def solve(): return 42\n"


def engine(folder: Path, version: str = "2.1", text: str = GOOD) -> Path:
    """A folder in which pip has installed the engine."""
    package(folder, "shadow_engine", f"__version__ = {version!r}\n{text}", parts="bolt = 1\n")
    metadata(folder, "shadow-engine-wheel", version, ("shadow_engine/__init__.py",))
    return folder


@pytest.fixture(autouse=True)
def _engines_forgotten() -> Iterator[None]:
    yield
    for name in [name for name in sys.modules if name.split(".")[0] in ("shadow_engine", "shadow_companion")]:
        del sys.modules[name]


@pytest.fixture
def path(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """sys.path and the shell's variables, as they were afterwards."""
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.delenv("PYTHONPATH", raising=False)
    monkeypatch.delenv(shared_libraries.SEARCHED_FIRST, raising=False)
    return monkeypatch


def put(path: pytest.MonkeyPatch, *folders: Path) -> list[str]:
    """`folders` stand on PYTHONPATH, in this order."""
    path.setenv("PYTHONPATH", os.pathsep.join(map(str, folders)))
    sys.path[:0] = map(str, folders)
    importlib.invalidate_caches()
    return list(sys.path)


def refused(wheel: Wheel = ENGINE) -> str:
    with pytest.raises(TwistarmError) as refusal:
        wheels.load(wheel)
    assert "\n" not in str(refusal.value)
    return str(refusal.value)


# Which of several modules


def test_of_several_the_one_that_pip_installed(path: pytest.MonkeyPatch, tmp_path: Path) -> None:
    foreign = package(tmp_path / "ros", "shadow_engine", "raise RuntimeError('built for another Python')\n")
    before = put(path, foreign, engine(tmp_path / "site"))
    module = wheels.load(ENGINE)
    assert module.__file__ == str(tmp_path / "site" / "shadow_engine" / "__init__.py")
    assert module.solve() == 42
    assert sys.path == before


def test_companions_come_from_the_same_folder(path: pytest.MonkeyPatch, tmp_path: Path) -> None:
    foreign = package(tmp_path / "ros", "shadow_companion", "raise ImportError('foreign companion')\n")
    own = engine(tmp_path / "site", text=GOOD + "import shadow_companion\n")
    put(path, foreign, package(own, "shadow_companion", ""))
    assert wheels.load(ENGINE).shadow_companion.__file__.startswith(str(own))


def test_metadata_without_a_record_is_no_wheel(path: pytest.MonkeyPatch, tmp_path: Path) -> None:
    foreign = package(tmp_path / "ros", "shadow_engine", "raise RuntimeError\n")
    egg = foreign / "shadow_engine_wheel-2.7-py3.12.egg-info"
    egg.mkdir()
    (egg / "PKG-INFO").write_text("Metadata-Version: 2.1\nName: shadow-engine-wheel\nVersion: 2.7\n")
    (egg / "SOURCES.txt").write_text("shadow_engine/__init__.py\n")
    put(path, foreign, engine(tmp_path / "site"))
    assert wheels.load(ENGINE).solve() == 42


def test_an_older_wheel_is_passed_over(path: pytest.MonkeyPatch, tmp_path: Path) -> None:
    put(path, engine(tmp_path / "old", "1.9"), engine(tmp_path / "new", "2.10.1"))
    assert wheels.load(ENGINE).__version__ == "2.10.1"


def test_without_a_wheel_the_first_on_the_path(path: pytest.MonkeyPatch, tmp_path: Path) -> None:
    first = package(tmp_path / "first", "shadow_engine", GOOD, parts="bolt = 1\n")
    put(path, first, package(tmp_path / "second", "shadow_engine", "raise RuntimeError\n"))
    assert wheels.load(ENGINE).__file__.startswith(str(first))


def test_where_there_is_no_choice_no_metadata_is_read(path: pytest.MonkeyPatch, tmp_path: Path) -> None:
    put(path, engine(tmp_path / "site"))
    path.setattr(wheels, "_installed", lambda wheel: pytest.fail("40 ms for nothing"))
    assert wheels.load(ENGINE).solve() == 42
    assert wheels.load(ENGINE) is sys.modules["shadow_engine"]


def test_threads_get_one_module_and_leave_the_path(path: pytest.MonkeyPatch, tmp_path: Path) -> None:
    foreign = package(tmp_path / "ros", "shadow_engine", "raise RuntimeError\n")
    before = put(path, foreign, engine(tmp_path / "site", text=GOOD + "import time; time.sleep(0.05)\n"))
    modules: list[object] = []
    threads = [threading.Thread(target=lambda: modules.append(wheels.load(ENGINE))) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(modules) == 8
    assert len(set(map(id, modules))) == 1
    assert sys.path == before


# Imported already


def test_one_imported_already_serves_if_it_can(path: pytest.MonkeyPatch, tmp_path: Path) -> None:
    foreign = package(tmp_path / "ros", "shadow_engine", "__version__ = '2.0.3'\n" + GOOD, parts="bolt = 1\n")
    put(path, foreign, engine(tmp_path / "site"))
    early = importlib.import_module("shadow_engine")
    assert wheels.load(ENGINE) is early


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("__version__ = '1.9.7'\n" + GOOD, "is version 1.9.7, and twistarm needs 2.0"),
        ("__version__ = '2.5'\n", "has no solve: it is another project, or another version"),
        (GOOD, "has no parts.bolt: it is another project, or another version"),
    ],
)
def test_one_imported_already_that_cannot_serve(
    path: pytest.MonkeyPatch, tmp_path: Path, text: str, fault: str
) -> None:
    foreign = package(tmp_path / "ros", "shadow_engine", text)
    put(path, foreign, engine(tmp_path / "site"))
    early = importlib.import_module("shadow_engine")
    assert refused() == (
        f"shadow_engine at {foreign}/shadow_engine/__init__.py {fault}; imported before "
        f"{tmp_path}/site/shadow_engine/__init__.py: load an arm before that import, or start with "
        "env -u PYTHONPATH python …"
    )
    assert sys.modules["shadow_engine"] is early


def test_another_project_of_that_name_imported_already(path: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """What the registry keeps under the module's own name lies in site-packages: no variable to unset."""
    namesake = package(tmp_path / "namesake", "shadow_engine", "")
    metadata(namesake, "shadow_engine", "0.4.3", ("shadow_engine/__init__.py",))
    put(path, namesake, engine(tmp_path / "site"))
    path.delenv("PYTHONPATH")
    importlib.import_module("shadow_engine")
    assert refused().endswith("or pip uninstall shadow_engine")


# Nothing that serves


def test_not_installed(path: pytest.MonkeyPatch) -> None:
    assert refused() == "shadow_engine is not installed; pip install 'shadow-engine-wheel>=2.0'"


def test_only_another_project_of_that_name(path: pytest.MonkeyPatch, tmp_path: Path) -> None:
    namesake = package(tmp_path, "shadow_engine", "")
    metadata(namesake, "shadow_engine", "0.4.3", ("shadow_engine/__init__.py",))
    put(path, namesake)
    assert refused() == (
        f"shadow_engine at {tmp_path}/shadow_engine/__init__.py has no solve: it is another project, or another "
        "version; pip uninstall shadow_engine, then pip install 'shadow-engine-wheel>=2.0'"
    )


def test_only_an_old_wheel(path: pytest.MonkeyPatch, tmp_path: Path) -> None:
    put(path, engine(tmp_path, "1.9"))
    assert refused() == (
        f"shadow_engine at {tmp_path}/shadow_engine/__init__.py is version 1.9, and twistarm needs 2.0; "
        "pip install 'shadow-engine-wheel>=2.0'"
    )


def test_only_a_foreign_one_that_cannot_be_imported(path: pytest.MonkeyPatch, tmp_path: Path) -> None:
    put(path, package(tmp_path, "shadow_engine", "raise ImportError('undefined\\nsymbol')\n"))
    assert refused() == (
        f"shadow_engine at {tmp_path}/shadow_engine/__init__.py cannot be imported (undefined symbol); "
        "pip install 'shadow-engine-wheel>=2.0'"
    )


def test_a_damaged_wheel(path: pytest.MonkeyPatch, tmp_path: Path) -> None:
    before = put(path, engine(tmp_path, text="raise KeyError\n"))
    assert refused().endswith("cannot be imported (KeyError); pip install --force-reinstall shadow-engine-wheel")
    assert sys.path == before


def test_an_old_numpy_is_named(path: pytest.MonkeyPatch, tmp_path: Path) -> None:
    import numpy

    put(path, engine(tmp_path / "site", text="raise ImportError('numpy.core.multiarray failed to import')\n"))
    path.setattr(numpy, "__version__", "1.21.5")
    old = f"NumPy 1.21.5 at {numpy.__file__} is older than 2.0"
    assert refused().endswith(f"{old}: pip install 'numpy>=2'")
    path.setenv("PYTHONPATH", str(Path(numpy.__file__).parents[1]))
    assert refused().endswith(f"{old}: start with env -u PYTHONPATH python …")


# Shared libraries


def cmeel_engine(folder: Path, text: str = GOOD) -> Path:
    """The engine as C++ projects install it: its folder on sys.path is <prefix>/lib/python3.x/site-packages."""
    site = folder / "cmeel.prefix" / "lib" / "python3.x" / "site-packages"
    package(site, "shadow_engine", "__version__ = '2.1'\n" + text, parts="bolt = 1\n")
    metadata(folder, "shadow-engine-wheel", "2.1", (str((site / "shadow_engine/__init__.py").relative_to(folder)),))
    return site


def test_a_stranger_that_cannot_be_passed_is_named(path: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """As on macOS, where the variable goes before absolute paths."""
    site = cmeel_engine(tmp_path / "site", text="raise ImportError('undefined symbol: ENGINE_API')\n")
    for folder in (site.parents[1], tmp_path / "ros"):
        folder.mkdir(exist_ok=True)
        (folder / "libtop.so").write_bytes(b"\0")
    (site / "shadow_engine" / "extension.so").write_bytes(b"\0libtop.so\0")
    put(path, tmp_path / "site", site)
    path.setattr(sys, "platform", "darwin")
    path.setenv(shared_libraries.SEARCHED_FIRST, str(tmp_path / "ros"))
    variable = shared_libraries.SEARCHED_FIRST
    assert refused() == (
        f"shadow_engine at {site}/shadow_engine/__init__.py cannot be imported (undefined symbol: ENGINE_API); "
        f"{tmp_path}/ros/libtop.so ({variable}) stands before {site.parents[1]}/libtop.so: "
        f"start with env -u PYTHONPATH -u {variable} python …"
    )


def test_a_companion_imported_already_is_named(path: pytest.MonkeyPatch, tmp_path: Path) -> None:
    site = cmeel_engine(tmp_path / "site", text="import shadow_companion; shadow_companion.register()\n")
    package(site, "shadow_companion", "def register(): pass\n")
    foreign = package(tmp_path / "ros", "shadow_companion", "")
    put(path, foreign, tmp_path / "site", site)
    importlib.import_module("shadow_companion")
    assert refused().endswith(
        f"; {foreign}/shadow_companion/__init__.py was imported before {site}/shadow_companion/__init__.py: "
        "load an arm before that import, or start with env -u PYTHONPATH python …"
    )
