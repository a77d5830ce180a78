"""Scene snapshot: the arm, the layers that are on, and perhaps a motion, for a stand-alone page."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm, require_arm
from ...planning.trajectory import Trajectory
from ...support.checks import Array
from ..parts.findings import PENDING, examined
from ..parts.limit_checks import check_trajectory, checked_theta
from ..parts.playback import Playback
from ..parts.plots import plots
from ..parts.summary import describe_arm, extra_joints, named_poses, rest
from ..parts.tool_path import NO_PATH, tool_path
from ..protocol.messages import Message
from ..scene.arm_scene import Scene, build_scene
from ..stage import LAYERS, Stage
from .motion_samples import moving, recorded, standing
from .page_kinematics import kinematics

PLAYED = ("time", "running", "speed", "loop")
"""Of a playback, what the page goes on with."""

SAME = 1e-9
"""An arm this near [rad, m] to a trajectory's theta stands on it."""


@dataclass(frozen=True)
class SceneSnapshot:
    """`arm` at theta (n,) [rad, m] with the joints beside it, drawn as `scene`, and the layers that are on.

    `playback`: the motion that the page can play and the moment at which it begins, None for an arm that stands.
    `findings`: the message about them, None where the doctor has not looked. `recorded`: poses by name.
    """

    arm: Arm
    scene: Scene
    theta: Array
    others: Mapping[str, float]
    visible: Mapping[str, bool]
    path: Mapping[str, Any]
    playback: Playback | None
    findings: Message | None
    recorded: Mapping[str, Array] = field(default_factory=dict)

    def playing(self, trajectory: Trajectory) -> SceneSnapshot:
        """The same with `trajectory`, which begins at once, and its path; InputError where it is of another arm."""
        check_trajectory(self.arm, trajectory)
        playback = Playback(trajectory, running=True)
        return replace(self, playback=playback, path=tool_path(self.arm, trajectory))

    def data(self) -> dict[str, Any]:
        """What standalone.js reads; `aside` is where the arm stands if that is not on its motion.

        In any thread: the stage is not touched. The meshes that are left are read, and the doctor is asked if need be.
        """
        at, scene = self.playback, self.scene.whole()
        return {
            "arm": describe_arm(self.arm),
            "links": scene.links,
            "visible": dict(self.visible),
            "path": dict(self.path),
            "kinematics": kinematics(self.arm, list(self.others)),
            "others": dict(self.others),
            "poses": self._poses(),
            "samples": standing(self.theta) if at is None else moving(self.arm, at.trajectory),
            "aside": None if at is None or self._on(at) else self.theta.tolist(),
            "plots": plots(self.arm, at),
            "player": None if at is None else {name: getattr(at, name) for name in PLAYED},
            "objects": [base64.b64encode(part).decode("ascii") for part in scene.objects if part],
            "notes": scene.notes,
            "theory": recorded(self.arm, self.theta, None if at is None else at.trajectory),
            "findings": examined(self.arm, scene.reader) if self.findings is None else self.findings,
        }

    def _poses(self) -> dict[str, list[float]]:
        """By name what the page can go to: the arm's poses, and those recorded in the view."""
        named = {name: theta.tolist() for name, theta in named_poses(self.arm).items()}
        own = {f"{name} (recorded)" if name in named else name: theta.tolist() for name, theta in self.recorded.items()}
        return named | own

    def _on(self, playback: Playback) -> bool:
        """Whether the arm is where the motion has it: somebody may have moved it since."""
        return playback.running or bool(np.abs(playback.theta() - self.theta).max() < SAME)


def of_arm(arm: Arm, trajectory: Trajectory | None = None, theta: ArrayLike | None = None) -> SceneSnapshot:
    """`arm` at theta (n,), ready where not given, with everything on and `trajectory` playing if one is given."""
    start = require_arm(arm).ready if theta is None else checked_theta(arm, theta)
    if trajectory is not None:
        check_trajectory(arm, trajectory)  # before the meshes are read
    others = {name: rest(joint) for name, joint in extra_joints(arm).items()}
    shown = SceneSnapshot(arm, build_scene(arm), start, others, LAYERS, NO_PATH, None, None)
    return shown if trajectory is None else shown.playing(trajectory)


def on_show(stage: Stage, scene: Scene) -> SceneSnapshot:
    """What the pages of a live view show now, and the motion that is loaded; for the thread that the stage lives in.

    The findings are those of the pages, unless the doctor can and has yet to look.
    """
    playback = stage.player.playback
    unexamined = PENDING in stage.findings["note"] and not stage.driven
    return SceneSnapshot(
        stage.arm,
        scene,
        stage.theta.copy(),
        stage.others,
        stage.visible,
        stage.path,
        None if playback is None else replace(playback),
        None if unexamined else stage.findings,
        stage.program.list.named(),
    )
