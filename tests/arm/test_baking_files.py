"""Files of baked arms: what is refused in one line, where they may be written, and the command."""

from __future__ import annotations

import json
import zlib
from pathlib import Path

import numpy as np
import pytest

import twistarm
from baked_arms import TOL, assert_same, bake, sealed
from baked_arms import everything as everything
from catalogue import load
from twistarm import Arm, load_arm
from twistarm.arm.baking import MAX_BYTES
from twistarm.cli.application import run
from twistarm.support.errors import DescriptionError, InputError
from urdf_text import write


def test_the_digest_is_what_the_format_says(rover: Arm, tmp_path: Path) -> None:
    path = bake(rover, tmp_path)
    content = json.loads(path.read_text("utf-8"))
    assert json.loads(sealed(content))["digest"] == content["digest"]
    path.write_text(sealed(content))
    assert_same(load_arm(path), rover)


def test_an_edited_number_is_refused(rover: Arm, tmp_path: Path) -> None:
    path = bake(rover, tmp_path)
    text = path.read_text("utf-8")
    path.write_text(text.replace("-1.57", "-1.58", 1))
    with pytest.raises(DescriptionError) as caught:
        load_arm(path)
    assert str(caught.value).startswith(f"{path}: edited or damaged since it was written")
    assert str(caught.value).endswith("twistarm bake ARM -o FILE --force")


@pytest.mark.parametrize(
    ("text", "telling"),
    [
        ("", "not a baked arm"),
        ("[" * 100_000, "not a baked arm"),
        ('{"format": "twistarm arm", "version": 2}', "version 2"),
        ('{"format": "twistarm arm", "version": 1}', "edited or damaged"),
        ('{"format": "twistarm arm", "version": 1, "reach": NaN}', "finite"),
        ('{"format": "twistarm arm", "version": 1, "reach": 1e999}', "Out of range"),
    ],
    ids=lambda text: text[:24],
)
def test_other_files_are_refused_in_one_line(text: str, telling: str, tmp_path: Path) -> None:
    path = tmp_path / "arm.json"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(DescriptionError, match=telling) as caught:
        load_arm(path)
    assert "\n" not in str(caught.value)


def test_a_file_of_any_size_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "arm.json"
    with path.open("wb") as file:
        file.truncate(MAX_BYTES + 1)
    with pytest.raises(DescriptionError, match="it has 10,000,001 bytes; at most 10,000,000 are read"):
        load_arm(path)


def test_a_damaged_file_is_never_another_arm(everything: Arm, tmp_path: Path) -> None:
    """200 files with one bit turned: refused in one line, but where white space became another; 50 cut off."""
    path = bake(everything, tmp_path)
    data, arm = path.read_bytes(), load_arm(path)
    rng = np.random.default_rng(zlib.crc32(b"bake"))
    refused = 0
    for at in rng.integers(len(data), size=200).tolist():
        path.write_bytes(data[:at] + bytes([data[at] ^ 1 << int(rng.integers(8))]) + data[at + 1 :])
        try:
            assert_same(load_arm(path), arm)
        except DescriptionError:
            refused += 1
    assert refused > 150
    for end in rng.integers(len(data) - 2, size=50).tolist():
        path.write_bytes(data[:end])
        with pytest.raises(DescriptionError):
            load_arm(path)


def test_where_it_may_be_written(rover: Arm, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a baked arm is named \*\.json; got .*arm\.txt"):
        twistarm.bake(rover, tmp_path / "arm.txt")
    with pytest.raises(InputError, match="does not exist; create it first"):
        twistarm.bake(rover, tmp_path / "none" / "arm.json")
    description = write(tmp_path, "<robot/>")
    link = tmp_path / "link.json"
    link.symlink_to(description)
    with pytest.raises(InputError, match="a description stands there and would be lost"):
        twistarm.bake(rover, link)
    assert description.read_text() == "<robot/>"


def test_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["bake", "rover_arm"]) == 0
    said = capsys.readouterr().out
    assert said == "rover_arm.json: rover_arm, 5 joints from base_link to tool0; next: twistarm info rover_arm.json\n"
    assert run(["bake", "rover_arm"]) == 2
    error = capsys.readouterr().err
    assert error == "error: rover_arm.json exists; --force replaces it, another name keeps it\n"
    assert run(["bake", "rover_arm.json", "-o", "again.json", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["written"] == ["again.json"]
    assert answer["digest"] == json.loads((tmp_path / "again.json").read_text("utf-8"))["digest"]
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "rover_arm.json").read_bytes()
    assert run(["bake", "rover_arm", "-o", "again.json", "--force"]) == 0
    capsys.readouterr()
    assert run(["fk", "rover_arm.json", "--json"]) == 0
    g = np.array(json.loads(capsys.readouterr().out)["matrix"])
    arm = load("rover_arm")
    assert np.abs(g - arm.by_pinocchio(arm.ready)[0]).max() < TOL
