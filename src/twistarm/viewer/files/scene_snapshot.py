"""A snapshot of the scene for a saved page: arm, visible layers, and an optional motion."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm
from ...planning.trajectory import Trajectory
from ...support.checks import Array
from ..parts.arm_data import check_trajectory, describe_arm, named_poses, tool_path
from ..parts.findings import PENDING, examined
from ..parts.player import plots
from ..parts.show import Playback
from ..parts.theory import axes, most_moved, numbers
from ..protocol.messages import Message
from ..scene.arm_drawing import Drawing
from ..scene.kinematics import kinematics
from ..stage import Stage

PLAYED = ("time", "running", "speed", "loop")
"""State of a playback that the page continues."""

SAME = 1e-9
"""An arm within this [rad, m] of a trajectory's theta is on the trajectory."""

SAMPLE_TIME = 1.0 / 30.0
"""Time between samples [s]. The page interpolates between them."""

MOST_SAMPLES = 2000
"""Most samples of a motion, which keep the file within a megabyte."""

DECIMALS = 9
"""Decimals of values in rad and m."""

MOST_NUMBERS = 250
"""Most samples with numbers of the theory: some 600 kB for seven joints."""

NUMBERS_PER_SECOND = 15.0

NUMBER_DECIMALS = 6


@dataclass(frozen=True)
class SceneSnapshot:
    """`arm` at theta (n,) [rad, m] with its other joints, drawn as `drawing`, and the visible layers.

    `playback` is the motion that the page plays and its start time, or None. `findings` is their message, or None
    before the doctor has run. `recorded` holds poses by name, `obstacles` and `shapes` what is drawn of a scene, and
    `reach` what is drawn of a map. `drawings` are the messages of a program's drawings.
    """

    arm: Arm
    drawing: Drawing
    theta: Array
    others: Mapping[str, float]
    visible: Mapping[str, bool]
    path: Mapping[str, Any]
    playback: Playback | None
    findings: Message | None
    recorded: Mapping[str, Array] = field(default_factory=dict)
    obstacles: Sequence[Mapping[str, Any]] = ()
    shapes: Sequence[Mapping[str, Any]] = ()
    reach: Message | None = None
    drawings: Sequence[Message] = ()

    def playing(self, trajectory: Trajectory) -> SceneSnapshot:
        """A copy with `trajectory` and its path, playing from the start.

        Raises InputError for another arm's trajectory.
        """
        check_trajectory(self.arm, trajectory)
        playback = Playback(trajectory, running=True)
        return replace(self, playback=playback, path=tool_path(self.arm, trajectory))

    def data(self) -> dict[str, Any]:
        """The data for standalone.js.

        `aside` is the arm's configuration if it is not on the motion.

        It may run in any thread, because it does not touch the stage. It reads remaining meshes and runs the doctor if
        needed.
        """
        at, drawing = self.playback, self.drawing.whole()
        skipped = drawing.live | {b""}
        still = {"times": [0.0], "theta": [self.theta.tolist()]}
        return {
            "arm": describe_arm(self.arm),
            "links": drawing.links,
            "visible": dict(self.visible),
            "path": dict(self.path),
            "kinematics": kinematics(self.arm, list(self.others)),
            "others": dict(self.others),
            "poses": self._poses(),
            "samples": still if at is None else _moving(at.trajectory),
            "aside": None if at is None or self._on(at) else self.theta.tolist(),
            "plots": plots(self.arm, None if at is None else at.trajectory),
            "player": None if at is None else {name: getattr(at, name) for name in PLAYED},
            "objects": [base64.b64encode(part).decode("ascii") for part in drawing.objects if part not in skipped],
            "obstacles": self.obstacles,
            "shapes": self.shapes,
            "reach": self.reach,
            "drawings": self.drawings,
            "notes": drawing.notes,
            "theory": sampled_theory(self.arm, self.theta, None if at is None else at.trajectory),
            "findings": examined(self.arm) if self.findings is None else self.findings,
        }

    def _poses(self) -> dict[str, list[float]]:
        """Poses that the page can go to, by name: the arm's and the recorded ones."""
        named = {name: theta.tolist() for name, theta in named_poses(self.arm).items()}
        own = {f"{name} (recorded)" if name in named else name: theta.tolist() for name, theta in self.recorded.items()}
        return named | own

    def _on(self, playback: Playback) -> bool:
        """Whether the arm is on its motion; a user may have moved it."""
        return playback.running or bool(np.abs(playback.theta() - self.theta).max() < SAME)


def of_arm(arm: Arm, trajectory: Trajectory | None = None, theta: ArrayLike | None = None) -> SceneSnapshot:
    """`arm` at theta (n,), by default ready, with all layers and `trajectory` playing."""
    shown = on_show(Stage(arm, theta), Drawing(arm))
    return shown if trajectory is None else shown.playing(trajectory)


def on_show(stage: Stage, drawing: Drawing) -> SceneSnapshot:
    """What the pages of a live view show now, and the loaded motion.

    Call it in the stage's thread.

    The findings are those of the pages, unless the doctor has not run yet.
    """
    playback = stage.playback
    unexamined = PENDING in stage.findings["note"] and not stage.driven
    return SceneSnapshot(
        stage.arm,
        drawing,
        stage.theta.copy(),
        stage.others,
        {layer: on for layer, (on, _) in stage.visible.items()},
        stage.path,
        None if playback is None else replace(playback),
        None if unexamined else stage.findings,
        stage.poses.named(),
        stage.collisions.drawn,
        stage.collisions.shapes,
        stage.reach.drawn if stage.visible["reach"][0] or "reach" in stage.needed else None,
        [*stage.drawings.values()],
    )


def _moving(trajectory: Trajectory) -> dict[str, Any]:
    """times (k,) [s] and theta (k, n): `trajectory` from its start to its end."""
    duration = float(trajectory.duration)
    count = min(MOST_SAMPLES, max(2, 1 + int(np.ceil(duration / SAMPLE_TIME))))
    times = np.linspace(0.0, duration, count if duration > 0.0 else 1)
    return {"times": times.tolist(), "theta": np.round(trajectory(times), DECIMALS).tolist()}


def sampled_theory(arm: Arm, theta: Array, trajectory: Trajectory | None) -> dict[str, Any]:
    """The axes, times (k,) [s], the numbers at each, and `aside`, those at the shown theta (n,).

    `moved`: the joint that is fastest at that moment, metres measured in the reach.
    """
    there = _rounded({"moved": 0, **numbers(arm, theta)})
    if trajectory is None:
        return {"axes": axes(arm), "times": [0.0], "numbers": [there], "aside": there}
    duration = float(trajectory.duration)
    times = np.linspace(0.0, duration, min(MOST_NUMBERS, 2 + int(duration * NUMBERS_PER_SECOND)))
    found = []
    for at, rates in zip(trajectory(times), trajectory(times, 1), strict=True):
        found.append(_rounded({"moved": most_moved(arm, rates), **numbers(arm, at, rates)}))
    return {"axes": axes(arm), "times": _rounded(times.tolist()), "numbers": found, "aside": there}


def _rounded(value: Any) -> Any:
    """`value` with every float in it to `NUMBER_DECIMALS`; what is whole is written so."""
    if isinstance(value, float):
        near = round(value, NUMBER_DECIMALS)
        return int(near) if near.is_integer() else near
    if isinstance(value, dict):
        return {name: _rounded(each) for name, each in value.items()}
    return [_rounded(each) for each in value] if isinstance(value, list) else value
