"""Commands of the pages for a servo: keys and gamepad arrive as twists, and each page is a commander of its own."""

from __future__ import annotations

import time

from ..arm import Arm
from ..errors import InputError
from ..stream import Inbox, command_of
from .messages import Request

COMMANDS = ("jog", "stop")


class PageCommands:
    """What the pages command, in an inbox that a servo reads; nothing is taken before somebody asks for that inbox.

    A page that jogs must go on saying so. It stops the arm by `stop`, by going, and by anything that makes no sense.
    """

    def __init__(self, arm: Arm) -> None:
        self.arm = arm
        self.inbox = Inbox()
        self.open = False
        self._jogging: set[str] = set()

    def take(self, request: Request, sender: str) -> None:
        """Put a command of the page `sender` into the inbox. Raises InputError for what is none."""
        if not self.open:
            raise InputError("no servo takes commands here: start one by `twistarm servo ARM`, or by Viewer.commands")
        stops = request.kind == "stop"
        try:
            command = command_of(self.arm, {"stop": True} if stops else request.fields)
        except InputError as error:
            self.refuse(sender, str(error))
            raise
        self.inbox.put(sender, command, time.monotonic())
        (self._jogging.discard if stops else self._jogging.add)(sender)

    def refuse(self, sender: str, reason: str) -> None:
        """Something of the page that cannot be used, or its end: where it jogs, the arm comes to rest."""
        if sender in self._jogging:
            self._jogging.discard(sender)
            self.inbox.refuse(sender, reason, time.monotonic())
