"""`twistarm doctor`, and `check` and `doctor` over a folder: pages, exit codes, JSON, files written."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from finding_cases import CASES
from test_cli import error_of
from test_finding_codes import lay
from twistarm.checking.doctor.wording import codes_page
from twistarm.cli.application import run
from twistarm.description.findings import CODES

Capture = pytest.CaptureFixture[str]


def page(capsys: Capture, *arguments: str, code: int = 0) -> str:
    """What a command prints, white space made single; it must exit with `code` and say nothing on stderr."""
    assert run(["doctor", *arguments]) == code
    captured = capsys.readouterr()
    assert captured.err == ""
    return " ".join(captured.out.replace("│", " ").split())


def answer(capsys: Capture, *arguments: str, code: int = 0) -> Any:
    assert run([*arguments, "--json"]) == code
    return json.loads(capsys.readouterr().out)


def test_the_page_of_the_rover_arm(capsys: Capture) -> None:
    shown = page(capsys, "rover_arm")
    for part in (
        "rover_arm: 5 joints from base_link to tool0; moves its tool in 5 of 6 directions",
        "info rover_arm.urdf.xacro",
        "cannot-turn-in-place cannot yaw the tool",
        "→ start from the ready pose",
        "3 remarks",
    ):
        assert part in shown


def test_exit_codes_by_severity(capsys: Capture, tmp_path: Path) -> None:
    warned = str(lay(CASES["limits-look-like-degrees"], tmp_path))
    assert '→ write lower="-2.96706" upper="2.96706"' in page(capsys, warned)
    page(capsys, warned, "--strict", code=1)
    page(capsys, "rover_arm", "--strict")
    refused = str(lay(CASES["limits-swapped"], tmp_path))
    shown = page(capsys, refused, code=1)
    assert "no arm until the errors below are mended" in shown
    assert (
        "error arm.urdf:2: joint 'a' limits-swapped its limits are swapped: lower 1 > upper -1 → exchange them" in shown
    )
    assert "nonsense.urdf: no such file" in error_of(capsys, "doctor", "nonsense.urdf")
    assert "no arm 'nonsense'" in error_of(capsys, "doctor", "nonsense")


def test_json_has_the_place_in_parts(capsys: Capture, tmp_path: Path) -> None:
    content = answer(capsys, "doctor", str(lay(CASES["limits-look-like-degrees"], tmp_path)))
    first = content["findings"][0]
    assert {name: first[name] for name in ("code", "severity", "file", "line", "element", "name")} == {
        "code": "limits-look-like-degrees", "severity": "warning",
        "file": "arm.urdf", "line": 2, "element": "joint", "name": "a",
    }  # fmt: skip
    assert first["meaning"] == CODES["limits-look-like-degrees"].meaning
    assert content["n"] == 2
    assert content["directions"] == {"position": 0, "rotation_in_place": 1}
    refused = answer(capsys, "doctor", str(lay(CASES["cycle"], tmp_path)), code=1)
    assert (refused["n"], refused["directions"]) == (None, None)
    assert refused["findings"][0]["code"] == "cycle"


def test_codes_need_no_arm(capsys: Capture) -> None:
    assert run(["doctor", "--codes"]) == 0
    assert capsys.readouterr().out == codes_page()


def test_fix_writes_and_lists(capsys: Capture, tmp_path: Path) -> None:
    path = str(lay(CASES["axis-not-unit"], tmp_path))
    out = tmp_path / "fixed.urdf"
    shown = page(capsys, path, "--fix", "-o", str(out))
    assert "repaired: joint 'a': axis 0 0 2 normalised" in shown
    assert (
        f"written: {out} (1 repair; the same links, joints, limits and poses; Pinocchio's own parser reads it)" in shown
    )
    assert "axis-not-unit" not in page(capsys, str(out))
    assert f"{out} exists; --force replaces it" in error_of(capsys, "doctor", path, "--fix", "-o", str(out))
    content = answer(capsys, "doctor", path, "--fix", "-o", str(out), "--force")
    assert content["repairs"] == ["joint 'a': axis 0 0 2 normalised"]
    assert content["written"] == [str(out)]
    assert "which stays unchanged" in error_of(capsys, "doctor", path, "--fix", "-o", path)


def test_fix_of_what_cannot_be_read_writes_nothing(capsys: Capture, tmp_path: Path) -> None:
    out = tmp_path / "fixed.urdf"
    shown = page(capsys, str(lay(CASES["limits-swapped"], tmp_path)), "--fix", "-o", str(out), code=1)
    assert f"{out} not written: mend the errors above first" in shown
    assert not out.exists()
