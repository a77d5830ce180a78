"""Two held twists that a servo shook under, and what the joints' rates look like."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from twistarm import Arm
from twistarm.control.servo import TwistCommand

from .servo_arms import Array, servo_arm
from .servo_held import DT, held

SECONDS = 15.0

EXAMPLES: dict[str, tuple[str, Callable[[Arm], Array], list[float]]] = {
    "rover_arm from reach, up at 0.1 m/s": ("rover_arm", lambda arm: arm.theta_from("reach"), [0, 0, 0.1, 0, 0, 0]),
    "four joints, sideways at 0.05 m/s": (
        "four_joints",
        lambda arm: np.array([0.0, -1.05, 0.35, 0.7]),
        [0, 0.05, 0, 0, 0, 0],
    ),
}
"""The arm, where it starts, and the twist in base axes."""


def driven(title: str) -> tuple[Arm, Array, Array, list[str]]:
    """The arm, its joints' rates cycle by cycle, what was said beside, and the status."""
    name, start, twist = EXAMPLES[title]
    arm = servo_arm(name)
    return arm, *held(arm, start(arm), TwistCommand(twist, "base"), SECONDS)


def plot(path: Path) -> None:
    """One panel per example, one line per joint."""
    figure = Figure(figsize=(10, 6), layout="constrained")
    for panel, title in zip(figure.subplots(len(EXAMPLES), 1, squeeze=False)[:, 0], EXAMPLES, strict=True):
        arm, rates, _, _ = driven(title)
        panel.plot(DT * np.arange(len(rates)), rates, lw=0.8, label=arm.joint_names)
        panel.set(title=title, xlabel="time [s]", ylabel="joint rates [rad/s]")
        panel.grid(alpha=0.3)
        panel.legend(loc="upper right", ncols=arm.n, frameon=False)
    figure.savefig(path, dpi=110)
