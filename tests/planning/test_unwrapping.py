"""Continuous joints: the shorter way to configurations where that is asked for, and always to targets."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from ik_targets import pinocchio_fk
from twistarm import ArmBuilder, JointMove, LineMove, Position, load_arm, load_motion, plan, plan_joint
from twistarm.cli.application import run

TURN = 2 * np.pi
LIMITS = {"velocity": 1.0, "acceleration": 3.0}


def arm_of(pitch: float = 0.0, lower: float | None = None, upper: float | None = None):
    """A yaw, endless unless it is bounded, or a screw of some pitch; and a shoulder."""
    builder = ArmBuilder("yaw")
    if pitch:
        builder = builder.helical("yaw", [0, 0, 1], [0, 0, 0], pitch)
    else:
        builder = builder.revolute("yaw", [0, 0, 1], [0, 0, 0], lower=lower, upper=upper)
    g = np.eye(4)
    g[:3, 3] = [0.5, 0.0, 0.2]
    return builder.revolute("shoulder", [0, 1, 0], [0, 0, 0.2], lower=-2, upper=2).tool(g).build()


ENDS = [[3.1, 0.0], [-3.1, 0.1], [3.0, 0.0]]


@pytest.mark.parametrize("bounds", [(None, None), (-7.0, 7.0)])
def test_unwrapped_waypoints_are_the_same_places_by_the_shorter_way(bounds: tuple[float | None, float | None]) -> None:
    arm = arm_of(lower=bounds[0], upper=bounds[1])
    plain, short = (plan_joint(arm, ENDS, limits=LIMITS, unwrap=unwrap) for unwrap in (False, True))
    assert plain.waypoints[:, 0].tolist() == [3.1, -3.1, 3.0]
    np.testing.assert_allclose(short.waypoints[:, 0], [3.1, TURN - 3.1, 3.0])
    for one, other in zip(plain.waypoints, short.waypoints, strict=True):
        np.testing.assert_allclose(pinocchio_fk(arm, one), pinocchio_fk(arm, other), atol=1e-12)
    assert short.duration < 0.2 * plain.duration
    assert "turns by 6.2 rad; unwrap=True makes that 0.08319 rad" in plain.notes[0]
    assert "'yaw' goes to 3.18319 rad in place of -3.1 rad" in short.notes[0]
    moves = [JointMove(each) for each in ENDS[1:]]
    for unwrap, planned in ((False, plain), (True, short)):
        motion = plan(arm, moves, start=ENDS[0], limits=LIMITS, unwrap=unwrap)
        np.testing.assert_allclose(motion.waypoints, planned.waypoints)
        assert len(motion.notes) == len(planned.notes)


@pytest.mark.parametrize(("pitch", "bounds"), [(0.01, (None, None)), (0.0, (-3.15, 3.15))])
def test_joints_that_a_whole_turn_moves_or_their_limits_hold_are_left(pitch: float, bounds: tuple) -> None:
    arm = arm_of(pitch, *bounds)
    motion = plan_joint(arm, ENDS, limits=LIMITS, unwrap=True)
    assert motion.waypoints[:, 0].tolist() == [3.1, -3.1, 3.0]
    assert motion.notes == ()


def test_to_a_target_the_shorter_way_is_the_default() -> None:
    arm = arm_of()
    there, on = (pinocchio_fk(arm, np.array(theta))[:3, 3] for theta in ([-3.1, 0.1], [-3.05, 0.1]))
    to_it = plan_joint(arm, [ENDS[0], Position(there)], limits=LIMITS)
    line = LineMove(Position(on), position_tol=1e-3)
    through = plan(arm, [JointMove(Position(there)), line], start=ENDS[0], limits=LIMITS)
    for motion in (to_it, through):
        assert motion.waypoints[1, 0] == pytest.approx(TURN - 3.1, abs=1e-3)
        assert motion.notes == ()


URDF = """<robot name="yaw"><link name="base_link"/><link name="a"/><link name="tool0"/>
<joint name="yaw" type="continuous"><parent link="base_link"/><child link="a"/><axis xyz="0 0 1"/></joint>
<joint name="shoulder" type="revolute"><parent link="a"/><child link="tool0"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" velocity="1" effort="1"/></joint></robot>"""


def test_a_file_and_the_command_line_ask_for_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("arm.urdf").write_text(URDF, "utf-8")
    arm = load_arm("arm.urdf")
    Path("m.toml").write_text("unwrap = true\n[[segment]]\njoint = [-3.1, 0.1]\n", "utf-8")
    assert load_motion("m.toml", arm).unwrap
    start = ["--from", "3.1 0", "--rad", "--json"]
    for how, end in ((["m.toml"], TURN - 3.1), (["--to=-3.1 0.1", "--unwrap"], TURN - 3.1), (["--to=-3.1 0.1"], -3.1)):
        assert run(["plan", "arm.urdf", *how, *start]) == 0
        said = capsys.readouterr()
        assert json.loads(said.out)["waypoints"][-1][0] == pytest.approx(end, abs=1e-5)
        assert ("makes that" in said.err) == (end < 0)
