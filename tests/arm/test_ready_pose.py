"""The posture that programs start from: a named one, else round numbers, judged by Pinocchio and plain arithmetic."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import catalogue
from twistarm import Arm, Scene, arm_from_screws, joints, load_arm
from urdf_text import joint, robot, two_joints, write

TURNING = '<axis xyz="{}"/><limit lower="{}" upper="{}" velocity="1" effort="1"/>'
# Axes of the usual six joints: base turn, shoulder, elbow, and a wrist of roll, pitch, roll.
ELBOW = ("0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "1 0 0")


def elbow(folder: Path, **shapes: str) -> Arm:
    """Six joints in a row along x above a column of 0.3 m, which end in `tool0`, with shapes on links."""
    links = ("base", *(f"link{i}" for i in range(6)))
    places = ["0 0 0.1", "0 0 0.2", "0.3 0 0", "0.15 0 0", "0.15 0 0", "0.05 0 0"]
    parts = [
        joint(f"j{i}", links[i], links[i + 1], inside=TURNING.format(axis, -2.5, 2.5), xyz=xyz)
        for i, (axis, xyz) in enumerate(zip(ELBOW, places, strict=True))
    ]
    text = robot(*parts, joint("end", "link5", "tool0", "fixed", xyz="0.1 0 0"), links=(*links, "tool0"))
    for link, shape in shapes.items():
        text = text.replace(f'<link name="{link}"/>', f'<link name="{link}">{shape}</link>')
    return load_arm(write(folder, text))


def with_state(folder: Path, *names: str) -> Path:
    """The two-joint arm with named states (0.1, 0.2), (0.2, 0.4) and so on."""
    states = "".join(
        f'<group_state name="{name}" group="arm"><joint name="a" value="{0.1 * k}"/><joint name="b" value="{0.2 * k}"/>'
        "</group_state>"
        for k, name in enumerate(names, 1)
    )
    write(folder, f'<robot name="tiny">{states}</robot>', "arm.srdf")
    return write(folder, two_joints())


@pytest.mark.parametrize(
    ("names", "taken"),
    [
        (("folded", "Home"), "Home"),
        (("home", "READY"), "READY"),
        (("stowed", "rest", "Default"), "Default"),
        (("at home", "homed", "not ready"), None),
    ],
)
def test_a_usual_name_is_taken_and_said(names: tuple[str, ...], taken: str | None, tmp_path: Path) -> None:
    arm = load_arm(with_state(tmp_path, *names))
    said = [one for one in arm.findings if one.code == "ready-named"]
    if taken is None:
        assert not said
        assert np.array_equal(arm.ready, arm.computed_ready)
        return
    k = names.index(taken) + 1
    assert np.allclose(arm.ready, [0.1 * k, 0.2 * k])
    (one,) = said
    assert repr(taken) in one.what
    assert (one.place.file, one.place.name) == ("arm.srdf", taken)
    assert "[poses.ready]" in one.remedy


def test_a_singular_home_is_not_where_programs_start(tmp_path: Path) -> None:
    """Stretched arms are singular: `home` gives way to a regular `rest`, or to the computed pose. A `ready` stays."""
    states = {"home": [0.0, 0.0], "rest": [0.0, 1.0]}
    arm = replace(hinges((0, 0, 1), (0, 0, 1)), named_states={name: np.array(at) for name, at in states.items()})
    assert arm.ready_name == "rest"
    home = {"home": arm.named_states["home"]}
    assert replace(arm, named_states=home).ready_name is None
    assert replace(arm, named_states={**home, "Ready": home["home"]}).ready_name == "Ready"


@pytest.mark.parametrize("bound", [0.02, 0.3])
def test_it_is_regular_in_the_narrowest_limits(bound: float) -> None:
    """A stretched arm whose elbow hardly bends: round numbers would be zero."""
    arm = hinges((0, 0, 1), (0, 0, 1))
    lower, upper = np.array([-1.0, -bound]), np.array([1.0, bound])
    limited = replace(arm, limits=arm.limits.with_({"lower": lower, "upper": upper}, arm.joint_names))
    assert abs(limited.ready[1]) >= 0.5 * bound


def test_the_arm_tomls_own_ready_needs_no_word(tmp_path: Path) -> None:
    with_state(tmp_path, "ready")
    arm = load_arm(write(tmp_path, 'source = "arm.urdf"\n[poses.ready]\na = 0.5\nb = 0.5\n', "arm.toml"))
    assert arm.ready.tolist() == [0.5, 0.5]
    assert "ready-named" not in {one.code for one in arm.findings}


def test_round_numbers_off_the_limits(catalogue_arm: Arm) -> None:
    """Whole multiples of 5° or 1 cm, a tenth of the range from each bound."""
    arm, theta = catalogue_arm, catalogue_arm.computed_ready
    steps = np.where(np.array(arm.units) == "m", 0.01, np.radians(5.0))
    assert np.abs(theta / steps - np.round(theta / steps)).max() < 1e-9
    lower, upper = arm.limits.lower, arm.limits.upper
    tenth = np.where(np.isfinite(upper - lower), 0.1 * (upper - lower), 0.0)
    assert ((theta >= lower + tenth - 1e-12) & (theta <= upper - tenth + 1e-12)).all()


def test_it_stands_on_its_base_with_the_tool_before_it_and_moves_every_way(catalogue_arm: Arm) -> None:
    arm, theta = catalogue_arm, catalogue_arm.computed_ready
    g, _, J = arm.by_pinocchio(theta)
    heights = [arm.pose(theta, joint.child)[2, 3] for joint in arm.description.chain(arm.base, arm.tip_link)]  # type: ignore[union-attr]
    assert min(heights) > -1e-6
    assert np.linalg.norm(g[:2, 3]) > 0.2 * arm.reach
    prismatic = np.array(arm.units) == "m"
    scaled = np.linalg.svd(J / np.array([arm.reach] * 3 + [1.0] * 3)[:, None] * np.where(prismatic, arm.reach, 1.0))[1]
    found = arm.manipulability(arm.random_theta(np.random.default_rng(1), 300))
    rank = int((found.singular_values > 1e-3 * found.singular_values[..., :1]).sum(-1).max())
    assert scaled[0] / scaled[rank - 1] < 2.2 * found.condition_in(rank).min()


def test_the_usual_six_joints_stand_as_one_parks_them(tmp_path: Path) -> None:
    """Base turn and rolls at zero, the arm in the plane y = 0, the elbow above the line from shoulder to tool."""
    arm = elbow(tmp_path)
    theta = arm.ready
    assert theta[[0, 3, 5]].tolist() == [0.0, 0.0, 0.0]
    corners = np.array([arm.pose(theta, f"link{i}")[:3, 3] for i in (1, 2)] + [arm.fk(theta)[:3, 3]])
    assert np.abs(corners[:, 1]).max() < 1e-12
    shoulder, bend, tool = corners[:, [0, 2]]
    assert tool[0] > 0.15
    assert tool[1] > 0.05
    way = (bend[0] - shoulder[0]) / (tool[0] - shoulder[0])
    assert bend[1] > shoulder[1] + way * (tool[1] - shoulder[1]) + 0.05


@pytest.mark.parametrize("name", ["panda", "rover_arm"])
def test_last_bits_and_engines_do_not_choose(name: str) -> None:
    """The same pose from screws that differ by rounding, as another machine or engine might have them."""
    arm = catalogue.load(name)
    for seed in range(6):
        noise = 1e-13 * np.random.default_rng(seed).standard_normal(arm.screws.shape)
        other = replace(arm, screws=arm.screws + noise, named_states={})
        assert np.array_equal(other.ready, arm.computed_ready)


def test_shapes_keep_apart(tmp_path: Path) -> None:
    """A ball of 6 cm at the tool, and where it would be one of 20 cm on the base: it must go elsewhere."""
    ball = '<collision><origin xyz="{} {} {}"/><geometry><sphere radius="{}"/></geometry></collision>'
    free = elbow(tmp_path)
    there = free.fk(free.ready)[:3, 3]
    arm = elbow(tmp_path, tool0=ball.format(0, 0, 0, 0.06), base=ball.format(*there, 0.2))
    assert np.linalg.norm(arm.fk(arm.ready)[:3, 3] - there) > 0.26


@pytest.mark.parametrize("name", ["panda", "kinova"])
def test_it_is_free_in_a_scene(name: str) -> None:
    """By whole meshes, and with pairs that are found without this pose: STL files, and DAE files that are capsules."""
    arm = catalogue.load(name)
    zero = np.clip(np.zeros(arm.n), arm.limits.lower, arm.limits.upper)
    scene = Scene(replace(arm, named_states={"ready": zero}, disabled_collisions=frozenset()))
    scene.add_plane()
    assert scene.contacts(arm.computed_ready) == ()


def hinges(*axes: tuple[float, float, float], slides: int = 0) -> Arm:
    columns = [joints.revolute(axis, [0.2 * k, 0, 0.1]) for k, axis in enumerate(axes)]
    columns += [joints.prismatic(np.eye(3)[k]) for k in range(slides)]
    home = np.eye(4)
    home[:3, 3] = 0.2 * len(axes), 0.0, 0.1
    return arm_from_screws(np.hstack(columns), home)


ARMS = {
    "one hinge": hinges((0, 1, 0)),
    "a gantry": hinges(slides=3),
    "axes askew": hinges((1, 2, 3), (3, -1, 2), (0, 1, 1), (2, 0, -1), (1, 1, 1)),
    "thirty-two joints": hinges(*[(0, 1, 0), (1, 0, 0)] * 16),
    "more than the core holds": hinges(*[(0, 1, 0), (0, 0, 1)] * 20),
}
BOUNDS = {
    "no limits": (-np.inf, np.inf),
    "without zero": (0.4, 2.9),
    "none at all": (0.7, 0.7),
    "one side": (-0.2, np.inf),
}


@pytest.mark.parametrize("bounds", BOUNDS.values(), ids=BOUNDS)
@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_every_kind_of_arm_has_one_inside_its_limits(arm: Arm, bounds: tuple[float, float]) -> None:
    lower, upper = (np.full(arm.n, bound) for bound in bounds)
    limits = arm.limits.with_({"lower": lower, "upper": upper}, arm.joint_names)
    limited = replace(arm, limits=limits)
    assert np.isfinite(limited.ready).all()
    assert limits.contains(limited.ready)
    if np.isfinite(upper - lower).all() and (upper > lower).all():
        tenth = 0.1 * (upper - lower) - 1e-12
        assert ((limited.ready >= lower + tenth) & (limited.ready <= upper - tenth)).all()


def test_two_links_in_a_plane_are_bent() -> None:
    """Stretched, they still turn and slide the tool two ways, but cannot bring it nearer."""
    arm = hinges((0, 0, 1), (0, 0, 1))
    assert arm.ready[0] == 0.0
    assert abs(np.sin(arm.ready[1])) > 0.5


def test_a_mimic_and_a_locked_joint(tmp_path: Path) -> None:
    text = two_joints(inside='<mimic joint="b" multiplier="2"/>')
    arm = load_arm(write(tmp_path, text))
    assert arm.n == 1
    assert arm.limits.contains(arm.ready)
    assert load_arm("rover_arm", locked_joints={"shoulder": -0.5}).computed_ready.shape == (4,)
