"""Thousands of mutants of real descriptions: each is refused in one line or loaded and right; and the fuzzer itself."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from fuzz import oracle
from fuzz.runner import Campaign, campaign
from fuzz.sources import Source, catalogue_sources, own_sources, real_sources, seed_sources
from twistarm import load_arm
from urdf_text import two_joints, write

# Mutants in `make test`, and in `make test-all` of what is at hand everywhere and of real models.
QUICK, LONG, REAL = 40, 10_000, 3_000


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
