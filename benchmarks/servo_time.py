"""One step of the servo from Python beside forward kinematics of the same arm, and the memory of a million steps.

Each arm swings about its ready configuration under each kind of command. Each round steps every arm as often as it
calls `arm.fk`, in turn, so that the noise of the machine affects all alike.
"""

from __future__ import annotations

import gc
import resource
import sys
import time
import tracemalloc
from collections.abc import Callable

import numpy as np

from twistarm import Arm, load_arm
from twistarm.control.servo import AnyCommand, JogCommand, PoseCommand, ServoState, TwistCommand, servo_step
from twistarm.support.errors import TwistarmError

ARMS = ("rover_arm", "rover_arm_6dof", "ur5", "panda", "so101")
DT, SWING, CALLS = 0.01, 50, 200
"""The step [s], steps before a swing turns back, and calls of one arm and command in a round."""


def commands(arm: Arm) -> dict[str, tuple[AnyCommand, AnyCommand]]:
    """There and back, of every kind."""
    straight, both = np.array([0.1, 0, 0, 0, 0, 0]), np.array([0.1, 0, 0, 0, 0.2, 0])  # m/s, rad/s
    rates = np.full(arm.n, 0.1)
    return {
        "twist": (TwistCommand(both), TwistCommand(-both)),
        "twist, held": (TwistCommand(straight, hold="orientation"), TwistCommand(-straight, hold="orientation")),
        "pose": (PoseCommand(arm.fk(arm.ready + 0.05)), PoseCommand(arm.fk(arm.ready))),
        "jog": (JogCommand(rates), JogCommand(-rates)),
    }


class Swing:
    """An arm under one kind of command, and the ns of its calls."""

    def __init__(self, arm: Arm, kind: str) -> None:
        self.arm, self.kind, self.there_and_back = arm, kind, commands(arm)[kind]
        self.state, self.steps = ServoState.at(arm, arm.ready), 0
        self.servo: list[int] = []
        self.fk: list[int] = []

    def step(self) -> None:
        command = self.there_and_back[self.steps // SWING % 2]
        self.state, _ = servo_step(self.arm, self.state, command, DT)
        self.steps += 1

    def round(self) -> None:
        self.fk += timed(lambda: self.arm.fk(self.state.theta))
        self.servo += timed(self.step)

    def figures(self) -> dict[str, str | float]:
        """Times in µs. first: the first call of each round, when the caches hold the work of others."""
        median, p99 = np.percentile(self.servo, [50, 99]) / 1e3
        first, fk = np.median(self.servo[::CALLS]) / 1e3, np.median(self.fk) / 1e3
        times = {"median": median, "p99": p99, "first": first, "fk": fk, "ratio": median / fk}
        about: dict[str, str | float] = {"arm": self.arm.name, "joints": self.arm.n, "command": self.kind}
        return about | {name: float(value) for name, value in times.items()}


def timed(call: Callable[[], object]) -> list[int]:
    ns = []
    for _ in range(CALLS):
        begin = time.perf_counter_ns()
        call()
        ns.append(time.perf_counter_ns() - begin)
    return ns


def loaded() -> tuple[list[Arm], dict[str, str]]:
    """The arms that can be loaded here, and why the others cannot."""
    arms, absent = [], {}
    for name in ARMS:
        try:
            arms.append(load_arm(name))
        except TwistarmError as error:  # noqa: PERF203
            absent[name] = str(error)
    return arms, absent


def growth(swings: list[Swing], steps: int) -> dict[str, int]:
    """Bytes left by the steps, shared among the swings: of Python's allocator, and of the process's peak.

    The second one also sees what the core would allocate.
    """
    tracemalloc.start()
    run(swings, steps // 10)
    before, most = traced(), most_bytes()
    run(swings, steps)
    result = {"steps": steps, "python": traced() - before, "process": most_bytes() - most}
    tracemalloc.stop()
    return result


def run(swings: list[Swing], steps: int) -> None:
    for swing in swings:
        for _ in range(steps // len(swings)):
            swing.step()


def traced() -> int:
    gc.collect()
    return tracemalloc.get_traced_memory()[0]


def most_bytes() -> int:
    kilo = 1 if sys.platform == "darwin" else 1024  # what ru_maxrss counts in
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * kilo


def measured(rounds: int, steps: int) -> dict[str, object]:
    """The figures of every arm and command, why arms are absent, and what so many steps leave."""
    arms, absent = loaded()
    swings = [Swing(arm, kind) for arm in arms for kind in commands(arm)]
    for number in range(rounds + 1):
        for swing in swings:
            if number == 1:  # the first round warmed up
                swing.servo.clear()
                swing.fk.clear()
            swing.round()
    figures = [swing.figures() for swing in swings]
    return {"steps": figures, "absent": absent, "growth": growth(swings, steps)}
