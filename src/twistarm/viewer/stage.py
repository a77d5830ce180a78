"""What is on show: an arm at a configuration, the trajectory it plays, what is switched on. No threads, no sockets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm
from ..checks import Array
from ..errors import InputError, unknown_name
from ..planning.trajectory import Trajectory
from .admission import checked_theta, require_inside
from .findings import loaded
from .messages import Request
from .path import NO_PATH
from .playback import Playback
from .servo_words import SILENT
from .summary import describe_arm, extra_joints, joint_unit, named_poses, placement, rest

DRIVING = ("theta", "joint", "pose", "random", "play", "seek")
"""Requests that would move the arm under a servo's hands."""


class Stage:
    """The state that every page shows; each change is a method, each message about it a dict."""

    def __init__(self, arm: Arm, theta: ArrayLike | None = None) -> None:
        self.arm = arm
        self.theta = arm.ready if theta is None else checked_theta(arm, theta)
        self.extra_joints = extra_joints(arm)
        self.others = {name: rest(joint) for name, joint in self.extra_joints.items()}
        self.visible = {"screws": True, "frames": True, "path": True}
        self.path = NO_PATH
        self.findings = loaded(arm)
        self.playback: Playback | None = None
        self.driven = self.jogging = False
        self.report: dict[str, Any] = SILENT

    def show(self, theta: Array) -> None:
        """Stand at theta (n,); a running trajectory stops."""
        if self.playback is not None:
            self.playback.running = False
        self.theta = theta

    def load(self, trajectory: Trajectory, speed: float, loop: bool, now: float) -> None:
        """Play `trajectory` from its start."""
        self.playback = Playback(trajectory, speed, loop)
        self.playback.play(now)
        self.theta = self.playback.theta()

    def advance(self, now: float) -> None:
        """Follow a running trajectory up to `now` [s]; one that raises stops where it is."""
        if self.playback is None or not self.playback.running:
            return
        try:
            self.playback.advance(now)
            self.theta = checked_theta(self.arm, self.playback.theta())
        except Exception:
            self.playback.running = False
            raise

    @property
    def running(self) -> bool:
        """Whether a trajectory runs."""
        return self.playback is not None and self.playback.running

    def handle(self, request: Request, now: float) -> None:
        """Do what a page asks for. Raises TwistarmError and changes nothing where it cannot be done."""
        fields = request.fields
        self._require_no_servo(request)
        if request.kind == "theta":
            self.show(self._inside(checked_theta(self.arm, fields["theta"])))
        elif request.kind == "joint":
            self._set_joint(fields["name"], fields["value"])
        elif request.kind == "pose":
            self.show(self._pose(fields["name"]))
        elif request.kind == "random":
            self.show(checked_theta(self.arm, self.arm.random_theta(np.random.default_rng())))
        elif request.kind == "visible":
            self.set_visible(fields["what"], fields["visible"])
        else:
            self._drive(request, now)

    def take_commands(self) -> None:
        """A servo drives the arm, and takes commands of the pages."""
        self.driven = self.jogging = True

    def hear(self, report: Mapping[str, Any] | None) -> None:
        """What the servo says; None: it has ended."""
        self.driven = report is not None
        self.jogging = self.jogging and self.driven
        self.report = SILENT if report is None else dict(report)

    def set_visible(self, what: str, visible: bool) -> None:
        """Switch the screws, the frames or the tool's path on or off."""
        if what not in self.visible:
            raise unknown_name("layer", what, self.visible, within="the scene", listing=", ".join(self.visible))
        self.visible = {**self.visible, what: visible}

    def _require_no_servo(self, request: Request) -> None:
        gripper = request.kind == "joint" and request.fields["name"] in self.extra_joints
        if self.driven and request.kind in DRIVING and not gripper:
            raise InputError(
                f"a servo drives {self.arm.name}: sliders, poses and trajectories are free again once it has ended"
            )

    def _drive(self, request: Request, now: float) -> None:
        if self.playback is None:
            raise InputError(f"nothing to {request.kind}: no trajectory is loaded")
        if request.kind == "play":
            self.playback.play(now)
        elif request.kind == "pause":
            self.playback.running = False
        else:
            self.playback.seek(request.fields["time"])
            self.theta = checked_theta(self.arm, self.playback.theta())

    def _set_joint(self, name: str, value: float) -> None:
        if name in self.extra_joints:
            joint = self.extra_joints[name]
            require_inside(name, value, joint.lower, joint.upper, joint_unit(joint.type))
            self.others = {**self.others, name: value}
            return
        if name not in self.arm.joint_names:
            names = (*self.arm.joint_names, *self.extra_joints)
            raise unknown_name("joint", name, names, within=self.arm.name, listing=f"{len(names)} joints")
        i = self.arm.joint_names.index(name)
        require_inside(name, value, self.arm.limits.lower[i], self.arm.limits.upper[i], self.arm.units[i])
        theta = self.theta.copy()
        theta[i] = value
        self.show(theta)

    def _inside(self, theta: Array) -> Array:
        limits = self.arm.limits
        for joint in zip(self.arm.joint_names, theta, limits.lower, limits.upper, self.arm.units, strict=True):
            require_inside(*joint)
        return theta

    def _pose(self, name: str) -> Array:
        poses = named_poses(self.arm)
        if name not in poses:
            raise unknown_name("pose", name, poses, within=self.arm.name, listing=", ".join(poses))
        return poses[name]

    # messages -----------------------------------------------------------------------------------------

    def hello(self, links: Mapping[str, str]) -> dict[str, Any]:
        """What never changes: names, joints with units and slider ranges, poses, the node of every link."""
        return {"type": "hello", "arm": describe_arm(self.arm), "links": dict(links)}

    def frame(self) -> dict[str, Any]:
        """Where everything stands."""
        playback = self.playback
        return {
            "type": "frame",
            **placement(self.arm, self.theta, self.others),
            "time": 0.0 if playback is None else playback.time,
            "running": self.running,
        }

    def player(self) -> dict[str, Any]:
        """The trajectory that is loaded; duration null where none is."""
        return {"type": "player", "duration": None if self.playback is None else self.playback.duration}

    def servo(self) -> dict[str, Any]:
        """Whether a servo drives the arm and takes commands of the pages, and what it last said: status null before it
        said anything.
        """
        return {"type": "servo", "jog": self.jogging, "driven": self.driven, **self.report}

    def way(self) -> dict[str, Any]:
        """The path of the tool that is drawn; no points where none is."""
        return {"type": "path", **self.path}

    def switches(self) -> dict[str, Any]:
        """What is switched on."""
        return {"type": "visible", **self.visible}
