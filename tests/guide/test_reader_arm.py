"""The arm of a lesson: the reader's, the bundled one, and the sentence where one stands in for the other."""

from __future__ import annotations

import json

import pytest

from twistarm import InputError, guide
from twistarm.guide.teaching import outlet
from twistarm.guide.teaching.arm import VARIABLE


def test_it_is_the_readers_or_the_rover(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    assert guide.arm().name == "rover_arm"
    monkeypatch.setenv(VARIABLE, json.dumps({"source": "scara"}))
    assert guide.arm().name == "scara"


@pytest.mark.parametrize("text", ["{", "[]", "{}", "3"])
def test_a_variable_that_means_nothing_is_said(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, text)
    with pytest.raises(InputError, match="TWISTARM_GUIDE_ARM takes JSON like"):
        guide.arm()


def test_another_stands_in_and_it_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, json.dumps({"source": "rr_planar"}))
    said: list[str] = []
    with outlet.installed(lambda shown: said.append(shown.plain)):
        assert guide.arm_with("two joints", lambda arm: arm.n == 2).name == "rr_planar"
        assert said == []
        assert guide.arm_with("six joints", lambda arm: arm.n == 6).n == 6
    assert said[0].startswith("Your arm, `rr_planar`, does not have six joints.")
    with pytest.raises(InputError, match="no bundled arm has ninety joints"):
        guide.arm_with("ninety joints", lambda arm: arm.n == 90)
