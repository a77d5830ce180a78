"""Hostile meshes: none reads what it must not, takes more than its share, or costs the arm more than its shape."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path

import pytest

from hostile.attempt import Outcome, attempt
from hostile.mesh_case import CANARY, Case, lay
from hostile.meshes import CASES, NO_FILES
from twistarm import load_arm
from twistarm.description.meshes import MeshReader, UnreadableMeshError

SECONDS, MEGABYTES = 25.0, 1_300.0
"""A mesh has 3 s and more of a processor, four times that on the clock, and the memory of the process that reads it."""


def _told(case: Case, outcome: Outcome) -> str:
    found = [one for one in json.loads(outcome.output)["findings"] if one["code"].startswith("mesh")]
    if CANARY in outcome.output.encode():
        return "the canary is told"
    if case in NO_FILES.values():
        return "" if [one["code"] for one in found] == ["mesh-missing"] else f"not missing: {found}"
    said = [one["what"] for one in found if one["code"] == "mesh-unreadable"]
    return "" if re.search(case.said, " ".join(said)) else f"not said: {said}"


def _shown(case: Case, outcome: Outcome, folder: Path) -> str:
    if outcome.code != 0:
        return f"exit {outcome.code}: {outcome.errors[:100]}"
    page = (folder / "page.html").read_text()
    literal = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    assert literal is not None
    told = json.loads(literal.group(1))
    drawn = [base64.b64decode(each) for each in told["objects"]]
    if CANARY in page.encode() or any(CANARY[i : i + 12] in each for each in drawn for i in (0, 12)):
        return "the canary is drawn"
    notes = [note for note in told["notes"] if "cannot read mesh" in note]
    return "" if re.search(case.said, " ".join(notes)) else f"not noted: {told['notes']}"


QUICK = re.compile("uri|mtllib (?!with a line)|unit|document|laughs|NaN|count of|stride|indices|JSON|Draco|image|other")
"""Of which each takes some milliseconds."""


@pytest.mark.parametrize("name", [name for name in CASES if QUICK.search(name) and name not in NO_FILES])
def test_what_a_mesh_refers_to_is_its_own_and_its_numbers_are_numbers(name: str, tmp_path: Path) -> None:
    case = CASES[name]
    lay(case, tmp_path)
    (mesh,) = (path for path in (tmp_path / "arm/meshes").glob("mesh*") if path.suffix != ".mtl")
    told = _read(mesh)
    assert re.search(case.said, told) if case.said else not told


def _read(mesh: Path) -> str:
    """Why it is not drawn, or what of the canary is; empty where all is well."""
    try:
        with MeshReader() as meshes:
            drawn = b"".join(part.vertices.astype("<f4").tobytes() for part in meshes.parts(mesh))
    except UnreadableMeshError as error:
        return error.reason
    return "the canary is drawn" if any(CANARY[i : i + 12] in drawn for i in (0, 12)) else ""


@pytest.mark.parametrize("name", NO_FILES)
def test_a_mesh_that_is_no_file_is_missing(tmp_path: Path, name: str) -> None:
    arm = load_arm(lay(CASES[name], tmp_path))
    assert "mesh-missing" in [one.code for one in arm.findings]


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_no_mesh_takes_more_than_its_share_or_shows_what_is_not_its_own(name: str, tmp_path: Path) -> None:
    case, path = CASES[name], str(lay(CASES[name], tmp_path))
    outcome = attempt("doctor", path, "--json", folder=tmp_path)
    assert (outcome.within(SECONDS, MEGABYTES) or _told(case, outcome)) == ""
    outcome = attempt("view", path, "-o", "page.html", folder=tmp_path)
    assert (outcome.within(SECONDS, MEGABYTES) or _shown(case, outcome, tmp_path)) == ""
