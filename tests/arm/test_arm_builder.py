"""The builder: the arm it says, the URDF it writes, and mistakes refused."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from twistarm import Arm, ArmBuilder, JointLimits, crosscheck, joints, poe, save_html
from twistarm.support.errors import DescriptionError, InputError, UnknownNameError

Z, O = [0, 0, 1], [0, 0, 0]  # noqa: E741
HOME = np.array([[1, 0, 0, 0.6], [0, 1, 0, 0], [0, 0, 1, 0.3], [0, 0, 0, 1.0]])


def scara() -> ArmBuilder:
    """MLS §3.2.2, example 3.1: three turns and a slide along z, l1 = 0.4, l2 = 0.2, l0 = 0.3."""
    builder = ArmBuilder("scara").revolute("a", Z, O, lower=-2, upper=2, velocity=1.5, effort=20)
    return builder.revolute("b", Z, [0.4, 0, 0]).revolute("c", Z, [0.6, 0, 0]).prismatic("d", Z).tool(HOME)


def test_it_is_an_arm_like_one_that_was_loaded(tmp_path: Path) -> None:
    arm = scara().build()
    assert arm.proof is not None
    assert arm.proof.pose_error < 1e-14
    result = crosscheck(arm, 50).require()
    assert result.left_out == {}
    assert result.worst("pinocchio") < 1e-12
    assert arm.frame_names == ("base", "a_link", "b_link", "c_link", "d_link", "tool")
    assert pickle.loads(pickle.dumps(arm)).fk(np.zeros(4)).tolist() == arm.fk(np.zeros(4)).tolist()
    assert save_html(arm, tmp_path / "arm.html").stat().st_size > 0


def test_limits_are_those_given_and_no_others() -> None:
    limits = scara().build().limits
    inf = np.inf
    assert limits.lower.tolist() == [-2, -inf, -inf, -inf]
    assert limits.upper.tolist() == [2, inf, inf, inf]
    assert limits.velocity.tolist() == [1.5, inf, inf, inf]
    assert limits.effort.tolist() == [20, inf, inf, inf]
    half = (
        ArmBuilder("half").prismatic("a", Z, upper=0.5).revolute("b", Z, O, lower=-1, upper=np.inf).tool(HOME).build()
    )
    assert half.limits.lower.tolist() == [-inf, -1]
    assert half.limits.upper.tolist() == [0.5, inf]
    assert half.findings == ()


def test_limits_coordinate_by_coordinate() -> None:
    builder = ArmBuilder("pair").cylindrical("c", Z, O).planar("p", Z).tool(HOME)
    arm = builder.build(limits={"upper": {"c_z": 0.4, "p_x": 0.1}, "acceleration": 3.0})
    assert arm.joint_names == ("c_rz", "c_z", "p_x", "p_y", "p_rz")
    assert arm.limits.upper.tolist() == [np.inf, 0.4, 0.1, np.inf, np.inf]
    assert arm.limits.acceleration.tolist() == [3.0] * 5
    assert builder.build(limits=JointLimits.unbounded(5)).limits.upper.tolist() == [np.inf] * 5
    with pytest.raises(UnknownNameError, match="no joint 'c' in limits"):
        builder.build(limits={"velocity": {"c": 1.0}})


def test_a_builder_is_never_changed() -> None:
    start = ArmBuilder("arm").revolute("a", Z, O)
    one, two = start.prismatic("b", Z).tool(HOME), start.prismatic("b", [1, 0, 0]).tool(HOME)
    assert one.build().screws[:3, 1].tolist() == [0, 0, 1]
    assert two.build().screws[:3, 1].tolist() == [1, 0, 0]
    axis = np.array([0.0, 0.0, 1.0])
    kept = start.prismatic("b", axis)
    axis[:] = [1, 0, 0]
    assert kept.tool(HOME).build().screws[:3, 1].tolist() == [0, 0, 1]


def test_helical_by_its_lead() -> None:
    lead = 0.008
    arm = ArmBuilder("lift").helical("j", Z, [0.1, 0, 0], lead / (2 * np.pi), upper=50.0).tool(HOME).build()
    assert (arm.joint_names, arm.joint_types, arm.units) == (("j",), ("helical",), ("rad",))
    assert arm.limits.upper.tolist() == [50.0]
    np.testing.assert_allclose(arm.fk([2 * np.pi])[:3, 3] - HOME[:3, 3], [0, 0, lead], atol=1e-15)
    without = ArmBuilder("turn").helical("j", Z, O, 0.0).tool(HOME).build()
    np.testing.assert_allclose(without.fk([1.0]), poe.fk(joints.revolute(Z, O), HOME, [1.0]), atol=1e-15)


def started() -> ArmBuilder:
    return ArmBuilder("arm").revolute("a", Z, O).planar("p", Z).helical("h", Z, O, 0.1).cylindrical("c", Z, O)


MISTAKES: dict[str, tuple[Callable[[], object], str]] = {
    "a name with a control character": (lambda: started().prismatic("x\n", Z), "'x\\n'"),
    "a name twice": (lambda: started().revolute("a", Z, O).tool(HOME).build(), "'a_link'"),
    "a name whose coordinate is taken": (
        lambda: started().prismatic("s_rx", Z).spherical("s", O).tool(HOME).build(),
        "'s_rx_link'",
    ),
    "the slide of a thread": (lambda: started().revolute("h_z", Z, O).tool(HOME).build(), "'h_z_link'"),
    "a zero axis": (lambda: started().prismatic("x", O), "joint 'x': axis"),
    "axes that are no rotation": (lambda: started().spherical("x", O, np.diag([1, 1, -1.0])), "joint 'x': axes"),
    "swapped limits": (lambda: started().prismatic("x", Z, lower=1, upper=-1), "joint 'x': lower"),
    "a bound at the wrong infinity": (lambda: started().prismatic("x", Z, lower=np.inf), "joint 'x': lower"),
    "a velocity of zero": (lambda: started().prismatic("x", Z, velocity=0), "joint 'x': velocity"),
    "a limit that no joint has": (lambda: started().prismatic("x", Z, speed=1), "'speed'"),
    "no tool": (lambda: started().build(), "no tool"),
    "no joints": (lambda: ArmBuilder("arm").tool(HOME).urdf(), "no joints"),
    "two tools": (lambda: started().tool(HOME).tool(HOME), "'tool'"),
    "a tool named as a link": (lambda: started().tool(HOME, "a_link").build(), "'a_link'"),
    "a tool whose mount is a joint": (
        lambda: ArmBuilder("arm").revolute("hand_mount", Z, O).tool(HOME, "hand").build(),
        "'hand_mount'",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes_are_refused_in_one_line(mistake: str) -> None:
    make, message = MISTAKES[mistake]
    with pytest.raises((InputError, DescriptionError)) as caught:
        make()
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_names_that_need_escaping() -> None:
    arm: Arm = ArmBuilder('<"arm">').revolute("<&>/a", Z, O).tool(HOME, 'to"ol').build()
    assert (arm.name, arm.joint_names, arm.tip) == ('<"arm">', ("<&>/a",), 'to"ol')
    crosscheck(arm, 5).require()
