"""Limits for arms that give none: a turning joint and a slide, with and without limits of their own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from stream_stand_ins import FakeClock, Says
from twistarm import Arm, ArmBuilder, load_arm
from twistarm.arm.usual_limits import DEFAULTS, defaults_line, usually_limited, with_defaults
from twistarm.control.servo import JogCommand
from twistarm.control.stream import Setpoint, SimulatedJoints, run


@pytest.fixture(scope="module")
def arm() -> Arm:
    builder = ArmBuilder("crane").revolute("turn", [0, 0, 1], [0, 0, 0], lower=-2, upper=2, velocity=0.5)
    return builder.prismatic("reach", [1, 0, 0], lower=0, upper=0.5).tool(np.eye(4)).build()


def test_what_is_given_stays_and_what_is_not_is_usual(arm: Arm) -> None:
    limits = with_defaults(arm)
    assert limits.velocity.tolist() == [0.5, 0.25]
    assert limits.acceleration.tolist() == [3.0, 1.0]
    for name in ("lower", "upper", "jerk", "effort"):
        assert_array_equal(getattr(limits, name), getattr(arm.limits, name))


def test_what_stands_in_is_said(arm: Arm) -> None:
    assert defaults_line(arm) == (
        "no limits given, used instead: velocity 0.25 m/s for reach; "
        "acceleration 3 rad/s² for turn; acceleration 1 m/s² for reach"
    )
    assert defaults_line(arm, with_defaults(arm)) == ""
    assert usually_limited(usually_limited(arm)) is not arm
    assert usually_limited(limited := usually_limited(arm)) is limited


BARE = """<robot name="bare"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
<joint name="turn" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>{turn}</joint>
<joint name="swing" type="revolute"><parent link="b"/><child link="c"/><origin xyz="0.3 0 0"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="0" velocity="{velocity}"/></joint>
<joint name="reach" type="prismatic"><parent link="c"/><child link="d"/><axis xyz="1 0 0"/>
<limit lower="0" upper="0.3" effort="0" velocity="{velocity}"/></joint>
</robot>"""


@pytest.mark.parametrize("velocity", ["0", "1e9"])  # zeros and huge numbers are written where no limit is meant
@pytest.mark.parametrize("turn", ["", '<limit effort="0" velocity="0"/>'])
def test_nothing_is_unbounded_in_a_stream_nor_in_simulated_joints(tmp_path: Path, velocity: str, turn: str) -> None:
    file = tmp_path / "bare.urdf"
    file.write_text(BARE.format(turn=turn, velocity=velocity))
    arm, clock = load_arm(file), FakeClock()
    usual = {name: np.array([units[unit] for unit in arm.units]) for name, units in DEFAULTS.items()}
    joints, rates, moved = SimulatedJoints(arm, arm.ready, latency=0.05, clock=clock), [], []

    class Sink:
        def write(self, setpoint: Setpoint) -> None:
            rates.append(setpoint.theta_dot)
            moved.append(joints.theta_dot)
            joints.write(setpoint)

    to_and_fro = Says(lambda now: JogCommand(np.full(arm.n, 50.0 if now % 0.5 < 0.25 else -50.0)))
    report = run(arm, to_and_fro, Sink(), joints, duration=1.5, clock=clock)
    assert report.ok
    assert report.assumed == joints.assumed == defaults_line(arm)
    assert report.assumed in report.explain()
    assert (np.abs(rates) <= usual["velocity"] * (1 + 1e-9)).all()
    assert (np.abs(np.diff(rates, axis=0)) <= usual["acceleration"] * 0.01 * (1 + 1e-9)).all()
    # Drives have the reserve that the page says: 1.2 and 2 times.
    assert (np.abs(moved) <= 1.2 * usual["velocity"] * (1 + 1e-9)).all()
    assert np.abs(moved).max() > 0.1
    assert SimulatedJoints(arm, arm.ready, velocity=1.0, acceleration=[9.0, 9.0, 9.0]).assumed == ""
