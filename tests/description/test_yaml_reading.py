"""YAML as plain data: units, exponents, and errors in one line with their place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from twistarm import DescriptionError
from twistarm.description.companions.data_files import parse_yaml

FILE = Path("limits.yaml")


def test_units_and_exponents() -> None:
    text = "{a: !degrees 180, b: !radians 1.5, d: 1e-3, e: 2E2, f: -1e3, g: 1.5, h: yes, i: x1e3}"
    read = parse_yaml(text, FILE)
    assert np.isclose(read.pop("a"), np.pi)
    assert read == {"b": 1.5, "d": 1e-3, "e": 200.0, "f": -1000.0, "g": 1.5, "h": True, "i": "x1e3"}
    assert yaml.safe_load("1e3") == "1e3", "the tags and numbers hold for the whole process"
    assert "!" not in yaml.SafeLoader.yaml_multi_constructors


def test_anchors_and_merges() -> None:
    read = parse_yaml("all: &all {max_velocity: 1.0}\na: *all\nb: {<<: *all, max_jerk: 2.0}", FILE)
    assert read["a"] == {"max_velocity": 1.0}
    assert read["b"] == {"max_velocity": 1.0, "max_jerk": 2.0}


REFUSED = {
    "an object": ("!!python/object/apply:os.system ['true']", 1),
    "an unknown tag": ("a: 1\nb: !degree 1", 2),
    "a tab": ("a:\n\tb: 1", 2),
    "a key twice": ("a:\n  b: 1\n  b: 2", 2),
    "two documents": ("a: 1\n---\nb: 2", 2),
    "too deep": ("[" * 5000, None),
    "an unclosed list": ("{\n", 2),
    "no number behind a unit": ("a: !degrees x", None),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused_in_one_line(case: str) -> None:
    text, line = REFUSED[case]
    with pytest.raises(DescriptionError) as caught:
        parse_yaml(text, FILE)
    assert "\n" not in str(caught.value)
    (finding,) = caught.value.findings
    assert finding.code == "companion-unusable"
    assert line is None or finding.place.line == line
    assert (case == "a tab") == ("TAB" in finding.what)
