"""Servo commands of the pages from buttons, keys and gamepads. Each page is a separate sender."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from ...arm.arm import Arm
from ...control.servo.settings import ON_UNREACHABLE, SLIDE, ServoSettings
from ...control.stream import Inbox, command_of
from ...support.errors import InputError
from ..protocol.messages import Request

COMMANDS = ("jog", "jog_joints", "stop")


class PageCommands:
    """An inbox with the pages' commands for a servo.

    It takes nothing before its first use.

    open: a servo of the program reads it. drive: the pages' servo reads it. on_unreachable: the pages' choice at
    limits. free: a servo of the program uses this choice.

    A page that jogs must repeat its command. `stop`, a closed page and a malformed message stop the arm.
    """

    def __init__(self, arm: Arm) -> None:
        self.arm = arm
        self.inbox = Inbox()
        self.open = self.drive = self.free = False
        self.on_unreachable = SLIDE
        self._jogging: set[str] = set()

    def servo_settings(self, settings: ServoSettings) -> Callable[[], ServoSettings]:
        """A function that returns `settings` with the pages' present `on_unreachable`."""
        chosen = {on_unreachable: replace(settings, on_unreachable=on_unreachable) for on_unreachable in ON_UNREACHABLE}
        return lambda: chosen[self.on_unreachable]

    def take(self, request: Request, sender: str) -> None:
        """Put a command of the page `sender` into the inbox. Raises InputError for an invalid one."""
        if not (self.open or self.drive):
            raise InputError(
                "no servo takes commands here: start one by `twistarm servo ARM`, by Viewer.commands, "
                "or by the switch Drive in the Jog panel"
            )
        stops = request.kind == "stop"
        try:
            command = command_of(self.arm, self._message(request))
        except InputError as error:
            self.refuse(sender, str(error))
            raise
        self.inbox.put(sender, command, time.monotonic())
        (self._jogging.discard if stops else self._jogging.add)(sender)

    def _message(self, request: Request) -> Mapping[str, Any]:
        """The command as `command_of` takes it."""
        if request.kind == "stop":
            return {"stop": True}
        if request.kind == "jog":
            return request.fields
        rates, names = request.fields["rates"], self.arm.joint_names
        if len(rates) != len(names):
            raise InputError(f"rates must be {len(names)} numbers, base to tip: {', '.join(names)}; got {len(rates)}")
        return {"jog": dict(zip(names, rates, strict=True))}

    def refuse(self, sender: str, reason: str) -> None:
        """Handle an unusable message or the end of a page. If the page jogs, the arm comes to rest."""
        if sender in self._jogging:
            self._jogging.discard(sender)
            self.inbox.refuse(sender, reason, time.monotonic())
