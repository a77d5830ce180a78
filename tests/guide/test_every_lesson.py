"""Every lesson's program, and what it claims, on many arms; every number of the errata, computed anew."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from small_course import REAL_ARMS
from twistarm.description.catalog import own_arms
from twistarm.guide.building.lesson import cells_of
from twistarm.guide.course import ERRATA, LESSONS, lesson_file
from twistarm.guide.teaching import output
from twistarm.guide.teaching.reader import VARIABLE, arm

CLAIMS = Path(__file__).with_name("claims")
REFERENCES = {"pin": pin, "expm": expm, "Rotation": Rotation}
"""What claims compare with, beside the names of their lesson."""


def claims_on(lesson: str) -> dict[str, Any]:
    """The claims on each section, as code that knows its lines."""
    path = CLAIMS / f"{lesson}.py"
    head, *parts = re.split(r"^# ## (.*)$", path.read_text("utf-8"), flags=re.MULTILINE)
    line, claims = head.count("\n"), {}
    for title, text in zip(parts[::2], parts[1::2], strict=True):
        claims[title] = compile("\n" * line + text, str(path), "exec")
        line += text.count("\n")
    return claims


def run(lesson: str, scenes: Path | None) -> list[str]:
    """Run a lesson with the claims on it. Returns what it says."""
    texts: list[str] = []

    def show(shown: output.Shown) -> None:
        texts.append(shown.plain)
        if scenes:
            shown.html(scenes)

    names: dict[str, Any] = {"__name__": "__main__"}
    claims, title = claims_on(lesson), ""
    with output.installed(show):
        for cell in cells_of(lesson_file(lesson)):
            if cell.code:
                exec(compile("\n" * (cell.line - 1) + cell.source, str(lesson_file(lesson)), "exec"), names)
            elif titles := re.findall(r"^## (.*)$", cell.source, flags=re.MULTILINE):
                exec(claims.pop(title, ""), {**names, **REFERENCES})
                title = titles[-1]
    assert not claims, "each belongs to a section"
    return texts


@pytest.mark.parametrize("lesson", LESSONS)
def test_the_lesson_holds(lesson: str) -> None:
    texts = run(lesson, None)
    assert any("`rover_arm`" in words or " rover_arm " in words for words in texts), "it speaks of the reader's arm"
    assert "twistarm guide check" in texts[-1], "it ends with its exercises"


@pytest.mark.parametrize("lesson", LESSONS)
def test_a_program_that_is_not_folded_fits_a_glance(lesson: str) -> None:
    assert all(cell.source.count("\n") < 20 for cell in cells_of(lesson_file(lesson)) if cell.shown)


@pytest.mark.slow
@pytest.mark.parametrize("lesson", LESSONS)
@pytest.mark.parametrize(
    ("source", "options"), [*((name, {}) for name in own_arms() if name != "rover_arm"), *REAL_ARMS]
)
def test_the_lesson_holds_on_every_arm(
    source: str,
    options: dict[str, Any],
    lesson: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    request: pytest.FixtureRequest,
) -> None:
    file = str(request.getfixturevalue("models") / source) if "." in source else source
    monkeypatch.setenv(VARIABLE, json.dumps({"source": file, **options}))
    assert any(arm().name in words for words in run(lesson, tmp_path))


def hat(w: object) -> np.ndarray:
    return np.asarray(pin.skew(np.asarray(w, float)))


def motion(*xi: float) -> np.ndarray:
    return np.asarray(pin.exp6(np.array(xi)).homogeneous)


def about(axis: str, degrees: float) -> Rotation:
    return Rotation.from_euler(axis, degrees, degrees=True)


def series_with_slip() -> float:
    """Which entry is farthest off: the slip changes the factor of ω̂² alone."""
    w, theta = np.array([0.6, 0.0, 0.8]), 1.2
    factor = (theta**4 - 1) / 24 - (theta**6 - 1) / 720
    return float(abs(factor) * np.abs(hat(w) @ hat(w)).max())


def chasles() -> float:
    xi_hat = np.zeros((4, 4))
    xi_hat[:3, :3], xi_hat[:3, 3] = hat([0, 0, 1]), [0, -0.3, 0.1]
    return float(np.abs(xi_hat @ expm(xi_hat) - xi_hat).max())


def mixed_signs() -> float:
    """The elbow's mirror image about the line to the target, with the second link left as it was."""
    l1, l2, r = 0.4, 0.3, np.hypot(0.35, 0.3)
    beta = np.arccos((r**2 + l1**2 - l2**2) / (2 * l1 * r))
    inner = np.arccos((l1**2 + l2**2 - r**2) / (2 * l1 * l2))
    return float(abs(l1 * np.exp(1j * beta) + l2 * np.exp(1j * (beta + np.pi - inner)) - r))


def two_orders() -> float:
    ab, bc = motion(1, 0, 0, 0, 0, 0.5), motion(0, 1, 0, 0.7, 0, 0)
    return float(np.linalg.norm((ab @ bc - bc @ ab)[:3, 3]))


APART = np.degrees((about("z", 40) * about("y", 30) * (about("y", 30) * about("z", 40)).inv()).magnitude())
LONG = np.linalg.det(np.eye(3) + hat([0, 0, 2]) / 2 + hat([0, 0, 2]) @ hat([0, 0, 2]) * (1 - np.sqrt(3) / 2))
HOME = pin.exp6(np.array([0.9, 0, 0, 0, 0.3, 0]))
SPATIAL = np.array([0, -0.4, 0, 0, 0, 1.0])
BODY = HOME.inverse().action @ SPATIAL
TURNED = motion(0.5, 0.2, 0, 0, 0, 1)[:3, 3]
TWO_LINKS = 0.4 * np.cos(0.5) + 0.3 * np.cos(1.3)

STATED = {
    1: ("{:.3f} m off", 2 * np.sin((1 - np.pi / 180) / 2)),  # a chord of the unit circle
    2: ("differ by {:.1f}°", APART),
    3: ("Q^{{-1}} = {:.4f}", 1 / 30),
    4: ("{:.0f} apart", 2.0),
    5: ("determinant {:.0f}", 8.0),
    6: ("one is {:.3f} from it", series_with_slip()),
    7: ("determinant {:.3f}, no rotation", LONG),
    8: ("origin {:.3f} m apart", two_orders()),
    9: ("differ by up to {:.2f}", chasles()),
    10: ("axis at {:.2f} m/s", 0.1),
    11: ("They are {:.2f} m/s apart", np.linalg.norm((SPATIAL - BODY)[:3])),
    12: ("answer is {:.2f} m off", 0.8),
    13: ("end {:.3f} m apart", np.linalg.norm(TURNED)),
    14: ("alone: $x = {:.4f}$ m", TWO_LINKS),
    15: ("mixed ones {:.3f} m", mixed_signs()),
    16: ("cosine is $-1 - {}$", output.rough(0.7e-9 / 0.12)),  # d/dr of (l₁² + l₂² − r²) / 2 l₁ l₂
}
"""What the page says below each number, and the value that belongs there."""


@pytest.fixture(scope="module")
def texts() -> dict[int, str]:
    """What is computed below each title, by its number."""
    names: dict[str, object] = {}
    found: dict[int, str] = {}
    number = 0
    for cell in cells_of(Path(lesson_file(ERRATA))):
        number = int(titles[-1]) if (titles := re.findall(r"^## (\d+)\.", cell.source, re.MULTILINE)) else number
        if cell.code:
            shown: list[output.Shown] = []
            with output.installed(shown.append):
                exec(cell.source, names)
            found[number] = found.get(number, "") + " ".join(piece.plain for piece in shown)
    return found


def test_each_slip_has_its_number(texts: dict[int, str]) -> None:
    assert sorted(filter(None, texts)) == list(STATED)


@pytest.mark.parametrize("number", STATED)
def test_the_number_is_right(number: int, texts: dict[int, str]) -> None:
    words, value = STATED[number]
    assert words.format(value) in texts[number]


def test_the_velocities_of_the_joint_are_told_as_vectors(texts: dict[int, str]) -> None:
    stated = [[float(x) for x in row.split(",")] for row in re.findall(r"v = \(([^)]*)\)", texts[11])]
    assert np.allclose(stated, [SPATIAL[:3], BODY[:3]], atol=5e-3)
