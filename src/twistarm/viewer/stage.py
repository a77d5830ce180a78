"""The state on show: an arm, its configuration, trajectory and layers, and the transfer to another."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arm.arm import Arm
from ..collision import Scene
from ..design.voxel_map import digest_of
from ..limits.joint_limits import unit_of
from ..planning.trajectory import Trajectory
from ..planning.within import require_within, returning
from ..support.errors import LimitError, listed, unknown_name
from .jobs import Job
from .messages import Message, PageRequest, Source
from .parts.arm_data import (
    LIMIT_TOL,
    checked_theta,
    describe_arm,
    extra_joints,
    loading_findings,
    require_all_inside,
    require_inside,
    rest,
    tool_path,
)
from .parts.collisions import Collisions
from .parts.custom import Controls
from .parts.player import Player
from .parts.program import Program
from .parts.reach import Reach
from .parts.show import NO_REPORT, Part, Route, Show
from .parts.target import Choices, Solutions, TargetPart
from .parts.theory import Theory
from .scene.core_numbers import core_numbers
from .scene.kinematics import kinematics

NUMBERS = count(1)  # Of stages: an answer that a page computed for one arm is none for another.


class Stage(Show):
    """The state that all pages show, with their requests and messages."""

    def __init__(
        self, arm: Arm, theta: ArrayLike | None = None, scene: Scene | None = None, beside: Arm | None = None
    ) -> None:
        super().__init__(arm, theta)
        self.number = next(NUMBERS)
        self.scene = scene
        self._beside = beside
        self.findings = loading_findings(arm)
        self.program = Program(arm, self.poses)
        self.reach = Reach()
        self.solutions = Solutions()
        self.collisions = Collisions(scene, self.solutions)
        self.controls = Controls()
        self.drawings: dict[str, Message] = {}  # by node
        named = (self.reach, self.program, self.solutions, self.collisions, self.controls)
        self.parts: tuple[Part, ...] = (Player(), TargetPart(), Theory(arm), *named)
        self.jogging = False
        self.report: dict[str, Any] = NO_REPORT
        self._routes = {
            "theta": Route(_show_theta, moves=True),
            "joint": Route(_move_joint),
            "pose": Route(lambda show, now, name, ease: show.go(show.arm.theta_from(name), ease, now), moves=True),
            "random": Route(_go_anywhere, moves=True),
            **{kind: route for part in self.parts for kind, route in part.routes.items()},
        }

    def show_solutions(self, choices: Choices | None) -> None:
        """Show these configurations in the pages and move the arm to the nearest. None clears them."""
        if choices is None:
            self.solutions.release()
            return
        self.show(choices.theta[0] if choices.inside else self.theta)
        self.solutions.take(choices, self.theta)

    def show_reach(self, message: Message | None) -> None:
        """Show this map in the pages, or hide the one that is there."""
        self.reach.map = message or self.reach.map
        self.set_visible("reach", message is not None)

    def handle(self, request: PageRequest, now: float) -> Job | None:
        """Handle a page's request or return a job for it. Raises TwistarmError without any change."""
        route = self._routes[request.kind]
        if route.moves:
            self.require_free()
        return route.handle(self, now, **request.fields)

    def take_commands(self) -> None:
        """A servo drives the arm, and takes commands of the pages."""
        self.driven = self.jogging = True

    def show_choice(self, on_unreachable: str, free: bool) -> None:
        """The servo's behaviour at limits. `free`: a servo in your program follows this choice."""
        self.drive = {**self.drive, "on_unreachable": on_unreachable, "free": free}

    def begin_drive(self, note: str) -> None:
        """A servo of the pages drives the arm. `note` lists the assumed limits."""
        self.stop()
        self.take_commands()
        self.drive = {**self.drive, "on": True, "note": note}

    def end_drive(self, another_drives: bool) -> None:
        """The drive of the pages has ended. `another_drives`: another servo has the arm now."""
        self.drive = {**self.drive, "on": False, "note": ""}
        if not another_drives:
            self.set_servo_status(None)

    def set_servo_status(self, report: Mapping[str, Any] | None) -> None:
        """Keep the servo's report. None: the servo has ended."""
        self.driven = report is not None
        self.jogging = self.jogging and self.driven
        self.report = NO_REPORT if report is None else dict(report)

    def set_visible(self, what: str, visible: bool) -> None:
        """Switch a layer of every page, which may then switch its own."""
        _, revision = self.visible[what]
        self.visible = {**self.visible, what: [visible, revision + 1]}

    def take_over(self, old: Stage) -> list[str]:
        """Take over the state of another arm's stage. Returns the changes and omissions in words.

        Joints keep their values by name, or their limits. New ones are as in ready. Layers, controls, drawings and
        obstacles stay. Poses and the motion stay if the joints have the same names and the limits hold. A map stays if
        the arm is the same.
        """
        self.visible, self.needed, self.tolerances = old.visible, old.needed, old.tolerances
        self.drawings = old.drawings
        self.controls.take_over(old.controls)
        self.collisions.take_over(old.collisions)
        if digest_of(self.arm) == digest_of(old.arm):
            self.reach.map = old.reach.map
        words = [*self._take_values(old), *self.poses.take_over(old.poses)]
        if old.playback is not None and self._fits(motion := old.playback.trajectory):
            self.playback = old.playback
            if old.path["points"]:
                self.draw_path(tool_path(self.arm, motion))
        elif old.playback is not None:
            words.append("the motion no longer fits the arm and is removed")
        return words

    def _take_values(self, old: Stage) -> list[str]:
        """Take over the values of joints by name; the joints that had to move to a limit."""
        before = dict(zip(old.arm.joint_names, old.theta.tolist(), strict=True)) | dict(old.others)
        moved = []

        def inside(name: str, default: float, lower: float, upper: float) -> float:
            value = float(np.clip(before.get(name, default), lower, upper))
            if abs(value - before.get(name, default)) > LIMIT_TOL:
                moved.append(name)
            return value

        arm, limits = self.arm, self.arm.limits
        joints = zip(arm.joint_names, self.theta.tolist(), limits.lower, limits.upper, strict=True)
        self.theta = np.array([inside(*joint) for joint in joints])
        others = ((name, value, self.extra_joints[name]) for name, value in self.others.items())
        self.others = {name: inside(name, value, joint.lower, joint.upper) for name, value, joint in others}
        return [f"moved to the nearer limit: {listed(moved, 6)}"] if moved else []

    def _fits(self, motion: Trajectory) -> bool:
        """Whether a motion has this arm's joints and limits. Its start may be beyond the limits."""
        if motion.joint_names == self.arm.joint_names:
            with suppress(LimitError):
                require_within(motion, returning(self.arm.limits, motion(0.0), self.arm.units))
                return True
        return False

    # messages -----------------------------------------------------------------------------------------

    def hello(self, links: Mapping[str, str]) -> Message:
        """Constant data: names, joints with units and slider ranges, poses, the node of each link, what moves it.

        The pages move a second arm `beside` themselves, from its ready configuration.
        """
        beside = None
        if (other := self._beside) is not None:
            others = {name: rest(joint) for name, joint in extra_joints(other).items()}
            beside = {**_described(other, list(others)), "theta": other.ready.tolist(), "others": others}
        described = _described(self.arm, list(self.others))
        return {"type": "hello", "number": self.number, **described, "links": dict(links), "beside": beside}

    def messages(self) -> list[Message]:
        """Messages of the whole state, the frame last."""
        return [message for source in self.sources() for message in source()]

    def sources(self) -> list[Source]:
        """The sources of messages. An error in one does not affect the others."""
        return [
            lambda: [{"type": "visible", **self.visible}, self.path],
            *(partial(part.messages, self) for part in self.parts),
            lambda: [self.drive, self.servo(), self.findings],
            self.drawings.values,
            lambda: [self.frame()],
        ]

    def frame(self) -> Message:
        """The current frame: joint values [rad, m], time [s], whether a motion runs, and its rates."""
        return {
            "type": "frame",
            "theta": self.theta.tolist(),
            "others": self.others,
            "time": 0.0 if self.playback is None else self.playback.time,
            "running": self.running,
            "rates": self.rates,
        }

    def servo(self) -> Message:
        """Whether a servo drives the arm and takes commands, and its last status (None at first)."""
        return {"type": "servo", "jog": self.jogging, "driven": self.driven, **self.report}


def _show_theta(show: Show, now: float, theta: list[float]) -> None:
    checked = checked_theta(show.arm, theta)
    require_all_inside(show.arm, checked)
    show.show(checked)


def _go_anywhere(show: Show, now: float, ease: bool) -> None:
    show.go(checked_theta(show.arm, show.arm.random_theta(np.random.default_rng())), ease, now)


def _move_joint(show: Show, now: float, name: str, value: float) -> None:
    """Move a joint of the arm, or one beside it such as a gripper's. A servo leaves those free."""
    arm = show.arm
    if name in show.extra_joints:
        joint = show.extra_joints[name]
        require_inside(name, value, joint.lower, joint.upper, unit_of(joint.type))
        show.others = {**show.others, name: value}
        return
    show.require_free()
    if name not in arm.joint_names:
        names = (*arm.joint_names, *show.extra_joints)
        raise unknown_name("joint", name, names, within=arm.name, listing=f"{len(names)} joints")
    i = arm.joint_names.index(name)
    require_inside(name, value, arm.limits.lower[i], arm.limits.upper[i], arm.units[i])
    theta = show.theta.copy()
    theta[i] = value
    show.show(theta)


def _described(arm: Arm, others: list[str]) -> dict[str, Any]:
    return {"arm": describe_arm(arm), "kinematics": kinematics(arm, others), "core": core_numbers(arm)}
