"""Every finding's code: an input that raises it, its severity, and the list of codes in docs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pinocchio
import pytest

from finding_cases import CASES, FAULTS, Case
from twistarm import diagnose, load_arm
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


SCENES = {"collision-shapes", "mesh-open", "scene-names"}  # Codes of a `Scene`, which tests/collision raises.


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
