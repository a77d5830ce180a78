"""Which SRDF beside a description is used, and which never silently."""

from __future__ import annotations

from pathlib import Path

import pytest

from twistarm import Arm, DescriptionError, InputError, load_arm
from urdf_text import two_joints, write

STATE = '<group_state name="{}" group="g"><joint name="a" value="0.1"/><joint name="b" value="0.2"/></group_state>'


def srdf(folder: Path, name: str = "tiny", state: str = "home", file: str = "arm.srdf") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    return write(folder, f'<robot name="{name}">{STATE.format(state)}</robot>', file)


def codes(arm: Arm) -> list[str]:
    return [finding.code for finding in arm.findings]


@pytest.fixture
def urdf(tmp_path: Path) -> Path:
    folder = tmp_path / "workspace" / "arm_description" / "urdf"
    folder.mkdir(parents=True)
    return write(folder, two_joints())


PLACES = {
    "in the folder": ".",
    "in config below": "config",
    "in srdf one above": "../srdf",
    "in a MoveIt package beside the description's": "../../arm_moveit_config/config",
    "in a MoveIt package beside the folder": "../arm_moveit_config/config",
}


@pytest.mark.parametrize("place", PLACES)
def test_found_where_packages_keep_it(place: str, urdf: Path) -> None:
    srdf(urdf.parent / PLACES[place])
    arm = load_arm(urdf)
    assert arm.named_states["home"].tolist() == [0.1, 0.2]
    assert codes(arm) == ["srdf-found", "ready-named"]


def test_another_robots_is_left_alone(urdf: Path) -> None:
    srdf(urdf.parent, name="other")
    srdf(urdf.parents[2] / "elsewhere")
    arm = load_arm(urdf)
    assert (codes(arm), dict(arm.named_states)) == ([], {})


def test_of_several_none_is_used_and_that_is_said(urdf: Path) -> None:
    first, second = srdf(urdf.parent), srdf(urdf.parents[1] / "config", state="stowed", file="old.srdf")
    arm = load_arm(urdf)
    assert dict(arm.named_states) == {}
    assert codes(arm) == ["companion-not-used"]
    assert "'arm.srdf', '../config/old.srdf'" in arm.findings[0].what
    assert list(load_arm(urdf, srdf=second).named_states) == ["stowed"]
    assert list(load_arm(urdf, srdf=str(first)).named_states) == ["home"]


def test_a_broken_one_is_a_warning_beside_and_an_error_by_name(urdf: Path) -> None:
    broken = write(urdf.parent, "<robot name='tiny'><group/></robot>", "arm.srdf")
    arm = load_arm(urdf)
    assert codes(arm) == ["companion-doubtful"]
    with pytest.raises(DescriptionError, match="arm.srdf:1: group: "):
        load_arm(urdf, srdf=broken)


def test_a_xacro_is_never_run_unasked(urdf: Path) -> None:
    text = f'<robot name="tiny" xmlns:xacro="http://www.ros.org/wiki/xacro">{STATE.format("home")}</robot>'
    path = write(urdf.parent, text, "arm.srdf.xacro")
    assert dict(load_arm(urdf).named_states) == {}
    assert list(load_arm(urdf, srdf=path).named_states) == ["home"]


def test_one_that_is_named_wins_and_may_be_another_robots(urdf: Path) -> None:
    srdf(urdf.parent)
    other = srdf(urdf.parents[2] / "elsewhere", name="other", state="stowed")
    arm = load_arm(urdf, srdf=other)
    assert list(arm.named_states) == ["stowed"]
    assert codes(arm) == ["companion-doubtful", "srdf-found", "ready-named"]
    assert "'other'" in arm.findings[0].what
    toml = write(urdf.parent, 'source = "arm.urdf"\nsrdf = "../../elsewhere/arm.srdf"', "arm.toml")
    assert list(load_arm(toml).named_states) == ["stowed"]
    assert list(load_arm(toml, srdf=urdf.parent / "arm.srdf").named_states) == ["home"]


def test_what_is_no_file_is_refused(urdf: Path) -> None:
    toml = write(urdf.parent, 'source = "arm.urdf"\nsrdf = "no.srdf"', "arm.toml")
    for source, given in ((urdf, {"srdf": "no.srdf"}), (toml, {})):
        with pytest.raises(DescriptionError, match=r"no\.srdf"):
            load_arm(source, **given)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="srdf must be .* got 3"):
        load_arm(urdf, srdf=3)  # type: ignore[arg-type]


def test_names_that_are_not_there_are_one_warning(urdf: Path) -> None:
    text = (
        '<robot name="tiny"><virtual_joint name="v" child_link="base_link"/>'
        '<group name="g"><joint name="v"/><joint name="a"/><joint name="elbow"/></group>'
        '<disable_collisions link1="upper" link2="hand"/><disable_collisions link1="upper" link2="base_link"/></robot>'
    )
    arm = load_arm(urdf, srdf=write(urdf.parent, text, "arm.srdf"))
    assert arm.disabled_collisions == {("base_link", "upper")}
    (finding,) = [finding for finding in arm.findings if finding.code == "companion-doubtful"]
    assert "'elbow', 'hand'" in finding.what
