"""Baked arms: the same arm with the same answers, its limits, what it cannot be asked, and files that are none."""

from __future__ import annotations

import json
import pickle
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import twistarm
from baked_arms import TOL, assert_same, bake, sealed
from baked_arms import everything as everything
from twistarm import Arm, ArmBuilder, JointLimits, arm_from_screws, load_arm
from twistarm.arm.baking import MAX_BYTES
from twistarm.support.errors import DescriptionError, InputError, TwistarmError, UnknownNameError
from urdf_text import write

# -- the same arm ------------------------------------------------------------------------------------------------


def assert_same_answers(baked: Arm, arm: Arm) -> None:
    """Against Pinocchio's own account."""
    theta = arm.random_theta(np.random.default_rng(3), 12)
    assert np.array_equal(baked.random_theta(np.random.default_rng(3), 12), theta)
    g, spatial, body = arm.by_pinocchio(theta)
    assert np.abs(baked.fk(theta) - g).max() < TOL
    assert np.abs(baked.spatial_jacobian(theta) - spatial).max() < TOL
    assert np.abs(baked.body_jacobian(theta) - body).max() < TOL
    mine, theirs = baked.manipulability(theta), arm.manipulability(theta)
    assert np.abs(mine.singular_values - theirs.singular_values).max() < TOL


def test_every_arm_of_the_catalogue(catalogue_arm: Arm, tmp_path: Path) -> None:
    baked = load_arm(bake(catalogue_arm, tmp_path))
    assert_same(baked, catalogue_arm)
    assert_same_answers(baked, catalogue_arm)


def test_all_that_an_arm_may_have(everything: Arm, tmp_path: Path) -> None:
    """Followers, a tool of the arm.toml, motors with and without ticks, poses, pairs that need no check."""
    assert everything.moving_names == ("a", "b", "c")
    assert everything.disabled_collisions
    assert everything.actuators is not None
    path = bake(everything, tmp_path)
    baked = load_arm(path)
    assert baked.source == "arm.toml"
    assert_same(baked, everything)
    assert_same_answers(baked, everything)
    assert str(tmp_path) not in path.read_text("utf-8")


def test_baked_again_it_is_the_same_file(everything: Arm, tmp_path: Path) -> None:
    first = bake(everything, tmp_path).read_bytes()
    again = load_arm(tmp_path / "baked.json")
    assert twistarm.bake(again, tmp_path / "again.json").read_bytes() == first
    assert twistarm.bake(pickle.loads(pickle.dumps(again)), tmp_path / "pickled.json").read_bytes() == first


def test_arms_without_a_description(tmp_path: Path) -> None:
    home = np.eye(4)
    home[:3, 3] = (0.3, 0.0, 0.7)
    arm = arm_from_screws(np.eye(6)[:, [2, 3, 5]], home, name="ärmchen", limits={"velocity": 0.1 + 0.2})
    baked = load_arm(bake(arm, tmp_path))
    assert_same(baked, arm)
    with pytest.raises(TwistarmError, match="ärmchen was made from screws, not from a description"):
        _ = baked.pinocchio


def test_a_thread_keeps_its_range(tmp_path: Path) -> None:
    """`usual_half` of a helical coordinate follows from its pitch."""
    arm = ArmBuilder("screw").helical("thread", (0, 0, 1), (0, 0, 0), 0.02).tool(np.eye(4)).build()
    baked = load_arm(bake(arm, tmp_path))
    assert baked.usual_half.tolist() == [50.0]
    assert_same(baked, arm)


def test_a_tool_on_a_baked_arm(rover: Arm, tmp_path: Path) -> None:
    g = np.eye(4)
    g[:3, 3] = (0.0, 0.0, 0.1)
    baked = load_arm(bake(rover, tmp_path)).with_tool(g, "pen")
    assert np.abs(baked.fk(rover.ready) - rover.fk(rover.ready) @ g).max() < TOL
    assert_same(load_arm(bake(baked, tmp_path)), baked)


def test_the_ready_pose_is_the_one_in_the_file(rover: Arm, tmp_path: Path) -> None:
    """It is not found anew: which posture is best may hang on an engine's rounding."""
    path = bake(rover, tmp_path)
    content = json.loads(path.read_text("utf-8"))
    del content["named_states"]["ready"]
    content["ready"] = [0.125, 0.0, 0.5, 0.0, 1.0]
    path.write_text(sealed(content))
    ready = load_arm(path).ready
    assert ready.tolist() == [0.125, 0.0, 0.5, 0.0, 1.0]
    assert not ready.flags.writeable


# -- limits, and what cannot be asked ----------------------------------------------------------------------------


def test_limits_are_taken(rover: Arm, tmp_path: Path) -> None:
    """As for the description; named ones that lie outside are left out and said, and `ready` is found anew."""
    path = bake(rover, tmp_path)
    slower = load_arm(path, limits={"velocity": 0.25})
    assert slower.limits.velocity.tolist() == [0.25] * 5
    assert list(slower.named_states) == list(rover.named_states)
    narrow = load_arm(path, limits={"upper": {"elbow": 1.0}})
    assert list(narrow.named_states) == ["reach"]
    assert [finding.code for finding in narrow.findings] == ["outside-limits"] * 2
    assert narrow.limits.contains(narrow.ready)
    every = load_arm(path, limits=JointLimits.unbounded(5))
    assert np.isinf(every.limits.upper).all()
    write(tmp_path, "joint_limits: {elbow: {max_velocity: 0.125, has_velocity_limits: true}}", "limits.yaml")
    assert load_arm(path, limits=tmp_path / "limits.yaml").limits.velocity[2] == 0.125
    with pytest.raises(UnknownNameError, match="no joint 'elbo' in limits"):
        load_arm(path, limits={"upper": {"elbo": 1.0}})


WISHES = {
    "base": "shoulder_link", "tip": "forearm", "locked_joints": {"elbow": 1.0}, "srdf": "arm.srdf",
    "package_dirs": ["."], "xacro_args": {"reach": 1},
}  # fmt: skip


def test_what_only_a_description_can_be_asked(rover: Arm, tmp_path: Path) -> None:
    path = bake(rover, tmp_path)
    for name, wish in WISHES.items():
        with pytest.raises(InputError, match=f"{name} cannot be given for a baked arm"):
            load_arm(path, **{name: wish})


# -- without Pinocchio and the description -----------------------------------------------------------------------


def test_what_needs_the_description_says_so(rover: Arm, tmp_path: Path) -> None:
    baked = load_arm(bake(rover, tmp_path))
    asked: tuple[Callable[[], object], ...] = (
        lambda: baked.pinocchio,
        lambda: baked.inverse_dynamics(baked.ready),
        lambda: baked.pose(baked.ready, "forearm"),
    )
    for ask in asked:
        with pytest.raises(TwistarmError, match=r"baked without its description \(load 'rover_arm' for that\)"):
            ask()


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
    with pytest.raises(InputError, match=r"no output replaces a \*\.urdf that twistarm did not write"):
        twistarm.bake(rover, link)
    assert description.read_text() == "<robot/>"
