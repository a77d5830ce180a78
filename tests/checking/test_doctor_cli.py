"""`twistarm doctor`: pages, exit codes, JSON, files written."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from finding_cases import CASES
from test_finding_codes import lay
from twistarm.cli.application import run
from twistarm.description.findings import CODES, codes_page

Capture = pytest.CaptureFixture[str]


def answer(capsys: Capture, *arguments: str, code: int = 0) -> Any:
    assert run(["doctor", *arguments, "--json"]) == code
    return json.loads(capsys.readouterr().out)


def test_the_page_of_the_rover_arm(capsys: Capture) -> None:
    assert run(["doctor", "rover_arm"]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    for part in ("rover_arm", "base_link", "tool0", "rover_arm.urdf.xacro", "cannot-turn-in-place", "→"):
        assert part in captured.out


def test_exit_codes_by_severity(capsys: Capture, tmp_path: Path) -> None:
    warned = str(lay(CASES["unit-doubtful: degrees"], tmp_path))
    assert run(["doctor", warned]) == 0
    assert run(["doctor", warned, "--strict"]) == 1
    assert run(["doctor", "rover_arm", "--strict"]) == 0
    refused = str(lay(CASES["limits-swapped"], tmp_path))
    assert run(["doctor", refused]) == 1
    assert "limits-swapped" in capsys.readouterr().out
    for nothing in ("nonsense.urdf", "nonsense"):
        assert run(["doctor", nothing]) == 2
        assert nothing in capsys.readouterr().err


def test_json_has_the_place_in_parts(capsys: Capture, tmp_path: Path) -> None:
    content = answer(capsys, str(lay(CASES["unit-doubtful: degrees"], tmp_path)))
    first = content["findings"][0]
    assert {name: first[name] for name in ("code", "severity", "file", "line", "element", "name")} == {
        "code": "unit-doubtful", "severity": "warning",
        "file": "arm.urdf", "line": 2, "element": "joint", "name": "a",
    }  # fmt: skip
    assert first["meaning"] == CODES["unit-doubtful"].meaning
    assert content["n"] == 2
    assert content["directions"] == {"position": 0, "rotation_in_place": 1}
    refused = answer(capsys, str(lay(CASES["not-a-tree: a circle"], tmp_path)), code=1)
    assert (refused["n"], refused["directions"]) == (None, None)
    assert refused["findings"][0]["code"] == "not-a-tree"


def test_codes_need_no_arm(capsys: Capture) -> None:
    assert run(["doctor", "--codes"]) == 0
    assert capsys.readouterr().out == codes_page()


def test_fix_writes_and_lists(capsys: Capture, tmp_path: Path) -> None:
    path, out = str(lay(CASES["axis-not-unit"], tmp_path)), tmp_path / "fixed.urdf"
    assert run(["doctor", path, "--fix", "-o", str(out)]) == 0
    assert str(out) in capsys.readouterr().out.replace("\n", "")
    assert "axis-not-unit" not in [one["code"] for one in answer(capsys, str(out))["findings"]]
    assert run(["doctor", path, "--fix", "-o", str(out)]) == 2
    content = answer(capsys, path, "--fix", "-o", str(out), "--force")
    assert len(content["repairs"]) == 1
    assert content["written"] == [str(out)]
    assert run(["doctor", path, "--fix", "-o", path]) == 2
    assert run(["doctor", path, "--fix"]) == 2


def test_fix_of_what_cannot_be_read_writes_nothing(tmp_path: Path) -> None:
    out = tmp_path / "fixed.urdf"
    assert run(["doctor", str(lay(CASES["limits-swapped"], tmp_path)), "--fix", "-o", str(out)]) == 1
    assert not out.exists()
