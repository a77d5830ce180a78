"""What the doctor says an arm cannot do, held against finite differences of its forward kinematics, and its words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from finding_cases import chain
from twistarm import Approach, Arm, ArmBuilder, diagnose, load_arm, solve_ik
from twistarm.arm.abilities import abilities_of
from urdf_text import joint, robot, write

STEP = 1e-5
NONE = 2e-3
"""Less than this [m/reach per rad, rad per rad] is no motion: the doctor looks at a thousandth."""


def differences(arm: Arm, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Velocity of the tool's origin (in reaches) and angular velocity in base axes, (3, n) each, and R."""
    scale = np.where(np.array(arm.units) == "m", arm.reach, 1.0)
    linear, angular = np.empty((3, arm.n)), np.empty((3, arm.n))
    for i, step in enumerate(np.diag(STEP * scale)):
        plus, minus = arm.fk(theta + step), arm.fk(theta - step)
        linear[:, i] = (plus - minus)[:3, 3] / (2 * STEP * arm.reach)
        turn = (plus[:3, :3] @ minus[:3, :3].T) / (2 * STEP)
        angular[:, i] = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    return linear, angular, arm.fk(theta)[:3, :3]


def require_true(arm: Arm) -> None:
    """Ranks and directions hold at postures that the doctor has not looked at."""
    said = abilities_of(arm)
    postures = arm.random_theta(np.random.default_rng(99), 10)
    positions, turnings = [], []
    for theta in postures:
        linear, angular, R = differences(arm, theta)
        assert np.abs(said.immovable @ linear).max(initial=0.0) < NONE
        assert np.abs(said.unturned @ angular).max(initial=0.0) < NONE
        _, sizes, Vt = np.linalg.svd(linear)
        positions.append(int((sizes > NONE).sum()))
        held = angular @ Vt[said.position :].T
        U, sizes, _ = np.linalg.svd(held)
        turnings.append(int((sizes > NONE).sum()))
        free = U[:, : said.turning]
        for axes in (said.turned_base, said.turned_tool @ R.T):
            assert np.abs(axes - axes @ free @ free.T).max(initial=0.0) < NONE
    assert max(positions) == said.position
    assert max(turnings) == said.turning


def test_statements_about_the_catalogue_are_true(catalogue_arm: Arm) -> None:
    require_true(catalogue_arm)


def back(master: str) -> str:
    return f'<axis xyz="0 1 0"/><mimic joint="{master}" multiplier="-1"/>'


PALLETISER = robot(
    joint("yaw", "base_link", "column", xyz="0 0 0.3"),
    joint("shoulder", "column", "upper", inside='<axis xyz="0 1 0"/>', xyz="0 0 0.1"),
    joint("elbow", "upper", "fore", inside='<axis xyz="0 1 0"/>', xyz="0.5 0 0"),
    joint("un_elbow", "fore", "half", inside=back("elbow"), xyz="0.5 0 0"),
    joint("un_shoulder", "half", "level", inside=back("shoulder"), xyz="0 0 0"),
    joint("roll", "level", "tool0", xyz="0.1 0 0"),
    links=("base_link", "column", "upper", "fore", "half", "level", "tool0"),
)  # fmt: skip

X, Y, Z = ("the base's x axis", "the base's y axis", "the base's z axis")

ARMS = {
    "gantry": (chain("1 0 0", "0 1 0", "0 0 1", kind="prismatic"), {"cannot-turn": (X, Y, Z)}),
    "roll on the spot": (chain("0 0 1"), {"cannot-move": (X, Y, Z), "cannot-turn": (X, Y)}),
    "lever": (chain("0 1 0"), {"cannot-move": (Y,), "cannot-turn": (X, Z), "cannot-turn-in-place": ()}),
    "pan and tilt": (chain("0 0 1", "0 1 0"), {"cannot-move": (), "cannot-turn-in-place": ()}),
    "yaw, pitches, roll": (
        chain("0 0 1", "0 1 0", "0 1 0", "0 1 0", "0 0 1"), {"cannot-turn-in-place": ("its z axis",)}
    ),
    "palletiser": (PALLETISER, {"cannot-turn": (X, Y)}),
    "six": (chain("0 0 1", "0 1 0", "0 1 0", "0 0 1", "0 1 0", "0 0 1"), {}),
}  # fmt: skip
"""What they cannot do, and the axes that the finding names."""


@pytest.mark.parametrize("name", ARMS)
def test_what_an_arm_cannot_do(name: str, tmp_path: Path) -> None:
    text, expected = ARMS[name]
    path = write(tmp_path, text)
    require_true(load_arm(path))
    said = {one.code: one.what for one in diagnose(path) if one.code.startswith("cannot-")}
    assert said.keys() == expected.keys()
    for code, axes in expected.items():
        assert [axis for axis in (X, Y, Z, "its z axis") if axis in said[code]] == list(axes)


def test_where_an_approach_can_be_asked_for_it_can_be_met() -> None:
    """A forearm that rolls and a wrist that pitches point the tool's z axis, drawn outward, any way near by."""
    home = np.array([[0, 0, 1.0, 0.8], [0, 1, 0, 0], [-1, 0, 0, 0.3], [0, 0, 0, 1]])
    builder = ArmBuilder("made").revolute("turn", [0, 0, 1], [0, 0, 0]).revolute("shoulder", [0, 1, 0], [0, 0, 0.3])
    builder = builder.revolute("elbow", [0, 1, 0], [0.3, 0, 0.3]).revolute("roll", [1, 0, 0], [0, 0, 0.3])
    arm = builder.revolute("pitch", [0, 1, 0], [0.6, 0, 0.3]).tool(home).build()
    (said,) = [one for one in diagnose(arm) if one.code == "cannot-turn-in-place"]
    assert "Approach" in said.remedy
    assert "its z axis" in said.remedy
    g = arm.fk([0.2, 0.3, 0.8, 0.5, 0.6])
    for turn in ((0.03, 0.0), (0.0, 0.03), (-0.03, 0.03)):
        direction = g[:3, 2] + turn[0] * g[:3, 0] + turn[1] * g[:3, 1]
        assert solve_ik(arm, Approach(g[:3, 3], direction), [0.2, 0.3, 0.8, 0.5, 0.6]).converged
