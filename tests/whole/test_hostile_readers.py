"""Every reader of a file that somebody names, given what is no file, too large, or no honest program's."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType

import pytest

from hostile.attempt import Outcome
from hostile.readers import READERS, Case, cases
from twistarm.cli.application import run

SAMPLED = (
    *(f"{reader}: {what}" for reader in READERS for what in ("a FIFO", "a link to itself")),
    "a baked arm: 401 digits in it",
    "a golden file: 401 digits in it",
    "a golden file: 5,000 digits in it",
    "a golden file: 700 MB of nothing",
    "a golden file: a name twice",
    "a log of the wiring: a million columns",
    "a motion to play: /dev/zero",
    "a motion to play: one line of 100 MB",
    "postures: 700 MB of nothing",
    "targets: a cell of a million characters",
)


@pytest.fixture(autouse=True)
def _patience() -> Iterator[None]:
    """A reader that waits for ever fails, and does not hold up all tests."""

    def late(number: int, frame: FrameType | None) -> None:
        raise TimeoutError("it waits for ever")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(20)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


CASES = list(cases())


@pytest.mark.parametrize(
    "case", [case for case in CASES if case.name in SAMPLED and not case.reader.stdin], ids=lambda case: case.name
)
def test_a_sample_is_told_in_one_line(
    case: Case, tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    case.prepare(tmp_path)
    code = run(case.reader.arguments)
    said = capfd.readouterr()
    assert case.fault(Outcome(code, said.out, said.err, 0.0, 0.0)) == ""


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_everything_is_told_in_one_line_within_the_bounds(case: Case) -> None:
    signal.alarm(0)
    with TemporaryDirectory() as folder:  # pytest would keep gigabytes
        assert case.fault(case.attempt(Path(folder))) == ""
