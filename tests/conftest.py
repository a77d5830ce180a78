"""What every test may use: the catalogue's arms, the real models, and Hypothesis without surprises."""

from __future__ import annotations

import functools
import gc
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import hypothesis
import pytest
import typer

import twistarm
from catalogue import expanded_once, load
from twistarm.description import urdf

hypothesis.settings.register_profile("twistarm", derandomize=True, deadline=None, max_examples=50)
hypothesis.settings.load_profile("twistarm")

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # so a shell starts what it sends to the background
    signal.signal(signal.SIGINT, signal.default_int_handler)

# What one process makes once, hundreds of tests in one need not make anew: the command line, and the texts of our arms.
typer.main.get_command = functools.cache(typer.main.get_command)
urdf.expand_xacro = expanded_once

gc.disable()


def pytest_collection_finish() -> None:
    """What was made until here stays: the garbage collector need not look at it, now or ever."""
    gc.freeze()
    gc.enable()


@pytest.fixture(scope="session", autouse=True)
def no_columns() -> Iterator[None]:
    """No width of a terminal: pytest tells its workers one, and GNU readline sets it without os.environ."""
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("COLUMNS", raising=False)
        os.unsetenv("COLUMNS")
        yield


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of the test's own, in which it runs."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def hangups() -> Iterator[None]:
    """A closed terminal has its usual effect, on what a test starts too: under nohup it would be ignored."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


@pytest.fixture(scope="session")
def models() -> Path:
    """The folder of real arm descriptions that TWISTARM_MODELS names."""
    folder = os.environ.get("TWISTARM_MODELS")
    if not folder:
        pytest.skip("TWISTARM_MODELS names no folder of real arm descriptions")
    path = Path(folder)
    if not path.is_dir():
        pytest.fail(f"TWISTARM_MODELS={folder} is not a folder")
    return path


@pytest.fixture(scope="session", params=twistarm.available_arms())
def catalogue_arm(request: pytest.FixtureRequest) -> twistarm.Arm:
    """Every arm of the catalogue in turn."""
    return load(request.param)


@pytest.fixture(scope="session")
def rover() -> twistarm.Arm:
    return load("rover_arm")
