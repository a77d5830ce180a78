"""`twistarm doctor`, and `check` and `doctor` over a folder: pages, exit codes, JSON, files written."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from finding_cases import CASES, XACRO
from test_cli import error_of
from test_finding_codes import lay
from twistarm import load_arm
from twistarm.checking.doctor.wording import codes_page
from twistarm.cli.application import run
from twistarm.description.findings import CODES
from urdf_text import joint, robot, two_joints, write

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


def folder(tmp_path: Path) -> Path:
    """A sound arm, one to warn about, one that is refused, an arm.toml with its source, macros, and what is hidden."""
    for name in ("team", "team/parts", ".git"):
        (tmp_path / name).mkdir()
    tool = joint("mount", "hand", "tool0", kind="fixed", xyz="0 0 0.1")
    good = robot(joint("a", "base_link", "hand"), tool, links=("base_link", "hand", "tool0"))
    write(tmp_path, good, "good.urdf")
    write(tmp_path, two_joints().replace("tool0", "flange"), "warned.urdf")
    write(tmp_path, "<robot", "broken.urdf")
    write(tmp_path, good.replace("tool0", "hook"), "team/arm.urdf")
    write(tmp_path, 'source = "arm.urdf"\ntip = "hook"\n', "team/arm.toml")
    macro = f'<robot {XACRO}><xacro:macro name="m"><link name="x"/></xacro:macro></robot>'
    write(tmp_path, macro, "team/parts/m.xacro")
    write(tmp_path, "<robot", ".git/hidden.urdf")
    write(tmp_path, "no robot", "notes.txt")
    return tmp_path


FILES = ["broken.urdf", "good.urdf", "team/arm.toml", "team/parts/m.xacro", "warned.urdf"]


def test_a_folder_is_doctored_with_a_line_each(capsys: Capture, tmp_path: Path) -> None:
    content = answer(capsys, "doctor", str(folder(tmp_path)), code=1)
    assert [file["file"] for file in content["files"]] == FILES
    assert [file["ok"] for file in content["files"]] == [False, True, True, None, True]
    assert [file["n"] for file in content["files"]] == [None, 1, 1, None, 2]
    assert [file["tip"] for file in content["files"]] == [None, "tool0", "hook", None, "flange"]
    assert content["files"][0]["findings"][0]["code"] == "xml-malformed"
    shown = page(capsys, str(tmp_path), code=1)
    assert "refused broken.urdf not well-formed XML" in shown
    assert "team/parts/m.xacro" not in shown
    assert "3 of 4 good (beside 1 with macros only)" in shown
    (tmp_path / "broken.urdf").unlink()
    assert "3 of 3 good" in page(capsys, str(tmp_path))
    assert "2 of 3 good" in page(capsys, str(tmp_path), "--strict", code=1)


def test_a_chosen_tip_is_told_by_the_folder_and_by_init(capsys: Capture, tmp_path: Path) -> None:
    path = lay(CASES["several-tips"], tmp_path)
    (chosen,) = (one for one in load_arm(path).findings if one.code == "several-tips")
    assert f"{chosen.place.name} (chosen)" in page(capsys, str(tmp_path))
    assert run(["init", str(path), "-o", "-"]) == 0
    assert f'tip = "{chosen.place.name}"\n# {chosen.what}\n' in capsys.readouterr().out


def test_a_folder_is_checked_with_a_line_each(capsys: Capture, tmp_path: Path) -> None:
    content = answer(capsys, "check", str(folder(tmp_path)), "--samples", "10", code=1)
    assert [file["verdict"] for file in content["files"]] == ["refused", "ok", "ok", "no robot: macros only", "ok"]
    assert all(file["worst"] < 1e-11 for file in content["files"] if file["verdict"] == "ok")
    assert not content["ok"]
    assert "name that arm instead of a folder" in error_of(capsys, "check", str(tmp_path), "--against", "x.json")


def test_a_folder_without_descriptions(capsys: Capture, tmp_path: Path) -> None:
    assert "no *.urdf, *.xacro, MJCF or arm.toml in this folder or below" in error_of(capsys, "doctor", str(tmp_path))


def test_the_folder_of_real_models(capsys: Capture, models: Path) -> None:
    content = answer(capsys, "check", str(models), "--samples", "5", code=1)
    verdicts = {file["file"]: file["verdict"] for file in content["files"]}
    assert "WRONG" not in verdicts.values()
    assert verdicts["so101/so101_new_calib.urdf"] == "ok"
    assert verdicts["ur_description/urdf/ur_macro.xacro"] == "no robot: macros only"
    assert verdicts["ur_description/urdf/ur.urdf.xacro"] == "refused"
