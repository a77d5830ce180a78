"""Golden files: an unchanged arm is the same, the changes of another are listed."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from baked_arms import sealed
from twistarm import Arm, assert_arm, compare, freeze, load_arm
from twistarm.cli.application import run
from twistarm.support.errors import ComparisonError, DescriptionError, InputError
from urdf_text import joint, robot, write

LINKS = ("base_link", "upper", "fore", "hand", "tool0")
ARM = {
    "shoulder": {"xyz": "0 0 0.5", "inside": '<axis xyz="0 1 0"/>'},
    "elbow": {"xyz": "0.4 0 0", "inside": '<axis xyz="0 1 0"/>'},
    "wrist_roll": {"xyz": "0.3 0 0", "inside": '<axis xyz="1 0 0"/>'},
    "mount": {"xyz": "0.1 0 0", "kind": "fixed"},
}


def build(folder: Path, **changes: dict[str, str]) -> Path:
    parts = [
        joint(name, parent, child, **{**ARM[name], **changes.get(name, {})})
        for name, parent, child in zip(ARM, LINKS[:-1], LINKS[1:], strict=True)
    ]
    return write(folder, robot(*parts, links=LINKS, name="ours"))


@pytest.fixture
def golden(tmp_path: Path) -> Path:
    path = tmp_path / "ours.golden.json"
    freeze(load_arm(build(tmp_path)), path)
    return path


CHANGES = {
    "the elbow moved": ({"elbow": {"xyz": "0.412 0 0"}}, ["elbow 12 mm x"]),
    "the elbow turned": ({"elbow": {"rpy": "0 0 0.01745329251994329577"}}, ["elbow 1° z"]),
    "an axis points the other way": ({"elbow": {"inside": '<axis xyz="0 -1 0"/>'}}, ["elbow reversed"]),
    "the tool turned": ({"mount": {"rpy": "1.5707963267948966 0 0"}}, ["tool0 90° x"]),
    "a limit narrowed": (
        {"wrist_roll": {"inside": '<axis xyz="1 0 0"/><limit lower="-0.5" upper="1" velocity="2" effort="3"/>'}},
        ["wrist_roll limits [-1, [-0.5,"],
    ),
    "a limit widened and a rate lowered": (
        {"elbow": {"inside": '<axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="1" effort="0"/>'}},
        ["elbow limits [-1, [-2,", "velocity elbow 2 1", "effort elbow 3 not given"],
    ),
    "a joint became continuous": (
        {"wrist_roll": {"kind": "continuous"}},
        ["wrist_roll revolute continuous", "wrist_roll limits", "velocity wrist_roll", "effort wrist_roll"],
    ),
    "a joint became fixed": ({"wrist_roll": {"kind": "fixed", "inside": ""}}, ["wrist_roll gone"]),
}
"""Words of each change: the culprit and the numbers."""


def said(changes: tuple[str, ...], expected: list[str]) -> bool:
    """Whether each change holds the words that are expected of it, and there are no others."""
    return len(changes) == len(expected) and all(
        set(words.split()) <= set(change.replace(":", "").split())
        for change, words in zip(changes, expected, strict=True)
    )


@pytest.mark.parametrize("case", CHANGES)
def test_a_changed_arm_is_described(case: str, golden: Path, tmp_path: Path) -> None:
    changes, expected = CHANGES[case]
    difference = compare(load_arm(build(tmp_path, **changes)), golden)
    assert said(difference.changes, expected), difference.changes
    with pytest.raises(ComparisonError, match="ours"):
        difference.require()


INERTIAL = (
    '<inertial><origin xyz="{com}" rpy="{rpy}"/><mass value="{mass}"/>'
    '<inertia ixx="{ixx}" iyy="{iyy}" izz="0.003" ixy="0" ixz="0" iyz="0"/></inertial>'
)
USUAL_BODY = {"com": "0.1 0 0", "rpy": "0 0 0", "mass": "0.099", "ixx": "0.001", "iyy": "0.002"}


def weighing(folder: Path, name: str, **changes: str) -> Arm:
    """The arm, its link `fore` with a mass; none where the mass is empty."""
    path = build(folder)
    body = INERTIAL.format(**{**USUAL_BODY, **changes}) if changes.get("mass") != "" else ""
    text = path.read_text().replace('<link name="fore"/>', f'<link name="fore">{body}</link>')
    return load_arm(write(folder, text, name))


BODIES = {
    "a mass": ({"mass": "99"}, ["mass fore 0.099 99"]),
    "a centre": ({"com": "0.103 0.004 0"}, ["centre fore [0.1, [0.103, 0.004,"]),
    "an inertia": ({"ixx": "0.0013"}, ["inertia fore [0.001, [0.0013,"]),
    "no mass": ({"mass": ""}, ["fore gone"]),
    "the same, turned": ({"rpy": "0 0 1.5707963267948966", "ixx": "0.002", "iyy": "0.001"}, []),
}


@pytest.mark.parametrize("case", BODIES)
def test_a_changed_body_is_described(case: str, tmp_path: Path) -> None:
    changes, expected = BODIES[case]
    freeze(weighing(tmp_path, "old.urdf"), tmp_path / "g.json")
    difference = compare(weighing(tmp_path, "new.urdf", **changes), tmp_path / "g.json")
    assert said(difference.changes, expected), difference.changes
    assert compare(load_arm(tmp_path / "old.urdf"), tmp_path / "new.urdf").same == difference.same


def test_a_golden_file_says_what_it_does_not_cover(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arm, path = weighing(tmp_path, "arm.urdf"), tmp_path / "g.json"
    assert run(["freeze", str(tmp_path / "arm.urdf"), "-o", str(path)]) == 0
    content = json.loads(path.read_text())
    assert f"not covered: {', '.join(content['not_covered'])}\n" in capsys.readouterr().out
    assert content["bodies"]["fore"]["mass"] == 0.099
    path.write_text(sealed(content | {"bodies": None}))
    difference = compare(arm, path)
    assert difference.same
    assert [note.partition(":")[0] for note in difference.notes] == ["masses were not compared"]
    assert compare(load_arm(build(tmp_path)), path).notes == (), "an arm without masses"


def test_an_edited_golden_file_is_refused(golden: Path, tmp_path: Path) -> None:
    golden.write_text(golden.read_text().replace("0.4", "0.5", 1))
    with pytest.raises(DescriptionError, match="edited or damaged since it was written"):
        compare(load_arm(build(tmp_path)), golden)


@pytest.mark.parametrize("text", ["[" * 100_000, "frozen", '{"format": "twistarm golden", "base": "base_link"}'])
def test_what_is_no_golden_file(text: str, golden: Path, tmp_path: Path) -> None:
    arm = load_arm(build(tmp_path))
    golden.write_text(text)
    with pytest.raises(DescriptionError, match="twistarm freeze ARM -o FILE"):
        compare(arm, golden)
    golden.unlink()
    with pytest.raises(DescriptionError, match="no such file"):
        compare(arm, golden)
    with pytest.raises(InputError, match="does not exist"):
        freeze(arm, tmp_path / "nowhere" / "g.json")
    with pytest.raises(InputError, match="against"):
        compare(arm, 3)  # type: ignore[arg-type]


def test_the_helper_for_a_teams_own_tests(golden: Path, tmp_path: Path) -> None:
    assert assert_arm(build(tmp_path), against=golden).name == "ours"
    with pytest.raises(AssertionError, match="joint elbow moved 12 mm along x"):
        assert_arm(build(tmp_path, elbow={"xyz": "0.412 0 0"}), against=golden)


def turning(folder: Path, base: str, tool: str = "0.1 0.05 0", **rpy: str) -> Arm:
    """Axes z, y and x, the arm standing at `base`; `rpy` turns what joint of that name carries."""
    links = ("base_link", "l1", "l2", "l3", "tool0")
    places = {"a": (base, "0 0 1"), "b": ("0.1 0 0.3", "0 1 0"), "c": ("0.2 0 0.1", "1 0 0")}
    parts = [
        joint(name, links[i], links[i + 1], xyz=xyz, rpy=rpy.get(name, "0 0 0"), inside=f'<axis xyz="{axis}"/>')
        for i, (name, (xyz, axis)) in enumerate(places.items())
    ]
    mount = joint("mount", "l3", "tool0", kind="fixed", xyz=tool)
    return load_arm(write(folder, robot(*parts, mount, links=links)))


@pytest.mark.parametrize("base", ["0 0 0.2", "1 -2 0.7"])
@pytest.mark.parametrize("lifted", [0.0, 0.03])
def test_what_a_turned_origin_carries(base: str, lifted: float, tmp_path: Path) -> None:
    """Joint b's own axis stays, and c's turns about b by 0.3 rad, wherever the base is.

    c's axis goes through (0, 0, 0.1) beyond b and is nearest the tool at (0.3, 0, 0.1). A tool that is lifted on its
    mount does not just ride on c: its own motion is a change.
    """
    freeze(turning(tmp_path, base), tmp_path / "g.json")
    now = turning(tmp_path, base, tool=f"0.1 0.05 {lifted}", b="0 0.3 0")
    R = np.array([[np.cos(0.3), 0, np.sin(0.3)], [0, 1, 0], [-np.sin(0.3), 0, np.cos(0.3)]])
    at = np.array([0.3, 0.0, 0.1])
    moved = R @ at - at
    if lifted:  # then c has turned by the least motion: its line's distance from where it was nearest
        gap = R @ [0.0, 0.0, 0.1] - at
        moved = gap - R[:, 0] * (R[:, 0] @ gap)
    tool = R @ [0.3, 0.05, 0.1 + lifted] - [0.3, 0.05, 0.1]
    expected = ["c 17.2° y", f"c {told(moved)}", f"tool0 {told(tool)}", "tool0 17.2° y"]
    assert said(compare(now, tmp_path / "g.json").changes, expected if lifted else expected[:2])


def told(shift: np.ndarray) -> str:
    """A displacement as the words give it."""
    unit = shift / np.linalg.norm(shift)
    return f"{1e3 * np.linalg.norm(shift):.4g} mm along ({', '.join(f'{x:.2f}' for x in unit)})"


MOTORS = """source = "arm.urdf"
[actuators.lift]
ratio = {{ shoulder = {shoulder}, elbow = {elbow} }}
offset = {offset}
unit = "{unit}"
ticks_per_turn = {ticks}
limits = {{ velocity = {velocity} }}
[actuators.{name}]
ratio = {{ wrist_roll = 20.0 }}
"""
USUAL = {"shoulder": 40, "elbow": -2, "offset": 0.1, "unit": "tick", "ticks": 4096, "velocity": 300, "name": "roll"}

MOTOR_CHANGES = {
    "a ratio": ({"shoulder": 42}, ["lift shoulder 40 42"]),
    "an offset": ({"offset": -0.1}, ["lift offset 0.1 -0.1"]),
    "what the drive counts": ({"unit": "turn"}, ["lift tick turn"]),
    "a limit": ({"velocity": 200}, ["lift velocity 300 200"]),
    "a name": ({"name": "twist"}, ["roll gone", "twist new"]),
}


def driven(folder: Path, **changes: object) -> Arm:
    build(folder)
    (folder / "arm.toml").write_text(MOTORS.format(**USUAL | changes))
    return load_arm(folder / "arm.toml")


@pytest.mark.parametrize("case", MOTOR_CHANGES)
def test_changed_motors_are_named(case: str, tmp_path: Path) -> None:
    changes, expected = MOTOR_CHANGES[case]
    freeze(driven(tmp_path), tmp_path / "g.json")
    difference = compare(driven(tmp_path, **changes), tmp_path / "g.json")
    assert said(difference.changes, expected), difference.changes
    assert difference.notes == ()


def test_two_designs_side_by_side(tmp_path: Path) -> None:
    for folder in ("old", "new"):
        (tmp_path / folder).mkdir()
    old, new = build(tmp_path / "old"), build(tmp_path / "new", elbow={"xyz": "0.45 0 0"})
    difference = compare(load_arm(new), old)
    assert difference.changes == compare(load_arm(new), load_arm(old)).changes
    assert [change for change in difference.changes if "elbow" in change] == ["joint elbow moved 50 mm along x"]
    assert compare(load_arm(old), old).same
    assert run(["check", str(new), "--against", str(old)]) == 1
