"""a servo on simulated joints inside the view, switched by a page."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from math import inf

import numpy as np

from ...arm.usual_limits import defaults_line
from ...control.servo import ServoSettings, ServoState
from ...control.stream import Cycle, Ending, Reading, SimulatedJoints, run
from ...support.errors import InputError
from ..parts.commands import PageCommands
from ..parts.limit_checks import require_all_inside
from ..parts.servo_words import servo_words
from ..stage import Stage

LONGEST_REST = 3.0
"""Seconds after which the end comes though the simulated joints still move: with very low accelerations."""

Post = Callable[[str, Callable[[Stage], None]], None]
"""Has a change of the stage applied in the loop."""


class Driver:
    """At most one drive: the loop of `twistarm.control.stream` in a thread, commanded by the pages.

    It begins at the present configuration and leaves the arm where it stops. A servo of the program or `Viewer.show`
    ends it.
    """

    def __init__(self, stage: Stage, commands: PageCommands, post: Post) -> None:
        self._stage, self._commands, self._post = stage, commands, post
        self._drive: Drive | None = None
        self._thread: threading.Thread | None = None
        self._closed = False
        self._beginning = threading.Lock()  # no drive begins while the driver is closed

    def switch(self, on: bool) -> None:
        """Begin, or come to rest and end; in the server's loop. Harmless when repeated.

        Raises InputError where another servo drives, LimitError for a configuration outside the limits.
        """
        drive = self._drive
        if not on or self._closed:
            self.stop()
        elif drive is None:
            self._begin()
        elif drive.dropped:
            raise InputError("the last drive is coming to rest: switch Drive on again in a moment")
        else:
            drive.asked_at = inf

    @property
    def on(self) -> bool:
        """Whether the pages' own servo has the arm."""
        drive = self._drive
        return drive is not None and not drive.dropped

    def stop(self) -> None:
        """Bring the arm to rest, then end; returns at once. From any thread."""
        drive = self._drive
        if drive is not None:
            drive.end()

    def drop(self, reason: str = "") -> None:
        """End the drive and show nothing more, because the program moves the arm.

        Callable from any thread.

        reason: the text for the pages; "" if a servo of the program takes over.
        """
        drive = self._drive
        if drive is not None:
            drive.drop(reason)

    def close(self, timeout: float) -> None:
        """Bring the arm to rest and return after the thread has ended. No other drive begins."""
        with self._beginning:
            self._closed = True
            thread = self._thread
        self.stop()
        if thread is not None:
            thread.join(timeout)

    def _begin(self) -> None:
        stage = self._stage
        if stage.driven or self._commands.open:
            raise InputError(f"a servo of the program drives {stage.arm.name}: Drive is free once it has ended")
        require_all_inside(stage.arm, stage.theta)
        with self._beginning:
            if self._closed:
                return
            stage.begin_drive(defaults_line(stage.arm))
            self._commands.drive = True
            self._drive = Drive(stage, self._commands, self._post, self._end)
            self._thread = threading.Thread(target=self._drive.run, name="twistarm drive", daemon=True)
            self._thread.start()

    def _end(self, drive: Drive) -> None:
        """In the loop, after the thread's last word."""
        self._drive = None
        self._commands.drive = False
        self._stage.end_drive(drive.taken_over)
        if drive.problem:
            raise InputError(drive.problem)  # told to the pages


class Drive:
    """One drive. The loop calls `ended(drive)` at its end."""

    def __init__(self, stage: Stage, commands: PageCommands, post: Post, ended: Callable[[Drive], None]) -> None:
        self.arm = stage.arm
        self.asked_at = inf
        self.dropped = self.taken_over = False
        self.problem = ""
        self._joints = SimulatedJoints(self.arm, np.clip(stage.theta, self.arm.limits.lower, self.arm.limits.upper))
        self._commands, self._post, self._ended = commands, post, ended
        self._showing = threading.Lock()
        self._shown: tuple[bytes, object] = (b"", None)

    def end(self) -> None:
        """Come to rest, then end."""
        self.asked_at = min(self.asked_at, time.monotonic())

    def drop(self, reason: str) -> None:
        """End, and show nothing more once this returns; the first reason counts."""
        with self._showing:
            if not self.dropped:
                self.dropped, self.taken_over, self.problem = True, not reason, reason
        self.end()

    def read(self, now: float, state: ServoState | None) -> Reading:
        """The pages' command; none once the end was asked for."""
        if self.asked_at <= now:
            return Reading(None, inf, "Drive was switched off", idle=True)
        return self._commands.inbox.read(now, state)

    def run(self) -> None:
        """The thread."""
        try:
            settings = self._commands.servo_settings(ServoSettings())
            report = run(
                self.arm, self, self._joints, self._joints, settings=settings, until=self._done, on_cycle=self._show
            )
            if report.ending is not Ending.DONE:
                self.problem = f"the drive has ended: {report.reason}"
        except Exception as error:
            self.problem = f"the drive has ended: {error}"
        finally:
            self._post("drive", lambda stage: self._ended(self))

    def _done(self) -> bool:
        since = time.monotonic() - self.asked_at
        return since >= 0.0 and (since > LONGEST_REST or not self._joints.theta_dot.any())

    def _show(self, cycle: Cycle) -> None:
        """Only what is new: an arm that stands costs the pages nothing."""
        theta, words = self._joints.theta, servo_words(cycle)
        new = theta.tobytes(), words
        if new == self._shown:
            return
        self._shown = new
        with self._showing:
            if not self.dropped:
                self._post("show", lambda stage: stage.show(theta))
                self._post("servo", lambda stage: stage.set_servo_status(words))
