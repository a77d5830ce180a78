"""What a view at a fixed port keeps: its poses and where it stood."""

from __future__ import annotations

import json
import os
import re
import socket
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from twistarm import Arm, load_arm
from twistarm.support.errors import InputError
from twistarm.viewer import Viewer
from twistarm.viewer.server.memory import state_folder
from viewer_page import ARM, THETA, Page, until, visit

pytestmark = pytest.mark.skipif(os.name != "posix", reason="owners and modes are those of POSIX")


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A state folder of the test's own; what is kept is in the folder `twistarm` of it."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path / "state" / "twistarm"


@pytest.fixture
def port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def at(arm: Arm, port: int, **options: Any) -> Viewer:
    return Viewer(arm, port=port, open_browser=False, keep=True, **options)


def record(viewer: Viewer, *names: str) -> None:
    with Page(viewer) as page:
        for name in names:
            page.ask(type="record", name=name)


def kept(home: Path, ending: str) -> Path:
    (path,) = (file for file in home.glob(f"*{ending}") if ".old" not in file.name)
    return path


def poses_in(file: Path) -> list[str]:
    return [pose["name"] for pose in json.loads(file.read_text())["poses"]]


def until_kept(home: Path) -> Path:
    until(lambda: any(home.glob("*.json")))
    return kept(home, ".json")


# one run after the other ------------------------------------------------------------------------------


def test_the_poses_and_theta_are_those_of_the_last_run_and_the_token_is_new(arm: Arm, home: Path, port: int) -> None:
    with at(arm, port) as first:
        assert_allclose(first.theta, arm.ready)
        first.show(THETA)
        record(first, "one", "two")
        address = first.url
    with at(arm, port) as second:
        assert second.url != address
        assert second.notes == ()
        assert list(second.recorded) == ["one", "two"]
        assert_allclose(second.recorded["two"], THETA)
        assert_allclose(second.theta, THETA)
    with at(arm, port, theta=np.zeros(3)) as third:
        assert_allclose(third.theta, np.zeros(3))
    assert [file.suffix for file in home.iterdir()] == [".json"]


def test_nothing_is_kept_unless_it_is_asked_for(arm: Arm, home: Path, port: int) -> None:
    addresses = set()
    for _ in range(2):
        with Viewer(arm, port=port, open_browser=False) as viewer:
            record(viewer, "one")
            addresses.add(viewer.url)
    assert len(addresses) == 2
    assert not home.exists()
    with pytest.raises(InputError, match="give port=, as in port=8000"):
        Viewer(arm, open_browser=False, keep=True)


def test_arms_have_their_own(arm: Arm, home: Path, port: int) -> None:
    with at(arm, port) as viewer:
        record(viewer, "one")
    with at(load_arm("rr_planar"), port) as viewer:
        assert viewer.recorded == {}
        assert viewer.notes == ()
    with at(arm, port) as viewer:
        assert list(viewer.recorded) == ["one"]


def test_a_port_in_use_leaves_what_is_kept_alone(arm: Arm, home: Path, port: int) -> None:
    with at(arm, port) as viewer:
        record(viewer, "one")
        until_kept(home)
        before = {file.name: file.read_bytes() for file in home.iterdir()}
        with pytest.raises(InputError, match="in use"):
            at(arm, port)
        assert {file.name: file.read_bytes() for file in home.iterdir()} == before


# an arm that has changed ------------------------------------------------------------------------------


def test_what_no_longer_fits_the_arm_stays_on_the_disk(tmp_path: Path, home: Path, port: int) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(ARM)
    with at(load_arm(path, tip="tool0"), port, theta=(0.4, 1.2, 0.1)) as viewer, Page(viewer) as page:
        page.ask(type="record", name="bent")
        page.ask(type="joint", name="pitch", value=0.3)
        page.ask(type="record", name="low")
    path.write_text(ARM.replace('upper="1.5"', 'upper="0.5"'))
    with at(load_arm(path, tip="tool0"), port) as viewer:
        assert list(viewer.recorded) == ["low"]
        (note,) = viewer.notes
        assert re.search(r"one does not fit: the pose 'bent': pitch = 68.7549° is outside", note)
        assert visit(viewer).latest["notice"] == {"type": "notice", "words": note, "wrong": False}
    (old,) = home.glob("*.old.json")
    assert poses_in(old) == ["bent", "low"]
    path.write_text(ARM.replace('name="pitch"', 'name="elbow"'))
    with at(load_arm(path, tip="tool0"), port) as viewer:
        assert viewer.recorded == {}
        assert "the list moves yaw, pitch, slide; small has yaw, elbow, slide" in viewer.notes[0]
    assert poses_in(old) == ["bent", "low"]
    (later,) = home.glob("*.old2.json")
    assert poses_in(later) == ["low"]


def test_poses_left_out_by_one_load_after_another_are_on_the_disk_still(tmp_path: Path, home: Path, port: int) -> None:
    """What an earlier load has set aside, a later one neither replaces nor stops being kept for."""
    path = tmp_path / "arm.urdf"
    path.write_text(ARM)
    with at(load_arm(path, tip="tool0"), port, theta=(0.4, 1.2, 0.1)) as viewer:
        record(viewer, "bent")
        viewer.show((0.4, 0.3, 0.1))
        record(viewer, "low")
        for upper in ("0.5", "0.51", "0.2", "0.21"):
            path.write_text(ARM.replace('upper="1.5"', f'upper="{upper}"'))
            words = viewer.load(load_arm(path, tip="tool0"))
            assert any("what was kept is in" in word for word in words) == (upper in ("0.5", "0.2"))
        viewer.show((0.4, 0.1, 0.1))
        record(viewer, "flat")
    assert poses_in(kept(home, ".json")) == ["flat"]
    assert {name for file in home.glob("*.old*.json") for name in poses_in(file)} == {"bent", "low"}


# files that cannot be used ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    ["", "[]", "{", "nonsense", '{"joints": 1, "poses": [], "theta": []}', '{"joints":["yaw","pitch","slide"]}',
     '{"joints":["yaw","pitch","slide"],"poses":[{"name":"a","theta":[0,0,1e999]}],"theta":[0,0,0]}',
     '{"joints":["yaw"],"poses":[],"theta":[0,0]}', "[" * 60_000, " " * 70_000],
)  # fmt: skip
def test_a_damaged_list_is_told_and_set_aside(arm: Arm, home: Path, port: int, text: str) -> None:
    at(arm, port).close()
    kept(home, ".json").write_text(text)
    with at(arm, port) as viewer:
        assert viewer.recorded == {}
        assert "are not taken" in viewer.notes[0]
        assert "\n" not in viewer.notes[0]
        record(viewer, "one")
    (old,) = home.glob("*.old.json")
    assert old.read_text() == text
    with at(arm, port) as viewer:
        assert list(viewer.recorded) == ["one"]


def test_without_a_folder_the_view_is_served_all_the_same(
    arm: Arm, home: Path, port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    home.parent.mkdir()
    home.write_text("a file where the folder should be")
    with at(arm, port) as viewer:
        record(viewer, "one")
        assert "will not be kept" in viewer.notes[0]
    monkeypatch.delenv("XDG_STATE_HOME")
    monkeypatch.setenv("HOME", "nowhere")
    with pytest.raises(InputError, match="no home folder"):
        state_folder()


def test_where_state_is_kept(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    for given, system, expected in (
        ("/x", "linux", "/x/twistarm"),
        ("relative", "linux", f"{tmp_path}/.local/state/twistarm"),
        ("", "linux", f"{tmp_path}/.local/state/twistarm"),
        ("/x", "darwin", f"{tmp_path}/Library/Application Support/twistarm"),
    ):
        monkeypatch.setenv("XDG_STATE_HOME", given)
        monkeypatch.setattr("sys.platform", system)
        assert str(state_folder()) == expected
