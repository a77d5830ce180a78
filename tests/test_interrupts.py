"""Ctrl-C is not lost where a library swallows it."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path

import pytest

from twistarm.interrupts import interrupts_held


def swallow() -> None:
    with suppress(BaseException):
        signal.raise_signal(signal.SIGINT)


def test_it_takes_effect_at_the_end_of_the_block() -> None:
    before = signal.getsignal(signal.SIGINT)
    reached: list[str] = []

    def work() -> None:
        with interrupts_held():
            swallow()
            reached.append("the end")

    with pytest.raises(KeyboardInterrupt):
        work()
    assert reached == ["the end"]
    assert signal.getsignal(signal.SIGINT) is before


def test_a_second_one_takes_effect_at_once() -> None:
    reached: list[str] = []

    def work() -> None:
        with interrupts_held():
            swallow()
            signal.raise_signal(signal.SIGINT)
            reached.append("the end")

    with pytest.raises(KeyboardInterrupt):
        work()
    assert reached == []


def test_without_one_nothing_changes_and_errors_pass() -> None:
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(ZeroDivisionError), interrupts_held():
        _ = 1 / 0
    assert signal.getsignal(signal.SIGINT) is before


def test_a_handler_of_the_program_is_called_once() -> None:
    called: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, frame: called.append(number))
    try:
        with interrupts_held():
            swallow()
            assert called == []
        assert called == [signal.SIGINT]
    finally:
        signal.signal(signal.SIGINT, before)


def test_in_another_thread_signals_are_left_alone() -> None:
    seen: list[bool] = []
    before = signal.getsignal(signal.SIGINT)

    def look() -> None:
        with interrupts_held():
            seen.append(signal.getsignal(signal.SIGINT) is before)

    thread = threading.Thread(target=look)
    thread.start()
    thread.join()
    assert seen == [True]


PROGRAM = """
import signal, sys
class Pressed:
    def find_spec(self, name, path=None, target=None):
        if name == "networkx":
            sys.meta_path.remove(self)
            signal.raise_signal(signal.SIGINT)
from pathlib import Path
from twistarm.viewer.meshes import load_parts
sys.meta_path.insert(0, Pressed())
try:
    load_parts(Path(sys.argv[1]))
except KeyboardInterrupt:
    import trimesh.graph
    print("interrupted", getattr(trimesh.graph.nx, "__name__", "networkx is lost"))
"""


def test_ctrl_c_while_the_mesh_reader_is_imported_ends_the_call_and_breaks_no_import(tmp_path: Path) -> None:
    mesh = tmp_path / "a.stl"
    mesh.write_text("solid a\nendsolid a\n")
    done = subprocess.run([sys.executable, "-c", PROGRAM, str(mesh)], capture_output=True, text=True, timeout=60)
    assert done.stdout == "interrupted networkx\n", done.stderr
