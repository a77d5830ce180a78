"""Descriptions that ask for much work: each is loaded or refused within seconds and megabytes, and Ctrl-C ends it."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from hostile.attempt import SECONDS, attempt
from hostile.descriptions import CASES
from hostile.texts import Case
from twistarm import load_arm
from twistarm.support.errors import DescriptionError

SAMPLE = (
    *("100,000 comments before a property", "a comment of 9 MB included 200 times"),
    *("a comprehension over dots", "properties set in 280 macros"),
    *("100,000 attributes on a joint of a URDF", "a name of 9 MB", "5,000 collisions on a link"),
    *("20,000 links side by side", "240 mimics of one joint", "3,000 joints with words unread"),
    *("200 manifests of 1 MB, the name at the end", "links in circles"),
)

PROMPT, HANGS = 1.0, 60.0
"""Seconds within which Ctrl-C ends a command, and after which it counts as stuck."""


def judged(case: Case, code: int | None, errors: str) -> str:
    """What is wrong with how a command ended; empty if nothing."""
    if case.refusal:
        refused = code == 2 and re.search(case.refusal, errors) is not None
        return "" if refused else f"not refused as {case.refusal!r}: {code} {errors[:200]}"
    return "" if code == 0 else f"not loaded: {code} {errors[:200]}"


@pytest.mark.parametrize("name", SAMPLE)
def test_much_work_is_done_or_refused_soon(name: str, tmp_path: Path) -> None:
    case = CASES[name]
    file, *options = case.write(tmp_path)
    folders = [tmp_path / options[1]] if options else []
    start, code, told = time.process_time(), 0, ""
    try:
        assert load_arm(tmp_path / file, package_dirs=folders).ready.shape == (2,)
    except DescriptionError as error:
        code, told = 2, str(error)
    assert time.process_time() - start < SECONDS
    assert not judged(case, code, told)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_every_description_that_asks_for_much_work(name: str, tmp_path: Path) -> None:
    outcome = attempt("info", *CASES[name].write(tmp_path), folder=tmp_path)
    assert not outcome.within()
    assert not judged(CASES[name], outcome.code, outcome.errors)


INTERRUPTED = {
    "info": (
        *("a comment of 9 MB", "50,000 look-ups through 280 macros", "10,000 files by a wildcard"),
        *("100,000 attributes on a joint of a URDF", "3,900 links in chains of 50", "100 joints in a chain"),
        "the whole disk",
    ),
    "doctor": ("3,900 links in chains of 50", "100 joints in a chain"),
    "check": ("100 joints in a chain",),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "name"), [(command, name) for command in INTERRUPTED for name in INTERRUPTED[command]]
)
def test_ctrl_c_ends_it_at_any_moment(command: str, name: str, tmp_path: Path) -> None:
    arguments = (command, *CASES[name].write(tmp_path))
    whole = attempt(*arguments, folder=tmp_path).seconds
    for share in (0.5, 0.65, 0.8, 0.95):
        assert any(_interrupted(arguments, tmp_path, share * whole) < PROMPT for _ in range(3)), share


def _interrupted(arguments: tuple[str, ...], folder: Path, after: float) -> float:
    """Seconds from a Ctrl-C to the end of `twistarm arguments`."""
    process = subprocess.Popen(
        [sys.executable, "-m", "twistarm", *arguments],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "COLUMNS": "80"},
    )
    try:
        time.sleep(after)
        began = time.monotonic()
        process.send_signal(signal.SIGINT)
        process.wait(HANGS)
        return time.monotonic() - began
    finally:
        process.kill()
