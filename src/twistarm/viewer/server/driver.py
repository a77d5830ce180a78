"""Servo commands of the pages, and Drive: a switch for a servo on simulated joints in the view."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import replace
from math import inf
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...arm.usual_limits import defaults_line
from ...control.servo import PoseCommand, ServoOutput, ServoSettings, ServoState
from ...control.servo.settings import ON_UNREACHABLE, SLIDE
from ...control.stream import Cycle, Ending, Inbox, Reading, SimulatedJoints, StreamOptions, command_of, run
from ...support.checks import require
from ...support.errors import InputError
from ..messages import PageRequest, words_of
from ..parts.arm_data import require_all_inside
from ..parts.show import NO_REPORT
from ..stage import Stage

COMMANDS = ("jog", "jog_joints", "stop")

STOP_TIMEOUT = 3.0  # Seconds until a drive ends although its joints still move, as with very low accelerations.
Post = Callable[[str, Callable[[Stage], None]], None]  # Applies a change of the stage in the loop.


def servo_words(answer: Cycle | ServoOutput) -> dict[str, Any]:
    """The answer of a servo or its loop in words.

    The message has `status` of a ServoOutput or null, `joint` by name or null, and `reason` as text. `share` is the
    executed share of the command from 0 to 1, or null.
    """
    output, moving = answer, True
    if not isinstance(output, ServoOutput):
        cycle = require(answer, Cycle, "answer", "as stream.run hands to on_cycle, or a ServoOutput, or None")
        if cycle.setpoint is None or not cycle.delivered:
            return {**NO_REPORT, "reason": cycle.reason}
        reading, output = cycle.reading, cycle.setpoint.output
        if reading is not None and reading.idle and reading.reason == cycle.reason:
            return NO_REPORT
        command = None if reading is None else reading.command
        # A stop is no share of anything.
        moving = command is not None and (isinstance(command, PoseCommand) or bool(command.numbers.any()))
    share = round(output.share, 2) if moving and output.status != "STALE" else None  # whole percents: pages get changes
    return {"status": output.status, "joint": output.joint, "reason": output.explain(), "share": share}


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

    def take(self, request: PageRequest, sender: str) -> None:
        """Put a command of the page `sender` into the inbox. Raises InputError for an invalid one."""
        if not (self.open or self.drive):
            raise InputError(
                "no servo takes commands here: start one by `twistarm servo ARM`, by Viewer.commands, "
                "or by the switch Drive in the Jog panel"
            )
        fields, names = request.fields, self.arm.joint_names
        try:
            if request.kind == "jog_joints":
                rates = fields["rates"]
                if len(rates) != len(names):
                    raise InputError(
                        f"rates must be {len(names)} numbers, base to tip: {', '.join(names)}; got {len(rates)}"
                    )
                fields = {"jog": dict(zip(names, rates, strict=True))}
            command = command_of(self.arm, {"stop": True} if request.kind == "stop" else fields)
        except InputError as error:
            self.refuse(sender, str(error))
            raise
        self.inbox.put(sender, command, time.monotonic())
        (self._jogging.discard if request.kind == "stop" else self._jogging.add)(sender)

    def refuse(self, sender: str, reason: str) -> None:
        """Handle an unusable message or the end of a page. If the page jogs, the arm comes to rest."""
        if sender in self._jogging:
            self._jogging.discard(sender)
            self.inbox.refuse(sender, reason, time.monotonic())


class Driver:
    """Runs at most one drive: the loop of `twistarm.control.stream` in a thread, with the pages' commands.

    A drive begins at the shown configuration and leaves the arm where it stops. The program goes first: its servo and
    `Viewer.show` end the drive.
    """

    def __init__(self, stage: Stage, commands: PageCommands, post: Post) -> None:
        self._stage, self._commands, self._post = stage, commands, post
        self._drive: Drive | None = None
        self._closed = False
        self._beginning = threading.Lock()  # no drive begins while the driver is closed

    def switch(self, on: bool) -> None:
        """Begin a drive, or bring the arm to rest and end it, in the server's loop. Repeated calls are harmless.

        Raises InputError while another servo drives, LimitError for a configuration outside the limits.
        """
        drive = self._drive
        if not on or self._closed:
            if drive is not None:
                drive.end()
        elif drive is None:
            self._begin()
        elif drive.dropped:
            raise InputError("the last drive is coming to rest: switch Drive on again in a moment")
        else:
            drive.end_asked = inf

    @property
    def on(self) -> bool:
        """Whether the servo of the pages drives the arm."""
        drive = self._drive
        return drive is not None and not drive.dropped

    def drop(self, reason: str = "") -> None:
        """End the drive and show no more of it, because the program moves the arm. Any thread may call it.

        reason: the message for the pages; "" where a servo of the program takes over.
        """
        if (drive := self._drive) is not None:
            drive.drop(reason)

    def close(self, timeout: float) -> None:
        """Bring the arm to rest and wait until the thread ends. No other drive begins after that."""
        with self._beginning:
            self._closed, drive = True, self._drive
        if drive is not None:
            drive.end()
            drive.thread.join(timeout)

    def _begin(self) -> None:
        stage = self._stage
        if stage.driven or self._commands.open:
            raise InputError(f"a servo of the program drives {stage.arm.name}: end it, then turn on Drive")
        require_all_inside(stage.arm, stage.theta)
        with self._beginning:
            if self._closed:
                return
            stage.begin_drive(defaults_line(stage.arm))
            self._commands.drive = True
            self._drive = Drive(stage, self._commands, self._post, self._end)
            self._drive.thread.start()

    def _end(self, drive: Drive) -> None:
        """Clean up in the loop, after the thread's last message."""
        self._drive = None
        self._commands.drive = False
        self._stage.end_drive(drive.taken_over)
        if drive.problem:
            raise InputError(drive.problem)  # told to the pages


class Drive:
    """One drive, which `thread` runs. At its end the loop calls `ended(drive)`."""

    def __init__(self, stage: Stage, commands: PageCommands, post: Post, ended: Callable[[Drive], None]) -> None:
        self.end_asked = inf  # when somebody asked for its end [s]
        self.dropped = self.taken_over = False
        self.problem = ""
        self.thread = threading.Thread(target=self._run, name="twistarm drive", daemon=True)
        self._arm, self._scene, self._commands, self._post, self._ended = stage.arm, stage.scene, commands, post, ended
        limits = stage.arm.limits
        # Sliders may pass a limit by LIMIT_TOL, which simulated joints refuse.
        self._joints = SimulatedJoints(stage.arm, np.clip(stage.theta, limits.lower, limits.upper))
        self._showing = threading.Lock()  # `drop` waits until a cycle is shown, so none comes after it
        self._sent: tuple[bytes, object] = (b"", None)

    def end(self) -> None:
        """Bring the arm to rest, then end."""
        self.end_asked = min(self.end_asked, time.monotonic())

    def drop(self, reason: str) -> None:
        """End, and show nothing after this returns. The first reason counts."""
        with self._showing:
            if not self.dropped:
                self.dropped, self.taken_over, self.problem = True, not reason, reason
        self.end()

    def read(self, now: float, state: ServoState | None) -> Reading:
        """The command of the pages. None after `end`."""
        if self.end_asked <= now:
            return Reading(None, inf, "Drive was switched off", idle=True)
        return self._commands.inbox.read(now, state)

    def _run(self) -> None:
        try:
            options = StreamOptions(scene=self._scene, settings=self._commands.servo_settings(ServoSettings()))
            report = run(self._arm, self, self._joints, self._joints, options, until=self._done, on_cycle=self._show)
            if report.ending is not Ending.DONE:
                self.problem = f"the drive has ended: {report.reason}"
        except Exception as error:
            self.problem = f"the drive has ended: {words_of(error)}"
        finally:
            self._post("drive", lambda stage: self._ended(self))

    def _done(self) -> bool:
        since = time.monotonic() - self.end_asked
        return since >= 0.0 and (since > STOP_TIMEOUT or not self._joints.theta_dot.any())

    def _show(self, cycle: Cycle) -> None:
        """Show only changes: an arm at rest sends nothing to the pages."""
        theta, words = self._joints.theta, servo_words(cycle)
        new = theta.tobytes(), words
        if new == self._sent:
            return
        self._sent = new
        with self._showing:
            if not self.dropped:
                self._post("show", lambda stage: stage.show(theta))
                self._post("servo", lambda stage: stage.set_servo_status(words))
