"""What is said of an arm's closed form before a target is known."""

from __future__ import annotations

import numpy as np
import pytest

from twistarm import Approach, NoClosedFormError, Position, Task, load_arm, solve_ik_all
from twistarm.ik import closed_form_of


@pytest.mark.parametrize(
    ("arm", "target", "told"),
    [
        ("rover_arm", "Approach", "closed form, the axes of shoulder, elbow and wrist_pitch are parallel"),
        ("scara", "Pose", "closed form, the axes of joint_1, joint_2 and joint_3 are parallel"),
        ("stanford", "Pose", "closed form, the axes of joint_4, joint_5 and joint_6 meet in a point"),
    ],
)
def test_a_family_is_named(arm: str, target: str, told: str) -> None:
    report = closed_form_of(load_arm(arm))
    assert (report.target, str(report)) == (target, told)
    assert report.exact
    assert not report.nearly
    assert report.miss == ""


def test_how_far_axes_pass_is_what_the_robot_s_drawing_says() -> None:
    """The wrist of the six-joint rover arm is drawn with an offset of 20 mm: another build, no rounding."""
    arm = load_arm("rover_arm_6dof")
    w, v = arm.screws[3:, 4:].T, arm.screws[:3, 4:].T
    points = np.cross(w, v)
    normal = np.cross(*w)
    assert abs((points[1] - points[0]) @ normal) / np.linalg.norm(normal) == pytest.approx(0.02)
    report = closed_form_of(arm)
    assert report.method == "elimination"
    assert report.miss == "the axes of wrist_pitch and wrist_roll pass at 20 mm"
    assert not report.nearly
    g = arm.fk(arm.ready)
    with pytest.raises(NoClosedFormError, match="for a Pose: the axes of wrist_pitch and wrist_roll pass at 20 mm"):
        solve_ik_all(arm, g, closed_form=True)
    with pytest.raises(NoClosedFormError, match="for a Task: a Task's tolerances leave a whole range of poses"):
        solve_ik_all(arm, Task(g, tolerance=[0.1] * 6), closed_form=True)


def test_joints_that_a_target_leaves_open_are_named() -> None:
    arm = load_arm("rover_arm")
    g = arm.fk(arm.ready)
    held = closed_form_of(arm, Position(g[:3, 3])).held
    assert len(held) == 1, "five joints, three of which a position determines, and a roll that moves nothing"
    assert closed_form_of(arm, Approach(g[:3, 3], g[:3, 2])).held == ()
    rest = solve_ik_all(arm, Position(g[:3, 3]), given={name: arm.theta_to_dict(arm.ready)[name] for name in held})
    assert rest.complete
