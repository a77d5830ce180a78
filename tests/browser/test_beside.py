"""Two arms on a page: the second stands where its own sliders or the first one's joints put it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from arms import load
from twistarm import Arm
from twistarm.viewer import Viewer
from waiting import settled, until

pytestmark = [pytest.mark.browser, pytest.mark.smoke]

SHOWN = """(links) => {
  const { shared, arm: { theta, others } } = twistarm.parts.beside;
  const paths = ["", ...links.map((name) => `/arm/link:${name}`)];
  const [back, ...drawn] = paths.map((path) => twistarm.view.drawn(`/beside${path}`));
  return [theta, others, [...shared.keys()], back, drawn];
}"""


def second(page: Any, arm: Arm) -> tuple[list[float], list[str], Any]:
    """Theta of the second arm, the joints that can follow, and where its base is; its links are at its poses."""
    names = list(arm.description.links) if arm.description else []
    theta, others, shared, base, drawn = page.evaluate(SHOWN, names)
    poses, root = arm.poses(theta, others), np.reshape(base, (4, 4)).T
    for name, columns in zip(names, drawn, strict=True):
        assert_allclose(np.reshape(columns, (4, 4)).T, root @ poses[name], atol=1e-9, err_msg=name)
    return theta, shared, root


def test_a_second_arm_follows_by_name_or_has_its_own_joints(page: Any) -> None:
    arm, other = load("rover_arm"), load("rover_arm_6dof")
    with Viewer(arm, open_browser=False, beside=other) as viewer:
        settled(page, viewer.url)
        theta = arm.ready + [0.1, 0.2, -0.1, 0.3, 0.4]
        viewer.show(theta)
        until(page, f"twistarm.state.frame.theta[0] === {theta[0]}")
        x, shared, base = second(page, other)
        assert set(shared) >= set(arm.joint_names) & set(other.joint_names) != set()
        expected = other.ready.copy()
        for name, value in zip(arm.joint_names, theta, strict=True):
            if name in other.joint_names:
                i = other.joint_names.index(name)
                expected[i] = np.clip(value, other.limits.lower[i], other.limits.upper[i])
        assert_allclose(x, expected, atol=1e-12)
        assert_allclose(base, np.eye(4))
        ghost = "twistarm.view.node('/beside').getObjectByProperty('isMesh', true).material.opacity"
        assert page.evaluate(ghost) < 0.5

        page.get_by_label("Side by side").check()
        assert page.evaluate(ghost) == 1
        assert second(page, other)[2][1, 3] > 0.3

        page.get_by_label("Follow the first").uncheck()
        i = next(i for i, name in enumerate(other.joint_names) if name in shared and np.isfinite(other.limits.lower[i]))
        moved = other.joint_names[i]
        row = page.get_by_role("region", name="Second arm").get_by_role("slider", name=moved, exact=True)
        row.focus()
        page.keyboard.press("Home")
        assert second(page, other)[0][i] == pytest.approx(other.limits.lower[i])
        assert viewer.theta == pytest.approx(theta, abs=1e-12), "the first stays"
        viewer.show(arm.ready)
        until(page, f"twistarm.state.frame.theta[0] === {arm.ready[0]}")
        assert second(page, other)[0][i] == pytest.approx(other.limits.lower[i])
