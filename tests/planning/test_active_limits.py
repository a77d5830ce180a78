"""What bounds each stretch of a motion, and the tool's speeds."""

from dataclasses import replace

import numpy as np
import pytest

from catalogue import load
from test_hard_motions import arm_of
from twistarm import (
    Actuators,
    Arm,
    Dwell,
    JointMove,
    LineMove,
    active_limits,
    arm_from_screws,
    load_arm,
    plan,
    plan_joint,
    rotations,
)
from twistarm.limits import JointLimits
from twistarm.planning.piecewise import JointPath
from twistarm.planning.stretches import greatest_tool_speeds
from twistarm.support.errors import InputError

LIMITS = {"velocity": 2.0, "acceleration": 5.0}


@pytest.fixture
def gantry() -> Arm:
    """Two slides along x and y: the tool goes as they do."""
    return replace(arm_of("two"), limits=JointLimits.unbounded(2))


@pytest.mark.parametrize("stop", [False, True])
def test_a_line_is_bound_by_acceleration_velocity_acceleration(gantry, stop):
    """Lynch & Park §9.2.2.2: V/A to come to full speed, as long to stop, the rest of the way at V."""
    motion = plan_joint(gantry, [[0, 0], [3.0, 1.5]], kind="time_optimal", limits=LIMITS, stop_at_waypoints=stop)
    found = active_limits(gantry, motion, limits=LIMITS)
    assert [stretch.describe() for stretch in found] == [
        "acceleration of joint 'x'",
        "velocity of joint 'x'",
        "acceleration of joint 'x'",
    ]
    assert [stretch.end for stretch in found] == pytest.approx([0.4, 1.5, 1.9], abs=0.02)
    assert found[1].begin == found[0].end
    assert [stretch.share for stretch in found] == pytest.approx([1.0] * 3, abs=1e-3)


def test_the_tool_s_speed_a_share_of_speed_and_rest_count(gantry):
    segments = [LineMove.by([1.0, 0, 0], linear_speed=0.1), Dwell(2.0), JointMove([1.0, 3.0], velocity_scaling=0.25)]
    motion = plan(gantry, segments, start=[0, 0], limits=LIMITS, kind="time_optimal")
    found = active_limits(gantry, motion, limits=LIMITS, segments=segments)
    line = [stretch for stretch in found if stretch.end <= motion.times[1] + 0.01]
    assert max(line, key=lambda stretch: stretch.end - stretch.begin).describe() == "linear speed"
    assert not any(stretch.begin < middle < stretch.end for stretch in found for middle in [np.mean(motion.times[1:3])])
    slow = [stretch for stretch in found if stretch.rate == "velocity"]
    assert [stretch.name for stretch in slow] == ["y"]
    assert slow[0].share == pytest.approx(1.0, abs=2e-3)
    assert slow[0].end - slow[0].begin == pytest.approx(3.0 / 0.5 - 0.5 / 5.0, abs=0.15)


def test_a_motor_that_is_slower_than_its_joints_is_named(gantry):
    motors = JointLimits.unbounded(2).with_({"velocity": 3.0, "acceleration": 90.0}, ["a", "b"])
    G = np.array([[10.0, 10.0], [10.0, -10.0]])
    drives = Actuators(("a", "b"), ("x", "y"), G, np.zeros(2), ("rad", "rad"), np.full(2, np.nan), motors)
    arm = replace(gantry, actuators=drives)
    motion = plan_joint(arm, [[0, 0], [1.0, 1.0]], kind="s_curve", limits=LIMITS)
    longest = max(active_limits(arm, motion, limits=LIMITS), key=lambda stretch: stretch.end - stretch.begin)
    assert longest.describe() == "velocity of motor 'a'"
    assert longest.share == pytest.approx(1.0, abs=1e-3)


def test_what_stands_is_bound_by_nothing_and_strangers_are_refused(gantry):
    still = plan_joint(gantry, [[1.0, 1.0]], limits=LIMITS)
    assert active_limits(gantry, still, limits=LIMITS) == ()
    with pytest.raises(InputError, match="2 segments has 3 waypoints; this one has 1"):
        active_limits(gantry, still, limits=LIMITS, segments=[Dwell(1.0), Dwell(1.0)])
    with pytest.raises(InputError, match="Trajectory of the arm's joints"):
        active_limits(gantry, [1.0, 2.0])


MIMIC = """<robot name="lift"><link name="base_link"/><link name="one"/><link name="two"/><link name="tool"/>
<joint name="lift" type="prismatic"><parent link="base_link"/><child link="one"/><axis xyz="0 0 1"/>
<limit lower="0" upper="3" velocity="1" effort="1"/></joint>
<joint name="turn" type="continuous"><parent link="one"/><child link="two"/><axis xyz="0 1 0"/></joint>
<joint name="fold" type="revolute"><parent link="two"/><child link="tool"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
<limit lower="-9" upper="9" velocity="1" effort="1"/><mimic joint="turn" multiplier="3"/></joint>
</robot>"""
"""One coordinate turns two links, the second three times as far, on a slide that goes beyond the arm's reach."""


def arms(folder) -> dict[str, Arm]:
    file = folder / "lift.urdf"
    file.write_text(MIMIC)
    helix = np.array([[0.1, 0.0, 0.2, 0.0, 0.0, 1.0], [0.0, 0.3, 0.4, 0.0, 1.0, 0.0]]).T
    home = np.eye(4)
    home[0, 3] = 0.5
    return {
        "mimic": load_arm(file, tip="tool"),
        "helical": arm_from_screws(helix, home, name="helical"),
        "rover": load("rover_arm"),
        "stanford": load("stanford"),
    }


@pytest.mark.parametrize("kind", ["mimic", "helical", "rover", "stanford"])
def test_no_speed_of_the_tool_exceeds_its_bound_and_some_come_near(kind, tmp_path):
    arm, rng = arms(tmp_path)[kind], np.random.default_rng(6)
    for _ in range(20):
        scale = np.array([2.0, 2.0, 2.0, 1.0])[:, None, None]
        path = JointPath(np.array([0.0, 0.2]), rng.uniform(-1.0, 1.0, (4, 1, arm.n)) * scale)
        s = np.linspace(0.0, 0.2, 2001)
        g = arm.fk(path(s))
        velocity = np.gradient(g[:, :3, 3], s, axis=0)[1:-1]
        turn = rotations.log(np.swapaxes(g[:-1, :3, :3], 1, 2) @ g[1:, :3, :3]) / s[1]
        seen = np.array([np.linalg.norm(velocity, axis=1).max(), np.linalg.norm(turn, axis=1).max()])
        greatest = np.array([speeds[0] for speeds in greatest_tool_speeds(arm, path)])
        assert (seen <= greatest * (1.0 + 1e-5)).all()
        assert (seen >= greatest * (1.0 - 1e-3)).all()
