"""The arm: shapes, batches, coupling, statics, tools, names. Expected values by Pinocchio's own API or by hand."""

from __future__ import annotations

import copy
import pickle
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import twistarm
from twistarm import Arm, JointLimits, arm_from_screws, joints, load_arm, rotations, screws
from twistarm.control.stream import SimulatedJoints
from twistarm.support.errors import InputError, UnknownNameError
from twistarm.viewer.parts.arm_data import checked_theta
from urdf_text import joint, robot, two_joints, write

ROUNDING = 1e-12  # Some ten products of matrices in double precision.

FOLLOWER = robot(
    joint("a", "base_link", "upper", rpy="0 1.5 0"),
    joint("slide", "upper", "carriage", kind="prismatic", inside='<mimic joint="a" multiplier="0.5" offset="0.1"/>'),
    joint("b", "carriage", "tool0", inside='<mimic joint="slide" multiplier="-2" offset="0.3"/>', xyz="0.1 0 0"),
    links=("base_link", "upper", "carriage", "tool0"),
)
"""One degree of freedom that moves three joints: a slide at half its value, and a follower of that follower."""


def massive(text: str) -> str:
    """The same robot with 2 kg at the origin of every link's own frame, 0.1 m out along x."""
    inertial = (
        '<inertial><origin xyz="0.1 0 0"/><mass value="2"/>'
        '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    for link in ("base_link", "upper", "carriage", "tool0", "finger"):
        text = text.replace(f'<link name="{link}"/>', f'<link name="{link}">{inertial}</link>')
    return text


@pytest.fixture
def follower(tmp_path: Path) -> twistarm.Arm:
    return load_arm(write(tmp_path, FOLLOWER))


def test_home_is_fk_at_zero_and_the_jacobian_of_a_coupled_arm_is_right(follower: twistarm.Arm) -> None:
    assert np.allclose(follower.home, follower.fk([0.0]), atol=ROUNDING)
    theta, h = np.array([0.3]), 1e-6
    difference = (follower.fk(theta + h) - follower.fk(theta - h)) / (2 * h)
    expected = screws.vee(screws.inverse(follower.fk(theta)) @ difference)
    assert np.allclose(follower.body_jacobian(theta)[:, 0], expected, atol=1e-9)
    spatial = screws.vee(difference @ screws.inverse(follower.fk(theta)))
    assert np.allclose(follower.spatial_jacobian(theta)[:, 0], spatial, atol=1e-9)


@pytest.mark.parametrize("shape", [(), (1,), (3,), (2, 3), (0,)])
def test_every_method_takes_leading_axes(shape: tuple[int, ...], rover: twistarm.Arm) -> None:
    theta = rover.random_theta(np.random.default_rng(0), shape)
    n = rover.n
    assert rover.fk(theta).shape == (*shape, 4, 4)
    for J in (rover.spatial_jacobian(theta), rover.body_jacobian(theta), rover.hybrid_jacobian(theta)):
        assert J.shape == (*shape, 6, n)
    assert rover.joint_torques(theta, np.ones(6)).shape == (*shape, n)
    assert rover.inverse_dynamics(theta, payload=1.0).shape == (*shape, n)
    assert rover.manipulability(theta).singular_values.shape == (*shape, min(6, n))
    assert {g.shape for g in rover.poses(theta).values()} == {(*shape, 4, 4)}
    if theta.size:
        first = theta.reshape(-1, n)[-1]
        assert np.array_equal(rover.fk(theta).reshape(-1, 4, 4)[-1], rover.fk(first))


def test_the_hybrid_jacobian_is_pinocchios_local_world_aligned(rover: twistarm.Arm) -> None:
    theta = rover.random_theta(np.random.default_rng(1))
    engine = rover.pinocchio
    pin.computeJointJacobians(engine.model, engine.data, engine.q(theta))
    J = pin.getFrameJacobian(
        engine.model, engine.data, engine.frame_id("tool0"), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    )
    columns = [engine.model.idx_vs[engine.model.getJointId(name)] for name in rover.joint_names]
    assert np.allclose(rover.hybrid_jacobian(theta), J[:, columns], atol=ROUNDING)


def test_joint_torques_are_the_work_of_the_wrench(rover: twistarm.Arm) -> None:
    """τ · θ̇ = F · V^b for every θ̇: virtual work."""
    rng = np.random.default_rng(2)
    theta, F, rate = rover.random_theta(rng), rng.normal(size=6), rng.normal(size=rover.n)
    assert np.isclose(rover.joint_torques(theta, F) @ rate, F @ (rover.body_jacobian(theta) @ rate))


def test_torques_of_followers_do_the_work_that_the_energy_gains(tmp_path: Path) -> None:
    """τ θ̇ = dE/dt with E = Σ ½ m |ċ|² + ½ I |ω|² − m g · c over every body, by differences of poses."""
    arm = load_arm(write(tmp_path, massive(FOLLOWER)), tip="tool0")
    payload, com = 1.5, np.array([0.02, 0.03, 0.1])
    at, rate, push, h = 0.4, 0.8, -1.7, 1e-4

    def energy(t: float) -> float:
        early, now, late = (arm.poses([at + rate * s + 0.5 * push * s * s]) for s in (t - h, t, t + h))
        total = 0.0
        for link, mass, place in [*((link, 2.0, [0.1, 0, 0]) for link in now), ("tool0", payload, com)]:
            before, here, after = ((g[link] @ [*place, 1])[:3] for g in (early, now, late))
            total += 0.5 * mass * np.sum(((after - before) / (2 * h)) ** 2) + 9.81 * mass * here[2]
        for link in now:
            turned = rotations.log(early[link][:3, :3].T @ late[link][:3, :3]) / (2 * h)
            total += 0.5 * 0.01 * float(turned @ turned)
        return float(total)

    power = (energy(h) - energy(-h)) / (2 * h)
    assert np.isclose(arm.inverse_dynamics([at], [rate], [push], payload=(payload, com))[0] * rate, power, rtol=1e-5)


def test_gravity_is_in_axes_of_a_base_that_a_joint_tilts(tmp_path: Path) -> None:
    """The base link lies beyond a joint; gravity along its −z still pulls the payload by its own height."""
    text = robot(joint("a", "base_link", "upper", rpy="0.7 0.3 0"), joint("b", "upper", "tool0", rpy="0.4 1.1 0"))
    arm = load_arm(write(tmp_path, massive(text)), base="upper")
    payload, com, h = 1.5, np.array([0.2, 0.03, 0.1]), 1e-6

    def energy(theta: float) -> float:
        g = arm.poses([theta])["tool0"]
        return float(9.81 * (2.0 * (g @ [0.1, 0, 0, 1])[2] + payload * (g @ [*com, 1])[2]))

    expected = (energy(0.3 + h) - energy(0.3 - h)) / (2 * h)
    assert np.isclose(arm.inverse_dynamics([0.3], payload=(payload, com))[0], expected, rtol=1e-6)


def test_torques_of_the_two_link_arm_of_the_textbook(tmp_path: Path) -> None:
    """MLS §4.2.3, example 4.3, with a payload as a third body at the end of the second link."""
    m, r, length, inertia, payload = (3.0, 2.0), (0.2, 0.15), (0.5, 0.4), (0.05, 0.02), 1.2
    links = "".join(
        f'<link name="{name}"><inertial><origin xyz="{x} 0 0"/><mass value="{mass}"/><inertia ixx="0.01" iyy="{Iz}" '
        f'izz="{Iz}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        for name, mass, x, Iz in zip(("upper", "lower"), m, r, inertia, strict=True)
    )
    joints_ = joint("a", "base_link", "upper", xyz="0 0 0") + joint("b", "upper", "lower", xyz=f"{length[0]} 0 0")
    end = joint("end", "lower", "tool0", kind="fixed", xyz=f"{length[1]} 0 0")
    arm = load_arm(write(tmp_path, robot(links, joints_, end, links=("base_link", "tool0"))))
    alpha = sum(inertia) + m[0] * r[0] ** 2 + m[1] * (length[0] ** 2 + r[1] ** 2)
    alpha += payload * (length[0] ** 2 + length[1] ** 2)
    beta = m[1] * length[0] * r[1] + payload * length[0] * length[1]
    delta = inertia[1] + m[1] * r[1] ** 2 + payload * length[1] ** 2
    first, second = m[0] * r[0] + (m[1] + payload) * length[0], m[1] * r[1] + payload * length[1]
    rng = np.random.default_rng(3)
    theta, rate, push = rng.normal(size=(3, 4, 2))
    c, s = np.cos(theta[:, 1]), np.sin(theta[:, 1])
    along = second * np.cos(theta.sum(1))
    expected = np.column_stack([
        (alpha + 2 * beta * c) * push[:, 0] + (delta + beta * c) * push[:, 1]
        - beta * s * (2 * rate[:, 0] + rate[:, 1]) * rate[:, 1] + 9.81 * (first * np.cos(theta[:, 0]) + along),
        (delta + beta * c) * push[:, 0] + delta * push[:, 1] + beta * s * rate[:, 0] ** 2 + 9.81 * along,
    ])  # fmt: skip
    assert np.allclose(
        arm.inverse_dynamics(theta, rate, push, payload=payload, gravity=(0, -9.81, 0)), expected, rtol=1e-12
    )
    # One rate for all configurations; a tool farther out carries what stands behind it.
    longer = arm.with_tool(screws.exp([1.0, 0, 0, 0, 0, 0], 0.3), "longer")
    there = longer.inverse_dynamics(theta, rate[0], payload=(payload, [-0.3, 0, 0]))
    assert np.allclose(there[2], arm.inverse_dynamics(theta[2], rate[0], payload=payload))


def test_torques_without_any_mass_are_told(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, two_joints()))
    with pytest.warns(UserWarning, match="no link that tiny moves has a mass"):
        assert arm.inverse_dynamics([0.1, 0.2]).tolist() == [0.0, 0.0]


def test_manipulability_of_the_planar_two_link_arm() -> None:
    """Yoshikawa 1985: w = l₁ l₂ |sin θ₂| for the positions of a planar RR arm."""
    arm = load_arm("rr_planar")
    l1, l2 = (float(np.linalg.norm(x)) for x in _links_of_rr(arm))
    theta = np.array([0.4, 0.9])
    J = arm.hybrid_jacobian(theta)[:2]
    assert np.isclose(abs(np.linalg.det(J)), l1 * l2 * np.sin(0.9), rtol=1e-12)
    measure = arm.manipulability(theta, length=1.0)
    assert measure.singular_values.shape == (2,)
    assert np.isclose(measure.condition, np.linalg.cond(arm.body_jacobian(theta)))
    assert np.isclose(measure.yoshikawa, np.sqrt(np.linalg.det(arm.body_jacobian(theta).T @ arm.body_jacobian(theta))))


def _links_of_rr(arm: twistarm.Arm) -> tuple[np.ndarray, np.ndarray]:
    first, second = (screws.to_screw(xi).point for xi in arm.screws.T)
    return (second - first)[:2], (arm.home[:3, 3] - second)[:2]


def test_metres_and_radians_meet_in_the_length() -> None:
    """With slide columns times L and linear rows over L, scaling the whole arm leaves the measure as it was."""

    def build(scale: float) -> twistarm.Arm:
        home = np.eye(4)
        home[:3, 3] = np.array([0.4, 0.1, 0.3]) * scale
        columns = [
            joints.prismatic([0, 1, 0]),
            joints.revolute([0, 0, 1], np.zeros(3)),
            joints.revolute([0, 1, 0], np.array([0.2, 0, 0.1]) * scale),
        ]
        return arm_from_screws(np.hstack(columns), home)

    theta, scaled = np.array([0.1, 0.2, 0.3]), np.array([0.3, 0.2, 0.3])
    small = build(1.0).manipulability(theta).singular_values
    large = build(3.0).manipulability(scaled).singular_values
    assert np.allclose(small, large, rtol=1e-12)


def test_with_tool_moves_the_tip(rover: twistarm.Arm) -> None:
    g = screws.exp([0.01, 0.02, 0.1, 0.3, -0.2, 0.5])
    armed = rover.with_tool(g, "pen")
    theta = rover.random_theta(np.random.default_rng(3))
    assert armed.tip == "pen"
    assert np.allclose(armed.fk(theta), rover.fk(theta) @ g, atol=ROUNDING)
    assert np.allclose(armed.poses(theta)["pen"], armed.fk(theta), atol=ROUNDING)
    assert np.allclose(armed.pose(theta, "tool0"), rover.fk(theta), atol=ROUNDING)
    assert np.allclose(armed.spatial_jacobian(theta), rover.spatial_jacobian(theta), atol=ROUNDING)
    assert np.allclose(armed.body_jacobian(theta), screws.adjoint(screws.inverse(g)) @ rover.body_jacobian(theta))
    twice = armed.with_tool(g, "nib")
    assert np.allclose(twice.fk(theta), rover.fk(theta) @ g @ g, atol=ROUNDING)
    with pytest.raises(InputError, match="has a frame 'tool0' already"):
        rover.with_tool(g, "tool0")


def test_joints_outside_the_chain_are_set_by_name(rover: twistarm.Arm) -> None:
    closed, opened = rover.poses(rover.ready), rover.poses(rover.ready, {"finger_left": 0.02})
    moved = {name for name in closed if not np.allclose(closed[name], opened[name])}
    assert len(moved) == 2, "the finger and the one that mimics it"
    with pytest.raises(UnknownNameError, match="no joint outside the chain 'finger'"):
        rover.poses(rover.ready, {"finger": 0.02})


def test_names_and_numbers(rover: twistarm.Arm) -> None:
    theta = rover.random_theta(np.random.default_rng(4))
    values = rover.theta_to_dict(theta)
    assert np.array_equal(rover.theta_from(dict(reversed(values.items()))), theta)
    assert np.array_equal(rover.theta_from(list(reversed(values)), theta[::-1]), theta)
    with pytest.raises(UnknownNameError, match="no joint 'elbw' in rover_arm; closest: 'elbow'"):
        rover.theta_from({"elbw": 1.0})
    with pytest.raises(InputError, match="no value for joint 'shoulder'"):
        rover.theta_from({name: 0.0 for name in rover.joint_names if name != "shoulder"})
    with pytest.raises(InputError, match="2 names but 1 numbers"):
        rover.theta_from(["slide", "elbow"], [1.0])
    with pytest.raises(InputError, match="named twice"):
        rover.theta_from(["slide", "slide"], [1.0, 2.0])


THERE = twistarm.Position([0.7, 0, 0.6])

BY_NAME = {
    "fk": lambda arm, theta: arm.fk(theta),
    "pose": lambda arm, theta: arm.pose(theta, "forearm"),
    "poses": lambda arm, theta: arm.poses(theta)["forearm"],
    "joint_values": lambda arm, theta: list(arm.joint_values(theta).values()),
    "manipulability": lambda arm, theta: arm.manipulability(theta).singular_values,
    "solve_ik(theta0=)": lambda arm, theta: twistarm.solve_ik(arm, THERE, theta).theta,
    "ServoState.at": lambda arm, theta: twistarm.ServoState.at(arm, theta).theta,
    "SimulatedJoints": lambda arm, theta: SimulatedJoints(arm, theta).read(0.0).theta,
    "what a view shows": lambda arm, theta: checked_theta(arm, theta),
}


@pytest.mark.parametrize("case", BY_NAME)
def test_a_pose_is_named_wherever_a_theta_is_taken(case: str, rover: twistarm.Arm) -> None:
    for name, theta in {"zero": np.zeros(5), "stowed": rover.named_states["stowed"], "ready": rover.ready}.items():
        assert np.array_equal(BY_NAME[case](rover, name), BY_NAME[case](rover, theta))
    with pytest.raises((UnknownNameError, InputError), match="'ready', 'zero', 'stowed'"):
        BY_NAME[case](rover, "raedy")


WRONG_ARGUMENTS = {
    "theta too short": (lambda arm: arm.fk([0.0, 0.1]), r"theta must have shape \(..., 5\): slide, shoulder"),
    "a payload below zero": (
        lambda arm: arm.inverse_dynamics("ready", payload=-1.0),
        "payload's mass must be .* 0 or more",
    ),
    "a rate too short": (lambda arm: arm.inverse_dynamics("ready", [0.1]), "theta_dot must have shape"),
    "rates that do not fit": (
        lambda arm: arm.inverse_dynamics(np.zeros((2, 5)), np.zeros((3, 5))),
        "leading axes do not match",
    ),
    "no place of a payload": (
        lambda arm: arm.inverse_dynamics("ready", payload=(1.0, 2.0)),
        "the payload's place must have",
    ),
    "no length": (lambda arm: arm.manipulability("ready", length=0.0), "length must be positive"),
    "a tool without a name": (lambda arm: arm.with_tool(np.eye(4), " "), "the tool's name must be a text"),
    "an unknown frame": (lambda arm: arm.pose("ready", "tool_0"), r"closest: 'tool0' \(\d+ frames: arm"),
}


@pytest.mark.parametrize("case", WRONG_ARGUMENTS)
def test_wrong_arguments(case: str, rover: twistarm.Arm) -> None:
    call, message = WRONG_ARGUMENTS[case]
    with pytest.raises((InputError, UnknownNameError), match=message):
        call(rover)


def test_random_theta_keeps_the_limits(catalogue_arm: twistarm.Arm) -> None:
    arm = catalogue_arm
    theta = arm.random_theta(np.random.default_rng(5), 200)
    assert arm.limits.contains(theta).all()
    angle = np.array(arm.units) == "rad"
    unbounded = np.isinf(arm.limits.lower) & np.isinf(arm.limits.upper)
    assert (np.abs(theta[:, unbounded & angle]) <= np.pi).all()
    assert (np.abs(theta[:, unbounded & ~angle]) <= 1).all()
    assert (np.ptp(theta, axis=0) > 0.8 * np.minimum(np.ptp(np.vstack(arm.sampling_bounds), axis=0), 100)).all()


def test_half_bounded_joints_can_be_sampled() -> None:
    limits = {"lower": {"joint1": 5.0}, "upper": {"joint2": -7.0}}
    arm = arm_from_screws(np.hstack([joints.revolute([0, 0, 1], np.zeros(3))] * 2), np.eye(4), limits=limits)
    theta = arm.random_theta(np.random.default_rng(0), 100)
    assert arm.limits.contains(theta).all()
    assert (np.ptp(theta, axis=0) > 1).all()


def test_threads_do_not_disturb_each_other(rover: twistarm.Arm) -> None:
    theta = rover.random_theta(np.random.default_rng(8), 400)
    expected = rover.fk(theta)
    with ThreadPoolExecutor(4) as pool:
        results = list(pool.map(rover.fk, theta))
    assert np.array_equal(np.array(results), expected)


Z_AXIS = joints.revolute([0, 0, 1], np.zeros(3))
BY_HAND = {
    "no columns": ((np.zeros((6, 0)), np.eye(4)), {}, "screws must have shape"),
    "a zero column": ((np.zeros((6, 1)), np.eye(4)), {}, "zero column"),
    "two homes": ((Z_AXIS, np.stack([np.eye(4)] * 2)), {}, "home must be one pose"),
    "limits of others": ((Z_AXIS, np.eye(4)), {"limits": JointLimits.unbounded(3)}, "limits must be those of 1"),
    "a home that is no pose": ((Z_AXIS, np.diag([2.0, 1, 1, 1])), {}, "home"),
    "names of others": ((Z_AXIS, np.eye(4)), {"joints": ["a", "b"]}, "1 different names"),
}


@pytest.mark.parametrize("case", BY_HAND)
def test_screws_that_make_no_arm(case: str) -> None:
    arguments, keywords, telling = BY_HAND[case]
    with pytest.raises(InputError, match=telling):
        arm_from_screws(*arguments, **keywords)


def test_limits_that_were_not_given_are_infinite_and_never_zero() -> None:
    limits = JointLimits(*np.zeros((6, 2)))
    assert np.isinf(limits.velocity).all()
    assert np.isinf(limits.effort).all()
    with pytest.raises(InputError, match="limits.velocity must not be negative"):
        JointLimits.unbounded(2).with_({"velocity": -1.0}, ("a", "b"))


def test_the_reach_counts_turning_joints_only(tmp_path: Path) -> None:
    assert np.isclose(load_arm(write(tmp_path, two_joints())).reach, 0.5)
    sliding = robot(joint("s", "base_link", "upper", kind="prismatic"), joint("b", "upper", "tool0", xyz="3 0 0"))
    assert load_arm(write(tmp_path, sliding)).reach == 1.0, "one joint at the tool: a metre stands for it"


def test_an_arm_is_plain_data_that_cannot_be_changed(rover: Arm) -> None:
    theta = rover.random_theta(np.random.default_rng(7))
    for arm in (rover, pickle.loads(pickle.dumps(rover)), copy.deepcopy(rover), rover.with_tool(np.eye(4), "pen")):
        assert np.array_equal(arm.fk(theta), rover.fk(theta))
        assert set(arm.named_states) == set(rover.named_states) != set()
        with pytest.raises(TypeError):
            arm.named_states["ready"] = np.zeros(5)  # type: ignore[index]
        with pytest.raises(TypeError):
            arm.couplings["shoulder"] = None  # type: ignore[index]
        arrays = arm.screws, arm.home, arm.coupling.A, arm.limits.lower, arm.ready, *arm.named_states.values()
        assert not any(array.flags.writeable for array in arrays)
    with pytest.raises(AttributeError):
        rover.name = "other"  # type: ignore[misc]
