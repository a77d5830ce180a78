"""Families are recognised from the axes, exact or as an export rounds them, and named; what misses says by how much."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import twistarm
from catalogue import load
from family_arms import CASES, apart, family_arm, missed, pose_of
from twistarm.ik import Approach, Pose, Position
from twistarm.ik.closed_form.methods import method_for


def a_pose(arm):
    return Pose(arm.home)


@pytest.mark.parametrize("name", CASES)
def test_the_family_is_recognised_from_the_axes(name):
    arm, case = family_arm(name), CASES[name]
    method = method_for(arm, a_pose(arm))
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
    method = method_for(arm, a_pose(arm))
    if method.family is None:  # a smaller group is exact, or elimination takes arms of five and six joints
        assert method.name == "elimination"
    theta = arm.random_theta(rng)
    g = pose_of(arm, theta)
    found = twistarm.solve_ik_all(arm, Pose(g))
    assert found.complete == method.exact
    assert method.exact or "but for" in found.family
    assert min(apart(arm, each, theta) for each in found) < 1e-6
    assert max(missed(arm, g, each) for each in found) < 1e-9


@pytest.mark.parametrize(
    "name",
    ["parallel 3-4-5", *(pytest.param(each, marks=pytest.mark.slow) for each in ("spherical wrist", "six skew turns"))],
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
        entries = twistarm.solve_ik_all(arm, Pose(g)).members  # of a family the one found on the limits is a member
        assert any(apart(arm, each, theta) < 1e-4 for entry in entries for each in entry)
        assert twistarm.solve_ik(arm, Pose(g)).converged
        found += 1


def test_seven_joints_have_a_family_with_one_given():
    arm = load("panda")
    method = method_for(arm, Pose(arm.fk(arm.ready)), (6,))
    assert method.exact
    assert method.held == (6,)
    assert method.swept == ()
    assert method_for(arm, Pose(arm.fk(arm.ready))).swept != ()


def test_targets_that_leave_something_free_fit_fewer_joints():
    five, three = family_arm("R-RRR-R"), load("rr_planar")
    assert method_for(five, Approach([0.5, 0, 0.3], [0, 0, -1], tool_axis=[0, 0, 1])).exact
    assert method_for(three, Position([0.5, 0.1, 0.0])).exact
    rolling = method_for(five, Approach([0.5, 0, 0.3], [1, 0, 0], tool_axis=[1, 0, 0]))
    assert rolling.there


def test_what_misses_a_family_says_which_axes_and_by_how_much():
    arm = family_arm("spherical wrist, slides")
    xi = np.array(arm.screws)
    xi[:3, 3] += np.cross([0, 0.02, 0.02], xi[3:, 3])  # axis 4 goes past the other two at 28 mm
    off = twistarm.arm_from_screws(xi, arm.home, limits=arm.limits, joints=arm.joint_names)
    with pytest.raises(twistarm.NoClosedFormError, match=r"joint\d.*(mm|parallel)"):
        twistarm.solve_ik_all(off, Pose(arm.home), closed_form=True)
