"""A course built once, of one lesson; lessons of a test's own, run in this process."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from twistarm.guide.building.building import Built, build
from twistarm.guide.building.lesson_process import outcome

LESSON = "3_1_forward_kinematics"

ROVER = {"source": "rover_arm"}


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    return build(tmp_path_factory.mktemp("course"), ROVER, [LESSON])


@pytest.fixture
def ran(tmp_path: Path) -> Callable[[str], dict[str, Any]]:
    """What becomes of a lesson, by its text."""

    def run(text: str) -> dict[str, Any]:
        path = tmp_path / "lesson.py"
        path.write_text(text)
        (tmp_path / "scenes").mkdir(exist_ok=True)
        return outcome(path, tmp_path / "scenes")

    return run
