"""Payloads: worked by hand for two links, exact at the limit, and told where the description lacks something."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import twistarm
from catalogue import load
from twistarm import Actuators, JointLimits, arm_from_screws, load_arm, payload, plan_joint, screws
from twistarm.support.errors import InputError, TwistarmError
from urdf_text import joint, robot, write

G = 9.81


def two_links(folder: Path, effort: tuple[float, float] = (30.0, 12.0), mass: float = 2.0) -> twistarm.Arm:
    """Two links of 0.5 m and 0.4 m that turn about y, stretched along x at zero, each with its mass in the middle."""
    links = "".join(
        f'<link name="{name}"><inertial><origin xyz="{length / 2} 0 0"/><mass value="{mass}"/><inertia ixx="0.01" '
        'iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        for name, length in (("upper", 0.5), ("lower", 0.4))
    )
    limit = '<axis xyz="0 1 0"/><limit lower="-1" upper="1" velocity="2" effort="{}"/>'
    a = joint("a", "base_link", "upper", xyz="0 0 0", inside=limit.format(effort[0]))
    b = joint("b", "upper", "lower", xyz="0.5 0 0", inside=limit.format(effort[1]))
    end = joint("end", "lower", "tool0", kind="fixed", xyz="0.4 0 0")
    return load_arm(write(folder, robot(links, a, b, end, links=("base_link", "tool0"))))


def test_two_stretched_links_by_hand(tmp_path: Path) -> None:
    arm = two_links(tmp_path)
    own = 2.0 * G * (0.25 + 0.7), 2.0 * G * 0.2
    by_a, by_b = (30.0 - own[0]) / (0.9 * G), (12.0 - own[1]) / (0.4 * G)
    found = payload(arm, [[0.0, 0.0], [1.0, -1.0]])
    raised = (12.0 - own[1]) / (0.4 * G)  # the second link is level, and the first nearer to upright
    shoulder = (30.0 - 2.0 * G * (0.25 * np.cos(1) + 0.5 * np.cos(1) + 0.2)) / (G * (0.5 * np.cos(1) + 0.4))
    assert np.allclose(found.mass, [min(by_a, by_b), min(raised, shoulder)], rtol=1e-9)
    assert [found.names[row] for row in found.limiting] == ["a", "b"]
    # The level, stretched arm is the weakest of all, and needs most.
    anywhere = payload(arm, samples=100)
    assert np.isclose(anywhere.mass.min(), by_a, rtol=1e-5)
    assert np.allclose(anywhere.needs(1.5).effort, [own[0] + 1.5 * G * 0.9, own[1] + 1.5 * G * 0.4], rtol=1e-5)
    # Farther out it holds less.
    assert np.isclose(payload(arm, "zero", offset=[0.1, 0, 0]).mass, (30.0 - own[0]) / G)


def test_an_arm_that_cannot_hold_itself_holds_nothing(tmp_path: Path) -> None:
    found = payload(two_links(tmp_path, effort=(10.0, 12.0)), "zero")
    assert found.mass == 0.0
    assert found.names[found.limiting] == "a"
    assert np.isclose(found.needs().share[0], 2.0 * G * 0.95 / 10.0)


def test_what_the_description_lacks_is_told(tmp_path: Path) -> None:
    found = payload(two_links(tmp_path, effort=(0.0, 0.0)), "zero")
    assert np.isnan(found.mass)
    assert found.limiting == -1
    assert any("no effort limit of 'a', 'b': the payload is unknown" in note for note in found.notes)
    bound = payload(two_links(tmp_path, effort=(0.0, 12.0)), "zero")
    assert np.isclose(bound.mass, (12.0 - 2.0 * G * 0.2) / (0.4 * G))
    assert any("no effort limit of 'a': the payload is an upper bound" in note for note in bound.notes)
    light = payload(two_links(tmp_path, mass=0.0), "zero")
    assert any("no link that moves has a mass" in note for note in light.notes)
    assert np.isclose(light.mass, min(30.0 / (0.9 * G), 12.0 / (0.4 * G)))
    level = load("rr_planar")  # gravity is along its axes
    assert payload(level, "ready").mass == np.inf
    assert payload(level).limiting.max() == -1
    with pytest.raises(TwistarmError, match="has no Pinocchio model"):
        payload(arm_from_screws(level.screws, level.home), [0.0, 0.0])


def differential(rover: twistarm.Arm, effort: float) -> twistarm.Arm:
    """The rover arm with a motor on each of three joints, and two that share pitch and roll."""
    ratios = np.array(
        [[400.0, 0, 0, 0, 0], [0, 100, 0, 0, 0], [0, 0, -80, 0, 0], [0, 0, 0, 60, 60], [0, 0, 0, 60, -60]]
    )
    names = ("rail", "shoulder", "elbow", "left", "right")
    limits = JointLimits.unbounded(5).with_({"effort": {"left": effort, "right": effort}}, names)
    motors = Actuators(names, rover.joint_names, ratios, np.zeros(5), ("rad",) * 5, np.full(5, np.nan), limits)
    return replace(rover, actuators=motors)


def test_two_motors_share_a_joint(rover: twistarm.Arm) -> None:
    arm = differential(rover, 0.1)
    own, with_one = (rover.inverse_dynamics("ready", payload=m)[3] for m in (0.0, 1.0))
    found = payload(arm, "ready")
    assert np.isclose(found.mass, (2 * 60 * 0.1 - abs(own)) / abs(with_one - own))
    assert found.names[found.limiting] in ("motor left", "motor right")
    needs = payload(arm, "ready", arm.limits.velocity).needs(2.0)
    assert np.allclose(needs.speed[5:], np.abs(arm.actuators.G @ arm.limits.velocity))
    # Joints without a limit of their own have one through all their motors.
    bare = replace(arm, limits=arm.limits.with_({"effort": {"wrist_pitch": np.inf, "elbow": np.inf}}, arm.joint_names))
    assert any("no effort limit of 'elbow':" in note for note in payload(bare, "ready").notes)


@pytest.mark.parametrize("name", ["rover_arm", "panda", "scara"])
def test_the_limit_is_met_exactly_and_not_passed(name: str) -> None:
    arm = load(name)
    theta, rate, push = (scale * arm.random_theta(k, 20) for k, scale in ((1, 1.0), (2, 0.3), (3, 0.3)))
    found = payload(arm, theta, rate, push)
    for k, mass in enumerate(found.mass):
        held = np.abs(arm.inverse_dynamics(theta[k], rate[k], push[k], payload=mass)) / arm.limits.effort
        row = found.limiting[k]
        assert np.isclose(held[row], 1.0) if mass else held[row] > 1.0
        assert mass == 0.0 or (held <= 1.0 + 1e-9).all()


def test_along_a_motion_jumps_of_the_acceleration_count(rover: twistarm.Arm) -> None:
    motion = plan_joint(rover, ["stowed", "ready"], kind="time_optimal")
    found = payload(rover, motion)
    assert found.t is not None
    assert found.mass.shape == found.t.shape
    t = np.unique(
        np.concatenate([np.linspace(0, motion.duration, 3000), motion.breakpoints - 1e-9, motion.breakpoints + 1e-9])
    )
    t = t[(t >= 0) & (t <= motion.duration)]
    torques = rover.inverse_dynamics(*(motion(t, order) for order in range(3)), payload=1.0)
    needs = found.needs(1.0)
    assert np.allclose(needs.effort, np.abs(torques).max(axis=0), rtol=1e-3, atol=1e-9)
    assert np.allclose(needs.speed, motion.peak(1), rtol=1e-3, atol=1e-12)
    assert np.allclose(needs.power, np.abs(torques * motion(t, 1)).max(axis=0), rtol=1e-2, atol=1e-9)


def test_rates_may_have_more_axes_than_theta(rover: twistarm.Arm) -> None:
    push = 2.0 * np.vstack([np.eye(5), -np.eye(5)])
    found = payload(rover, "ready", theta_ddot=push)
    assert found.mass.shape == (10,)
    assert found.theta.shape == (10, 5)
    assert np.isclose(found.mass[6], payload(rover, "ready", theta_ddot=push[6]).mass)
    assert found.needs(1.0).speed.tolist() == [0.0] * 5


def test_a_tool_farther_out_holds_less(rover: twistarm.Arm) -> None:
    longer = rover.with_tool(screws.exp([0, 0, 1.0, 0, 0, 0], 0.2), "longer")
    assert np.allclose(payload(longer, "ready").mass, payload(rover, "ready", offset=[0, 0, 0.2]).mass)


@pytest.mark.parametrize(
    "call",
    [
        lambda arm: payload(arm, np.zeros((0, 5))),
        lambda arm: payload(arm, plan_joint(arm, ["ready", "zero"]), [0.0] * 5),
        lambda arm: payload(arm, plan_joint(load("ur5"), ["ready", "zero"])),
        lambda arm: payload(arm, samples=0),
        lambda arm: payload(arm, "ready").needs(-1.0),
        lambda arm: payload("rover_arm"),
    ],
)
def test_wrong_arguments(call: Callable[[Any], object], rover: twistarm.Arm) -> None:
    with pytest.raises(InputError):
        call(rover)
