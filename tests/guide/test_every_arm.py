"""The whole course on many arms: one of six joints, all that are bundled, and the real ones of `TWISTARM_MODELS`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from model_arms import REAL_ARMS
from twistarm.description.catalog import own_arms
from twistarm.guide.building.building import build
from twistarm.guide.building.printing import pdf_of
from twistarm.guide.course import lessons

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("name", own_arms())
def test_the_course_on_every_bundled_arm(name: str, tmp_path: Path) -> None:
    made = build(tmp_path / "site", {"source": name})
    assert made.failed == ()
    assert made.run == lessons()


@pytest.mark.parametrize(("file", "options"), REAL_ARMS)
def test_the_course_on_every_real_arm(file: str, options: dict[str, Any], models: Path, tmp_path: Path) -> None:
    made = build(tmp_path / "site", {"source": str(models / file), **options})
    assert made.failed == ()


@pytest.mark.browser
def test_a_lesson_is_printed(tmp_path: Path) -> None:
    made = build(tmp_path / "site", {"source": "rr_planar"}, lessons()[:1])
    assert len(pdf_of(made.folder, lessons()[0])) > 20_000
