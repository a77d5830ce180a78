"""Every finding's code: an input that raises it, and the list in docs; `twistarm doctor`: exit codes and files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pinocchio
import pytest

from finding_cases import CASES, FAULTS, Case
from test_cli import Capture, answer
from twistarm import diagnose, load_arm
from twistarm.cli.application import run
from twistarm.description.findings import CODES, Finding, codes_page
from twistarm.support.errors import ComparisonError, DescriptionError
from urdf_text import two_joints, write

DOCS = Path(__file__).parents[2] / "docs" / "findings.md"


def lay(case: Case, folder: Path) -> Path:
    """The case's files in a folder; the source among them."""
    for name, text in case.files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    for name, size in case.sizes.items():
        with (folder / name).open("wb") as file:
            file.truncate(size)
    return folder / next(iter(case.files))


def keywords(case: Case, folder: Path) -> dict[str, Any]:
    return {name: folder / value if name in ("limits", "srdf") else value for name, value in case.load.items()}


def found(case: Case, folder: Path) -> tuple[Finding, ...]:
    return diagnose(lay(case, folder), **keywords(case, folder))


def codes(source: object, **load: object) -> list[str]:
    return [one.code for one in diagnose(source, **load)]  # type: ignore[arg-type]


def only(case: Case, folder: Path, code: str) -> Finding:
    (one,) = [one for one in found(case, folder) if one.code == code]
    return one


# Codes of a `Scene`, which tests/collision raises.
SCENES = {"collision-shapes", "mesh-open", "no-collision-shapes", "points-far", "scene-names"}


def test_every_code_has_an_input_that_raises_it() -> None:
    assert {case.partition(":")[0] for case in CASES} | set(FAULTS) | SCENES == set(CODES)


@pytest.mark.parametrize("case", CASES)
def test_the_input_raises_its_code(case: str, tmp_path: Path) -> None:
    """Whole, in one line each; `load_arm` refuses the arm for an error, and for no other finding."""
    code = case.partition(":")[0]
    everything = found(CASES[case], tmp_path)
    findings = [one for one in everything if one.code == code]
    assert findings, f"only {[one.code for one in everything]}"
    for one in findings:
        assert one.severity == CODES[code].severity
        assert one.what
        assert one.remedy
        assert one.place.file
        assert "\n" not in one.what
    if CODES[code].severity != "error":
        assert not [one for one in everything if one.severity == "error"]
        return
    with pytest.raises(DescriptionError) as caught:
        load_arm(tmp_path / next(iter(CASES[case].files)), **keywords(CASES[case], tmp_path))
    assert code in [one.code for one in caught.value.findings]
    assert "\n" not in str(caught.value)


def test_the_engines_faults_are_findings_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path, two_joints())
    with monkeypatch.context() as patched:
        patched.setattr("twistarm.arm.loading.load.prove", raising(ComparisonError("they disagree by 1")))
        assert [one.what for one in diagnose(path) if one.code == "engines-disagree"] == ["they disagree by 1"]
    monkeypatch.setattr(pinocchio, "buildModelFromXML", raising(ValueError("a fault of its own")))
    (said,) = [one for one in diagnose(path) if one.severity == "error"]
    assert (said.code, said.what) == ("engines-disagree", "Pinocchio refuses it: a fault of its own")


def raising(error: Exception) -> Callable[[object], None]:
    def fail(_: object) -> None:
        raise error

    return fail


def test_the_list_in_docs_is_the_list_in_the_code() -> None:
    assert DOCS.read_text("utf-8") == codes_page(), "write it anew: twistarm doctor --codes > docs/findings.md"


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
    content = answer(capsys, "doctor", str(lay(CASES["unit-doubtful: degrees"], tmp_path)))
    first = content["findings"][0]
    assert {name: first[name] for name in ("code", "severity", "file", "line", "element", "name")} == {
        "code": "unit-doubtful", "severity": "warning",
        "file": "arm.urdf", "line": 2, "element": "joint", "name": "a",
    }  # fmt: skip
    assert first["meaning"] == CODES["unit-doubtful"].meaning
    assert content["n"] == 2
    assert content["directions"] == {"position": 0, "rotation_in_place": 1}
    refused = answer(capsys, "doctor", str(lay(CASES["not-a-tree: a circle"], tmp_path)), code=1)
    assert (refused["n"], refused["directions"]) == (None, None)
    assert refused["findings"][0]["code"] == "not-a-tree"


def test_codes_need_no_arm(capsys: Capture) -> None:
    assert run(["doctor", "--codes"]) == 0
    assert capsys.readouterr().out == codes_page()


def test_fix_writes_and_lists(capsys: Capture, tmp_path: Path) -> None:
    path, out = str(lay(CASES["axis-not-unit"], tmp_path)), tmp_path / "fixed.urdf"
    assert run(["doctor", path, "--fix", "-o", str(out)]) == 0
    assert str(out) in capsys.readouterr().out.replace("\n", "")
    assert "axis-not-unit" not in [one["code"] for one in answer(capsys, "doctor", str(out))["findings"]]
    assert run(["doctor", path, "--fix", "-o", str(out)]) == 2
    content = answer(capsys, "doctor", path, "--fix", "-o", str(out), "--force")
    assert len(content["repairs"]) == 1
    assert content["written"] == [str(out)]
    assert run(["doctor", path, "--fix", "-o", path]) == 2
    assert run(["doctor", path, "--fix"]) == 2


def test_fix_of_what_cannot_be_read_writes_nothing(tmp_path: Path) -> None:
    out = tmp_path / "fixed.urdf"
    assert run(["doctor", str(lay(CASES["limits-swapped"], tmp_path)), "--fix", "-o", str(out)]) == 1
    assert not out.exists()
