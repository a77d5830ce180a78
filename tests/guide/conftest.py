"""A course built once, of one lesson; lessons of a test's own, run in this process."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from small_course import LESSON, ROVER
from twistarm.guide.building.building import Built, build
from twistarm.guide.building.lesson import outcome


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """Built by the first process that asks, while the others wait; they find nothing to be made."""
    # A folder that the processes of one run share, made by pytest-xdist above the temporary one of each.
    own = tmp_path_factory.getbasetemp()
    shared = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
    with (shared / "course.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        return build(shared / "course", ROVER, [LESSON])


@pytest.fixture
def ran(tmp_path: Path) -> Callable[[str], dict[str, Any]]:
    """What becomes of a lesson, by its text."""

    def run(text: str) -> dict[str, Any]:
        path = tmp_path / "lesson.py"
        path.write_text(text)
        (tmp_path / "scenes").mkdir(exist_ok=True)
        return outcome(path, tmp_path / "scenes")

    return run
