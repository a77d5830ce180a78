"""Joint states from threads, sockets and topics, merged by name. A sender may know only some joints."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from itertools import islice
from math import inf

from numpy.typing import ArrayLike

from ....arm.arm import Arm, require_arm
from ....support.checks import as_theta, frozen, require_mapping
from ....support.errors import InputError, closest, listed
from ..motors import motor_side
from ..protocols import Measured
from .inbox import FEEDBACK_TIMEOUT, Latest, Look, moment

MAX_OTHER_SENDERS = 20
"""Most unknown names to keep for messages."""


class StateInbox:
    """A feedback that stores joint states from `put(sender, state)`, whole or in parts, from any thread.

    A joint's value is valid for `timeout` [s]. theta needs a value for every joint and is as old as the oldest. Each
    joint follows the rules of `Latest`: one sender, increasing numbers, a reset by a backward clock. Other names are
    ignored, and named if theta is unknown. A refused message counts against all joints of its sender, or without one
    against every joint.

    units: "joint", or "motor" or "counts" for motors (`MotorSide`). They merge before theta is computed. So each motor
    of a differential may have its message.

    Raises InputError for a timeout that is not positive, and for units unknown to the arm.
    """

    def __init__(self, arm: Arm, timeout: float = FEEDBACK_TIMEOUT, *, units: str = "joint") -> None:
        self.motors = motor_side(require_arm(arm), units)
        self.names = arm.joint_names if self.motors is None else self.motors.names
        what = "joint state" if self.motors is None else "motors' state"
        self._parts: dict[str, Latest[float]] = {name: Latest(timeout, what) for name in self.names}
        self.timeout = timeout
        self._lock = threading.Lock()
        self._strangers = 0
        self._others: tuple[str, ...] = ()

    def put(
        self, sender: str, state: Mapping[str, float] | ArrayLike, now: float | None = None, number: int | None = None
    ) -> None:
        """Put in a message with the state of some joints or of all.

        A state that is not finite, or has another shape, is refused.

        Args:
            sender: The sender's name.
            state: {joint: value}, or values (n,), base to tip [rad, m].
            now: The time of arrival [s]; by default that of `MonotonicClock`, the loop's own.
            number: The sender's own counter, where it counts.
        """
        now = moment(now)
        try:
            part = self._part(state)
        except InputError as error:
            self.refuse(sender, str(error), now)
            return
        with self._lock:
            for name, value in part.items():
                self._parts[name].put(sender, value, now, number)

    def refuse(self, sender: str, reason: str, now: float | None = None) -> None:
        """Note that an unusable message has arrived.

        Args:
            sender: The sender's name.
            reason: The reason, in words.
            now: The time of arrival [s]; by default that of `MonotonicClock`.
        """
        with self._lock:
            told = [part for part in self._parts.values() if part.heard(sender)]
            for part in told or self._parts.values():
                part.refuse(sender, reason, now)

    def read(self, now: float) -> Measured:
        """The joint state at `now` [s], or None and which joint it lacks, and why."""
        now = moment(now)
        with self._lock:
            looks = {name: part.look(now) for name, part in self._parts.items()}
            heard = now - max(look.age for look in looks.values())
            values = [look.value for look in looks.values() if look.value is not None]
            if len(values) < len(looks):
                return Measured(None, heard, self._why_not(looks, now))
        return Measured(frozen(values) if self.motors is None else self.motors.theta(values), heard)

    def _part(self, state: Mapping[str, float] | ArrayLike) -> dict[str, float]:
        """The values that count, by name; InputError for what is not finite."""
        if not isinstance(state, Mapping):
            whole = as_theta(state, len(self.names), "the joint state", self.names)
            if whole.ndim != 1:
                raise InputError(f"the joint state is one configuration ({len(self.names)},); got {whole.shape}")
            return dict(zip(self.names, whole.tolist(), strict=True))
        require_mapping(state, "the joint state", "{joint: value}")
        ours = tuple(name for name in self.names if name in state)
        if len(ours) < len(state):
            self._others = tuple(islice((name for name in state if name not in self._parts), MAX_OTHER_SENDERS))
        if not ours:
            self._strangers += 1
            return {}
        values = as_theta([state[name] for name in ours], len(ours), f"the joint state of {', '.join(ours)}", ours)
        return dict(zip(ours, values.tolist(), strict=True))

    def _why_not(self, looks: Mapping[str, Look[float]], now: float) -> str:
        """The reasons, each with its joints unless it concerns all."""
        groups: dict[str, list[str]] = {}
        for name, look in looks.items():
            if look.value is None:
                stale = self.timeout < look.age < inf
                groups.setdefault("stale" if stale else look.reason, []).append(name)
        said = []
        for names in groups.values():
            oldest = max(names, key=lambda name: looks[name].age)
            of = "" if len(names) == len(looks) else f" of {', '.join(names)}"
            said.append(self._parts[oldest].look(now, of).reason)
        never_heard = [name for name, look in looks.items() if look.age == inf]
        if self._strangers and never_heard:
            said.append(f"{self._strangers} messages told of others alone, the last of {listed(self._others, 5)}")
        # What was told of instead may be their names with a slip.
        return "; ".join(said) + (closest(never_heard[0], self._others) if never_heard else "")
