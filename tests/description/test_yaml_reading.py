"""YAML as plain data: units, exponents, and bombs refused in one line and in no time."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

from twistarm import DescriptionError
from twistarm.description.yaml_reading import parse_yaml

FILE = Path("limits.yaml")


@pytest.fixture(autouse=True, params=[True, False], ids=["libyaml", "PyYAML alone"])
def libyaml(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(yaml, "__with_libyaml__", request.param and yaml.__with_libyaml__)


def test_units_and_exponents() -> None:
    text = "{a: !degrees 180, b: !radians 1.5, c: !millimeters 250, d: 1e-3, e: 2E2, f: -1e3, g: 1.5, h: yes, i: x1e3}"
    read = parse_yaml(text, FILE)
    assert np.isclose(read.pop("a"), np.pi)
    assert read == {"b": 1.5, "c": 0.25, "d": 1e-3, "e": 200.0, "f": -1000.0, "g": 1.5, "h": True, "i": "x1e3"}


def test_anchors_are_allowed_where_they_stay_small() -> None:
    read = parse_yaml("all: &all {max_velocity: 1.0}\na: *all\nb: {<<: *all, max_jerk: 2.0}", FILE)
    assert read["a"] == {"max_velocity": 1.0}
    assert read["b"] == {"max_velocity": 1.0, "max_jerk": 2.0}


LAUGHS = "a0: &a0 [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]\n" + "".join(
    f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 12)
)

REFUSED = {
    "a bomb": (LAUGHS, "limits.yaml:5: not usable YAML: more than"),
    "a bomb of merges": (
        "a0: &a0 {x: 1}\n" + "".join(f"a{i}: &a{i} {{<<: [{', '.join([f'*a{i - 1}'] * 9)}]}}\n" for i in range(1, 12)),
        "more than 50000 values",
    ),
    "itself": ("a: &a [*a]", "an alias inside its own value"),
    "an object": ("!!python/object/apply:os.system ['true']", "could not determine a constructor"),
    "an unknown tag": ("a: !degree 1", "the tag !degree is unknown; allowed"),
    "a tab": ("a:\n\tb: 1", "limits.yaml:2: not usable YAML: found"),
    "a key twice": ("a:\n  b: 1\n  b: 2", "'b' stands there twice"),
    "a key of many digits": ("1000000000000000001: 1", "a number of more than 18 characters"),
    "two documents": ("a: 1\n---\nb: 2", "not usable YAML: but found another"),
    "no end": ("[" * 5000, "it nests without end"),
    "a time of day": ("a: 1:30", "1:30 is a number in base 60; write it in"),
    "a number without end": ("a: " + ":".join(["1"] * 50000), "a number of more than 400 characters"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused_in_one_line(case: str) -> None:
    text, message = REFUSED[case]
    with pytest.raises(DescriptionError) as caught:
        parse_yaml(text, FILE)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    assert [finding.code for finding in caught.value.findings] == ["limits-unusable"]


def test_its_tags_are_not_registered_for_the_whole_process() -> None:
    program = (
        "import yaml; from pathlib import Path; from twistarm.description.yaml_reading import parse_yaml\n"
        "parse_yaml('a: !degrees 1', Path('x'))\n"
        "assert '!degrees' not in yaml.SafeLoader.yaml_constructors and not yaml.SafeLoader.yaml_multi_constructors\n"
        "assert yaml.safe_load('1e3') == '1e3'"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
