"""The page that says what is promised about files and networks: its figures are those of the code."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from twistarm.cli import csv_rows
from twistarm.description import document, structure
from twistarm.description.companions import toml_entries
from twistarm.description.expansion import confinement
from twistarm.description.meshes import limits
from twistarm.model import baking, pinocchio_model
from twistarm.planning.files import csv_reading, message_reading
from twistarm.proof import golden_file as golden
from twistarm.stream.links import gate

PAGE = (Path(__file__).parents[2] / "SECURITY.md").read_text("utf-8")

FIGURES = {
    "a URDF, or what a xacro file expands to": ("20 MB", document.MAX_BYTES / 1e6),
    "a xacro or YAML file that is included": ("10 MB", confinement.MAX_BYTES / 1e6),
    "links, joints of a description": ("4,000 each", structure.MAX_PARTS["link"]),
    "moving joints": ("150", pinocchio_model.MAX_MOVING_JOINTS),
    "a mesh, with what it refers to": ("100 MB", limits.LARGEST_FILE / 1e6),
    "triangles of a mesh": ("1,000,000", limits.TRIANGLES),
    "memory of the process that reads meshes": ("1,200 MB", limits.MEMORY / 1e6),
    "processor time for the meshes of an arm": ("90 s", limits.ARM_SECONDS_AT_MOST),
    "a golden file, an `arm.json`": ("10 MB", golden.MAX_BYTES / 1e6),
    "postures and targets in CSV": ("15 MB", csv_rows.BOUNDS.bytes / 1e6),
    "a motion in CSV": ("200 MB", csv_reading.BOUNDS.bytes / 1e6),
    "a motion in JSON": ("50 MB", message_reading.MAX_BYTES / 1e6),
    "values of a motion in YAML": ("500,000", message_reading.MAX_VALUES),
    "an `arm.toml`": ("64 kB", toml_entries.MAX_BYTES / 1e3),
}


@pytest.mark.parametrize("what", FIGURES)
def test_limits_told(what: str) -> None:
    told, limit = FIGURES[what]
    assert f"| {what} | {told} |" in PAGE
    assert float(re.sub(r"[^0-9.]", "", told)) == limit


def test_all_of_the_table_is_held_to_the_code() -> None:
    assert set(re.findall(r"^\| ([^|]+) \| [0-9]", PAGE, re.MULTILINE)) == set(FIGURES)


def test_seconds_of_a_signature() -> None:
    assert f"within {gate.WINDOW:g} s of this computer's clock" in PAGE


def test_limits_that_share_a_row() -> None:
    assert baking.MAX_BYTES == golden.MAX_BYTES
    assert structure.MAX_PARTS["joint"] == structure.MAX_PARTS["link"]
