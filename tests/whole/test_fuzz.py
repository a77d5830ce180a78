"""Thousands of mutants of real descriptions: each is refused in one line or loaded and right; and the fuzzer itself."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable
from pathlib import Path, PurePath
from random import Random

import pytest

from fuzz import mutations, oracle, runner
from fuzz.runner import Campaign, campaign, verdicts
from fuzz.sources import Source, catalogue_sources, own_sources, real_sources, seed_sources
from twistarm import load_arm
from urdf_text import joint, robot, two_joints, write

QUICK, LONG, REAL = 80, 10_000, 3_000
"""Mutants in `make test`, and in `make test-all` of what is at hand everywhere and of real models."""


def run(sources: list[Source], count: int, folder: Path, workers: int) -> Campaign:
    result = campaign(sources, count, folder / "workers", workers=workers)
    print(f"\n{result}")
    assert not result.failed, result.report(folder / "failed")
    assert result.outcomes.total() == count
    assert result.outcomes["loaded"] > count / 10, "mutants that nobody can load prove little"
    return result


def test_some_mutants(tmp_path: Path) -> None:
    run([*seed_sources(), *own_sources()], QUICK, tmp_path, workers=1)


@pytest.mark.slow
def test_ten_thousand_mutants(tmp_path: Path) -> None:
    run([*seed_sources(), *own_sources(), *catalogue_sources()], LONG, tmp_path, workers=os.cpu_count() or 1)


@pytest.mark.slow
def test_mutants_of_real_models(models: Path, tmp_path: Path) -> None:
    run(real_sources(models), REAL, tmp_path, workers=os.cpu_count() or 1)


# -- the fuzzer itself -------------------------------------------------------------------------------------------------


def test_the_same_seed_gives_the_same_mutant() -> None:
    (source, *_) = seed_sources()
    data, file = (source.folder / source.file).read_bytes(), PurePath(source.file)
    first, again, other = (mutations.mutate(data, file, Random(seed)) for seed in ("1", "1", "2"))
    assert first == again != other


MUTATORS = {name: group for groups in (mutations.TREES, mutations.TEXTS) for name, group in groups.items()}


@pytest.mark.parametrize(
    ("kind", "mutator"), [(kind, one) for kind, group in MUTATORS.items() for one in dict.fromkeys(group)]
)
def test_every_mutator_changes_something(
    kind: str, mutator: Callable[..., object], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(mutations.TREES if kind in mutations.TREES else mutations.TEXTS, kind, (mutator,))
    file = "seed.urdf" if kind in mutations.TREES else "seed.xacro"
    text = (seed_sources()[0].folder / file).read_bytes()
    assert len({mutations.once(text, kind, Random(seed)) for seed in range(10)} - {text}) > 1


@pytest.mark.parametrize(
    ("how", "problem"), [(signal.SIGKILL, "it ended with -9"), (signal.SIGSTOP, "no answer within 0 s")]
)
def test_a_process_that_dies_or_waits_is_replaced(
    how: signal.Signals, problem: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = verdicts(seed_sources()[:1], range(20), tmp_path)
    assert next(found)[1]["problems"] == []
    for child in multiprocessing.active_children():
        os.kill(child.pid, how)
    if how == signal.SIGSTOP:
        monkeypatch.setattr(runner, "PATIENCE", 0.0)
    answered = list(iter(lambda: next(found)[1]["problems"], [problem]))
    monkeypatch.undo()
    assert answered + [verdict["problems"] for _, verdict in found] == [[]] * 18


def test_a_mutant_that_computes_for_long_is_given_up(tmp_path: Path) -> None:
    told = [verdict["problems"] for _, verdict in verdicts(seed_sources()[:1], range(2), tmp_path, limit=0.0)]
    assert told == [["no answer after 0 s of computing"]] * 2


def judged_as(monkeypatch: pytest.MonkeyPatch, path: Path, load) -> dict:
    monkeypatch.setattr(oracle, "load_arm", load)
    return oracle.judged(path, {}, {})


def test_the_oracle_sees_a_wrong_pose(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, other = write(tmp_path, two_joints()), write(tmp_path, two_joints(xyz="0 0 0.50001"), "other.urdf")
    assert judged_as(monkeypatch, path, load_arm)["problems"] == []
    assert "fk differs by 1e-05" in judged_as(monkeypatch, path, lambda _: load_arm(other))["problems"][0]


def test_the_oracle_sees_wrong_limits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path, two_joints())
    verdict = judged_as(monkeypatch, path, lambda name: load_arm(name, limits={"upper": 0.9}))
    assert "limits of a: [-1.0, 0.9] instead of (-1.0, 1.0)" in verdict["problems"][0]


def test_the_oracle_sees_a_traceback(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: Path) -> None:
        raise KeyError("elbow")

    verdict = judged_as(monkeypatch, write(tmp_path, two_joints()), fail)
    assert verdict["outcome"] == "traceback"
    assert "KeyError: 'elbow'" in verdict["problems"][0]


@pytest.mark.parametrize(
    ("message", "flaw"),
    [("", "is empty"), ("x" * 2001, "has 2001"), ("one\ntwo", "control"), ("Traceback (most", "is Python's own")],
)
def test_the_oracle_sees_a_message_that_is_none(message: str, flaw: str) -> None:
    assert flaw in " ".join(oracle.flaws(message))


def test_the_second_reading_honours_a_planar_joint(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = robot(joint("p", "base_link", "upper", "planar", '<axis xyz="0 1 0"/>'), joint("b", "upper", "tool0"))
    assert judged_as(monkeypatch, write(tmp_path, text), load_arm)["problems"] == []
