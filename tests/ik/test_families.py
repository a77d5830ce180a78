"""Families are recognised from the axes, exact or as an export rounds them, and named before a target is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import twistarm
from family_arms import CASES, family_arm, joint_distance, missed, pose_of
from twistarm import NoClosedFormError, TolerancedPose, load_arm, solve_ik_all
from twistarm.ik import Approach, Pose, Position, closed_form_of
from twistarm.ik.closed_form.methods import method_for


@pytest.mark.parametrize("name", CASES)
def test_the_family_is_recognised_from_the_axes(name):
    arm, case = family_arm(name), CASES[name]
    method = method_for(arm, Pose(arm.home))
    assert method.exact
    if case["kind"] == "elimination":
        assert method.family is None
        assert method.name == "elimination"
    else:
        assert method.family.kind == case["kind"]
        assert sorted(method.family.group) == case["group"]
        assert method.name == "closed form"


@pytest.mark.parametrize(("name", "noise"), [("spherical wrist", 1e-4), ("parallel 2-3-4", 1e-4), ("P-RRR-R", 1e-6)])
def test_rounded_axes_are_reported_and_all_their_answers_found(name, noise):
    """The nearest exact arm gives the starts; its misses are told, and the answers are those of the arm itself."""
    rng = np.random.default_rng(5)
    arm = family_arm(name, noise, rng)
    method = method_for(arm, Pose(arm.home))
    if method.family is None:  # a smaller group is exact, or elimination takes arms of five and six joints
        assert method.name == "elimination"
    theta = arm.random_theta(rng)
    g = pose_of(arm, theta)
    found = twistarm.solve_ik_all(arm, Pose(g))
    assert found.complete == method.exact
    assert method.exact or "but for" in found.family
    assert min(joint_distance(arm, answer, theta) for answer in found) < 1e-6
    assert max(missed(arm, g, answer) for answer in found) < 1e-9


@pytest.mark.parametrize(
    "name",
    ["parallel 3-4-5", *(pytest.param(long, marks=pytest.mark.slow) for long in ("spherical wrist", "six skew turns"))],
)
def test_a_double_root_that_stands_on_its_limits_is_inside(name):
    """Where det J = 0 two configurations are one, known to half of the digits: its joints are drawn to their limits."""
    whole, rng = family_arm(name), np.random.default_rng(1)
    found = 0
    while found < 4:
        first, joint = rng.uniform(-3, 3, 6), rng.integers(6)
        last = first + rng.uniform(0.3, 1) * np.eye(6)[joint]

        def determinant(share, first=first, last=last):
            return np.linalg.det(whole.body_jacobian(first + share * (last - first)))

        if determinant(0.0) * determinant(1.0) > 0:
            continue
        theta = first + brentq(determinant, 0.0, 1.0, xtol=1e-15) * (last - first)
        lower, upper = theta - rng.uniform(0.3, 1, 6), theta + rng.uniform(0.3, 1, 6)
        at = rng.random(6)
        lower, upper = np.where(at < 0.3, theta, lower), np.where(at > 0.7, theta, upper)
        arm = replace(whole, limits=replace(whole.limits, lower=lower, upper=upper), named_states={})
        g = pose_of(arm, theta)
        answers = twistarm.solve_ik_all(arm, Pose(g), theta)
        assert any(joint_distance(arm, answer, theta) < 1e-4 for answer in answers)
        assert twistarm.solve_ik(arm, Pose(g)).converged
        found += 1


def test_what_misses_a_family_says_which_axes_and_by_how_much():
    arm = family_arm("spherical wrist, slides")
    xi = np.array(arm.screws)
    xi[:3, 3] += np.cross([0, 0.02, 0.02], xi[3:, 3])  # axis 4 goes past the other two at 28 mm
    off = twistarm.arm_from_screws(xi, arm.home, limits=arm.limits, joints=arm.joint_names)
    with pytest.raises(twistarm.NoClosedFormError, match=r"joint\d.*(mm|parallel)"):
        twistarm.solve_ik_all(off, Pose(arm.home), closed_form=True)


@pytest.mark.parametrize(
    ("arm", "target", "summary"),
    [
        ("rover_arm", "Approach", "closed form, the axes of shoulder, elbow and wrist_pitch are parallel"),
        ("scara", "Pose", "closed form, the axes of joint_1, joint_2 and joint_3 are parallel"),
        ("stanford", "Pose", "closed form, the axes of joint_4, joint_5 and joint_6 meet in a point"),
    ],
)
def test_a_family_is_named(arm: str, target: str, summary: str) -> None:
    report = closed_form_of(load_arm(arm))
    assert (report.target, str(report)) == (target, summary)
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
    with pytest.raises(
        NoClosedFormError, match="for a TolerancedPose: a TolerancedPose's tolerances leave a whole range of poses"
    ):
        solve_ik_all(arm, TolerancedPose(g, tolerance=[0.1] * 6), closed_form=True)


def test_joints_that_a_target_leaves_open_are_named() -> None:
    arm = load_arm("rover_arm")
    g = arm.fk(arm.ready)
    held = closed_form_of(arm, Position(g[:3, 3])).held
    assert len(held) == 1, "five joints, three of which a position determines, and a roll that moves nothing"
    assert closed_form_of(arm, Approach(g[:3, 3], g[:3, 2])).held == ()
    rest = solve_ik_all(
        arm, Position(g[:3, 3]), fixed_joints={name: arm.theta_to_dict(arm.ready)[name] for name in held}
    )
    assert rest.complete
