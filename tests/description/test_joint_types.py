"""The six joint types from three sources, each against Pinocchio's own model of that joint; planar joints of a URDF."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from joint_arms import DEGREES, KINDS, SOURCES, Reference, by_hand, random_chain
from twistarm import Arm, ArmBuilder, arm_from_screws, crosscheck, load_arm, plan_joint
from twistarm.description.urdf import read_description
from twistarm.support.errors import DescriptionError, UnknownNameError
from twistarm.theory.lower_pairs import lower_pairs
from urdf_text import joint, robot, write

TOL = 1e-12  # Some ten rigid motions within a few metres, in double precision.

MIXED = (
    ("cylindrical", "spherical"),
    ("planar", "helical", "revolute"),
    ("spherical", "prismatic", "spherical"),
    ("helical", "cylindrical", "planar", "spherical", "prismatic", "revolute"),
)
CHAINS = (*((kind,) for kind in KINDS), *MIXED)


def close(a, b, tol=TOL):
    np.testing.assert_allclose(a, b, rtol=0, atol=tol)


@pytest.mark.parametrize("source", SOURCES)
@pytest.mark.parametrize("kinds", CHAINS, ids="-".join)
def test_every_type_from_every_source(kinds: tuple[str, ...], source: str, tmp_path: Path) -> None:
    chain, home = random_chain(kinds, 1)
    arm = SOURCES[source](chain, home, tmp_path)
    assert arm.n == sum(DEGREES[kind] for kind in kinds)
    assert [pair.kind for pair in lower_pairs(arm.screws, arm.coupling.A)] == list(kinds)
    theta = np.random.default_rng(1).uniform(-2, 2, (4, arm.n))
    for ball in (False, True):
        reference = Reference(chain, home, quaternion=ball)
        g, spatial, body = (np.array(parts) for parts in zip(*map(reference, theta), strict=True))
        close(arm.fk(theta), g)
        close(arm.spatial_jacobian(theta), spatial)
        close(arm.body_jacobian(theta), body)
    result = crosscheck(arm, samples=20).require()
    assert 0 <= result.worst("pinocchio") <= TOL


# a thread as a mimic --------------------------------------------------------------------------------------------

LINKS = ("base_link", "upper", "tool0")
WIDE = '<limit lower="-9" upper="9" velocity="1" effort="1"/>'


def mimic(master: str, multiplier: float) -> str:
    return f'{WIDE}<mimic joint="{master}" multiplier="{multiplier}"/>'


def load_two(folder: Path, first: tuple[str, str], second: tuple[str, str], axis: str = "0 0 1") -> Arm:
    """base_link —a→ upper —b→ tool0, b beside a where the axes are parallel."""
    second_axis = f'<axis xyz="{axis}"/>'
    parts = joint("a", "base_link", "upper", *first), joint("b", "upper", "tool0", second[0], second[1] + second_axis)
    return load_arm(write(folder, robot(*parts, links=LINKS)))


def test_the_turn_leads_whichever_comes_first(tmp_path: Path) -> None:
    for first, second, name in (
        (("revolute", WIDE), ("prismatic", mimic("a", 0.01)), "a"),
        (("prismatic", mimic("b", 0.01)), ("revolute", WIDE), "b"),
    ):
        arm = load_two(tmp_path, first, second)
        assert (arm.joint_names, arm.joint_types, arm.units) == ((name,), ("helical",), ("rad",))
        close(arm.fk([2 * np.pi])[:3, 3] - arm.home[:3, 3], [0, 0, 0.02 * np.pi])
        (pair,) = lower_pairs(arm.screws, arm.coupling.A)
        assert (pair.kind, pair.span) == ("helical", 2)
        assert np.isclose(pair.pitch, 0.01, rtol=1e-12)


def test_where_the_slide_leads_the_coordinate_is_metres(tmp_path: Path) -> None:
    arm = load_two(tmp_path, ("prismatic", WIDE), ("revolute", mimic("a", 50.0)))
    assert (arm.joint_types, arm.units) == (("prismatic",), ("m",))
    (pair,) = lower_pairs(arm.screws, arm.coupling.A)
    assert (pair.kind, pair.pitch) == ("helical", pytest.approx(0.02))
    crosscheck(arm, 20).require()


def test_a_follower_across_the_axis_is_no_thread(tmp_path: Path) -> None:
    arm = load_two(tmp_path, ("revolute", WIDE), ("prismatic", mimic("a", 0.01)), axis="1 0 0")
    assert arm.joint_types == ("revolute",)
    assert [pair.kind for pair in lower_pairs(arm.screws, arm.coupling.A)] == ["revolute", "prismatic"]
    crosscheck(arm, 20).require()


def test_a_locked_half_is_no_pair(tmp_path: Path) -> None:
    path = write(
        tmp_path, robot(joint("a", "base_link", "upper"), joint("b", "upper", "tool0", "prismatic"), links=LINKS)
    )
    assert [pair.kind for pair in lower_pairs(*_chain(load_arm(path)))] == ["cylindrical"]
    arm = load_arm(path, locked_joints={"b": 0.3})
    assert [pair.kind for pair in lower_pairs(*_chain(arm))] == ["revolute", "prismatic"]
    crosscheck(arm, 20).require()


def _chain(arm: Arm):
    return arm.screws, arm.coupling.A


# what is built on an arm ----------------------------------------------------------------------------------------


def test_screws_of_any_magnitude(tmp_path: Path) -> None:
    """A column scaled by k moves k times as fast: the native joint's value is k theta."""
    chain, home = random_chain(["cylindrical", "spherical", "planar", "helical"], 4)
    plain = by_hand(chain, home)
    k = np.linspace(0.5, 2.0, plain.n)
    arm = arm_from_screws(plain.screws * k, home)
    theta = np.linspace(-1, 1, arm.n)
    close(arm.fk(theta), Reference(chain, home)(k * theta)[0])
    assert crosscheck(arm, 20).require().worst("pinocchio") <= TOL


def test_pinocchio_reads_the_same_arm_from_the_builder_s_urdf() -> None:
    """Its own reader of URDF, its own planar joint: nothing of ours in between."""
    import pinocchio as pin

    chain, home = random_chain(["planar", "revolute", "cylindrical", "spherical"], 8)
    builder = ArmBuilder("built")
    builder = builder.planar("p", chain[0].axis, chain[0].point, chain[0].R[:, 0])
    builder = builder.revolute("r", chain[1].axis, chain[1].point)
    builder = builder.cylindrical("c", chain[2].axis, chain[2].point)
    builder = builder.spherical("s", chain[3].point, chain[3].R).tool(home)
    model = pin.buildModelFromXML(builder.urdf())
    theta = np.linspace(-1.0, 1.2, 9)
    angle = lambda x: [np.cos(x), np.sin(x)]  # noqa: E731
    q = [*theta[:2], *angle(theta[2]), *angle(theta[3]), *angle(theta[4]), theta[5]]
    q += [number for x in theta[6:] for number in angle(x)]
    data = model.createData()
    pin.framesForwardKinematics(model, data, np.array(q))
    close(builder.build().fk(theta), data.oMf[model.getFrameId("tool", pin.FrameType.BODY)].homogeneous)


# the documented way ---------------------------------------------------------------------------------------------

PAGE = (Path(__file__).parents[2] / "docs" / "joint_types.md").read_text("utf-8")
SNIPPETS = re.findall(r"<!-- (\w+): ([\w ]+) -->\n```xml\n(.*?)```", PAGE, flags=re.S)


@pytest.mark.parametrize(("kind", "names", "text"), SNIPPETS, ids=[kind for kind, _, _ in SNIPPETS])
def test_the_documented_urdf_is_that_joint(kind: str, names: str, text: str, tmp_path: Path) -> None:
    arm = load_arm(
        write(tmp_path, f'<robot name="{kind}">{text}</robot>'), tip=re.findall(r'link name="(\w+)"', text)[-1]
    )
    assert arm.joint_names == tuple(names.split())
    assert [pair.kind for pair in lower_pairs(arm.screws, arm.coupling.A)] == [kind]
    assert [finding for finding in arm.findings if finding.severity != "info"] == []
    assert crosscheck(arm, 50).require().worst("pinocchio") <= TOL


def chain(folder: Path, inside: str = '<axis xyz="0 0 1"/>', *more: str, links: tuple[str, ...] = LINKS) -> Arm:
    """base_link —p→ upper —b→ tool0 with the planar joint p 0.5 m above the base."""
    parts = joint("p", "base_link", "upper", "planar", inside), joint("b", "upper", "tool0"), *more
    return load_arm(write(folder, robot(*parts, links=links)), tip="tool0")


PLANES = {
    "0 0 1": ([1, 0, 0], [0, 1, 0]),
    "0 0 -1": ([1, 0, 0], [0, -1, 0]),
    "0 1 0": ([1, 0, 0], [0, 0, -1]),
    "1 0 0": ([0, 1, 0], [0, 0, 1]),
    "0 3 4": ([1, 0, 0], [0, 0.8, -0.6]),
}
"""In-plane axes by hand: x is (1, 0, 0) where it lies in the plane, y = normal × x."""


@pytest.mark.parametrize("axis", PLANES)
def test_the_axis_is_the_normal(axis: str, tmp_path: Path) -> None:
    arm = chain(tmp_path, f'<axis xyz="{axis}"/>')
    x, y = map(np.array, PLANES[axis])
    assert arm.joint_names == ("p_x", "p_y", "p_rz", "b")
    assert arm.joint_types == ("prismatic", "prismatic", "continuous", "revolute")
    np.testing.assert_allclose(arm.fk([0.3, 0.2, 0, 0])[:3, 3] - arm.home[:3, 3], 0.3 * x + 0.2 * y, atol=1e-15)
    turned = arm.fk([0, 0, 0.7, 0])[:3, :3]
    np.testing.assert_allclose(turned @ np.cross(x, y), np.cross(x, y), atol=1e-15)
    np.testing.assert_allclose(turned @ x, np.cos(0.7) * x + np.sin(0.7) * y, atol=1e-15)
    assert crosscheck(arm, 50).require().worst("pinocchio") <= 1e-12


def test_without_an_axis_the_normal_is_x(tmp_path: Path) -> None:
    """URDF's default axis is (1, 0, 0)."""
    text = robot(joint("p", "base_link", "upper", "planar"), joint("b", "upper", "tool0"), links=LINKS)
    arm = load_arm(write(tmp_path, text.replace('<axis xyz="0 0 1"/>', "", 1)))
    np.testing.assert_allclose(arm.screws[3:, 2], [1, 0, 0], atol=1e-15)


def test_it_is_unbounded_and_nothing_is_missing(tmp_path: Path) -> None:
    arm = chain(tmp_path)
    assert np.isneginf(arm.limits.lower[:3]).all()
    assert np.isposinf(arm.limits.upper[:3]).all()
    assert np.isposinf(arm.limits.velocity[:3]).all()
    assert arm.findings == ()
    motion = plan_joint(arm, [np.zeros(4), np.full(4, 0.1)])
    assert "velocity 0.25 m/s for p_x, p_y" in motion.notes[0]


def test_its_coordinates_take_limits_and_locks(tmp_path: Path) -> None:
    chain(tmp_path)
    arm = load_arm(
        tmp_path / "arm.urdf", limits={"lower": {"p_x": -0.2}, "upper": {"p_x": 0.2}}, locked_joints={"p_y": 0.1}
    )
    assert arm.joint_names == ("p_x", "p_rz", "b")
    assert arm.limits.upper[0] == 0.2
    np.testing.assert_allclose(arm.home[:3, 3], [0, 0.1, 1.0], atol=1e-15)
    with pytest.raises(UnknownNameError) as caught:
        load_arm(tmp_path / "arm.urdf", locked_joints={"p": 0.1})
    assert str(caught.value) == "joint 'p' of tiny is planar; lock its coordinates: 'p_x', 'p_y', 'p_rz'"


def test_the_text_for_other_readers_stays_as_it_was_written(tmp_path: Path) -> None:
    arm = chain(tmp_path)
    assert arm.description is not None
    assert arm.description.text == (tmp_path / "arm.urdf").read_text()
    assert {joint.part_of for joint in arm.description.joints.values()} == {"p", ""}
    left_out = crosscheck(arm, 5).left_out
    assert all("'p'" in left_out[reader] for reader in ("yourdfpy", "pinocchio as written"))


def test_a_coordinates_name_that_is_taken_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match="joint 'p': ") as caught:
        chain(tmp_path, '<axis xyz="0 0 1"/>', joint("p_rz", "upper", "pad"), links=(*LINKS, "pad"))
    assert [finding.code for finding in caught.value.findings] == ["name-unusable"]
    assert "'p_rz'" in str(caught.value)


def test_made_links_are_named_apart_from_those_that_are_there(tmp_path: Path) -> None:
    parts = joint("p", "base_link", "p_x_link", "planar"), joint("q", "p_x_link", "tool0", "planar")
    description = read_description(write(tmp_path, robot(*parts, links=("base_link", "p_x_link", "tool0"))))
    made = ["p_x_link_", "p_y_link", "q_x_link", "q_y_link"]
    assert list(description.links) == ["base_link", "p_x_link", "tool0", *made]
    assert [joint.child for joint in description.chain("base_link", "tool0")] == [
        "p_x_link_", "p_y_link", "p_x_link", "q_x_link", "q_y_link", "tool0",
    ]  # fmt: skip
