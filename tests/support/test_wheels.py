"""A module that cannot serve is refused in one line, with its file and a remedy that works."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from stub_packages import package
from twistarm.support import wheels
from twistarm.support.errors import TwistarmError
from twistarm.support.wheels import Wheel

ENGINE = Wheel("shadow_engine", "shadow-engine-wheel", has="solve", oldest="2.0")
GOOD = "def solve(): return 42\n"
INSTALL = "pip install 'shadow-engine-wheel>=2.0'"


@pytest.fixture(autouse=True)
def _engines_forgotten(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    for name in wheels._PATHS:
        monkeypatch.delenv(name, raising=False)
    yield
    sys.modules.pop(ENGINE.module, None)


def put(path: pytest.MonkeyPatch, folder: Path, text: str) -> str:
    """The file of an engine that stands first on sys.path."""
    path.syspath_prepend(package(folder, ENGINE.module, text))
    return f"shadow_engine at {folder}/shadow_engine/__init__.py"


def refused() -> str:
    with pytest.raises(TwistarmError) as refusal:
        wheels.load(ENGINE)
    return str(refusal.value)


@pytest.mark.parametrize("version", ["2.0", "2.10.1"])
def test_one_that_is_new_enough_serves(version: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    put(monkeypatch, tmp_path, f"__version__ = {version!r}\n{GOOD}")
    assert wheels.load(ENGINE).solve() == 42


def test_one_that_is_nowhere_is_to_be_installed() -> None:
    assert refused() == f"shadow_engine is not installed; {INSTALL}"


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (f"__version__ = '1.9.7'\n{GOOD}", "is version 1.9.7, and twistarm needs 2.0"),
        ("__version__ = '2.5'\n", "has no solve: it is another project"),
        ("raise ImportError('undefined\\nsymbol')\n", "cannot be imported (undefined symbol)"),
        ("raise KeyError\n", "cannot be imported (KeyError)"),
    ],
)
def test_one_that_cannot_serve_is_named(text: str, fault: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    engine = put(monkeypatch, tmp_path, text)
    assert refused() == f"{engine} {fault}; pip uninstall shadow_engine, then {INSTALL}"
    monkeypatch.setenv("PYTHONPATH", "/opt/ros")
    monkeypatch.setenv("LD_LIBRARY_PATH", "/opt/ros/lib")
    assert f"{fault}; start with env -u PYTHONPATH -u LD_LIBRARY_PATH twistarm …, or pip" in refused()
