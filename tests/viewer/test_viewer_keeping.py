"""Poses that a page has written into the arm's own arm.toml: all else in the file stays, byte for byte."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from recorded_poses import ask
from twistarm import load_arm
from twistarm.description.companions.data_files import write_pose
from twistarm.support.errors import DescriptionError, InputError
from twistarm.support.files import TEMPORARY
from twistarm.viewer import Viewer
from twistarm.viewer.stage import Stage
from viewer_page import Page

ROBOT = Path(__file__).parents[2] / "robots" / "rover_arm"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """The rover arm's arm.toml with its description beside it."""
    shutil.copytree(ROBOT, tmp_path / "arm")
    return next((tmp_path / "arm").glob("*.toml"))


VALUES = {"slide": 0.1, "shoulder": 0.2, "elbow": -0.3, "wrist_pitch": 0.4, "wrist_roll": 1e-7}


@pytest.mark.parametrize("ending", ["\n", "\r\n"])
@pytest.mark.parametrize("name", ["parked", "in the rack", 'a "b" [c].d', "ä"])
def test_a_new_pose_is_appended_and_the_rest_stays(file: Path, name: str, ending: str) -> None:
    before = file.read_text(encoding="utf-8").replace("\n", ending).encode()
    file.write_bytes(before)
    write_pose(file, name, VALUES, replace=False)
    assert file.read_bytes().startswith(before)
    arm = load_arm(file)
    assert arm.theta_to_dict(arm.named_states[name]) == VALUES


def test_a_pose_that_is_there_is_replaced_only_if_that_is_asked(file: Path) -> None:
    before = file.read_text(encoding="utf-8")
    head = f"{before}\n[ poses . 'old one' ] # of May\n# by hand\nslide = 0.0\nshoulder = 0\nelbow = 0\nwrist_pitch=0\n"
    tail = "wrist_roll = 0\n\n# on the bench\n[poses.bench]\n" + "".join(f"{joint} = 0.5\n" for joint in VALUES)
    file.write_text(head + tail, encoding="utf-8")
    with pytest.raises(InputError, match="already"):
        write_pose(file, "old one", VALUES, replace=False)
    assert file.read_text(encoding="utf-8") == head + tail
    write_pose(file, "old one", VALUES, replace=True)
    written = file.read_text(encoding="utf-8")
    assert written.startswith(f"{before}\n[ poses . 'old one' ] # of May\n")
    assert "# by hand\n" in written
    assert written.endswith(tail[tail.index("\n# on the bench") :])
    assert load_arm(file).theta_to_dict(load_arm(file).named_states["old one"]) == VALUES


@pytest.mark.parametrize("poses", ["poses = {}\n", 'poses.a = { slide = 0 }\nnote = """\n[poses.b]\n"""\n'])
def test_a_file_that_takes_no_table_is_left_alone(tmp_path: Path, poses: str) -> None:
    file = tmp_path / "arm.toml"
    file.write_text(poses, encoding="utf-8")
    with pytest.raises((InputError, DescriptionError)):
        write_pose(file, "a" if "poses.a" in poses else "b", VALUES, replace=True)
    assert file.read_text(encoding="utf-8") == poses
    assert not list(tmp_path.glob(f"*{TEMPORARY}"))


@pytest.mark.parametrize(("host", "offered"), [("127.0.0.1", True), ("0.0.0.0", False)])
def test_the_file_is_offered_on_this_computer_alone(file: Path, host: str, offered: bool) -> None:
    request = {"type": "keep_pose", "name": "parked", "theta": list(VALUES.values()), "replace": False}
    before = file.read_bytes()
    with Viewer(load_arm(file), host=host, open_browser=False) as viewer, Page(viewer) as page:
        page.until(lambda: "keeping" in page.latest)
        assert page.latest["keeping"]["file"] == (str(file.resolve()) if offered else None)
        page.ask(**request)
        if not offered:
            assert "copy the lines" in page.latest["error"]["message"]
            assert file.read_bytes() == before
            return
        page.until(lambda: "parked" in page.latest["keeping"]["names"])
    assert load_arm(file).theta_to_dict(load_arm(file).named_states["parked"]) == VALUES


def test_a_pose_of_another_chain_is_refused(file: Path) -> None:
    arm = load_arm(file, tip=load_arm(file).description.outward_joints()[2].child)  # type: ignore[union-attr]
    stage = Stage(arm)
    stage.keeping.offer(arm)
    before = file.read_bytes()
    job = ask(stage, "keep_pose", name="short", theta=[0.0] * arm.n, replace=False)
    assert job is not None
    with pytest.raises(InputError, match="other joints"):
        job.work(lambda share: None)
    assert file.read_bytes() == before
