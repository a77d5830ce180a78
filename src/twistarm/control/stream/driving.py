"""Cycles on a grid of times until the end or a failure, then the arm at rest."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from math import floor, inf

from ...support.checks import as_flag, require_method
from ...support.errors import InputError, shown
from ...support.interrupts import ended_like_ctrl_c
from .cycles import ROUNDING, C, Cycles, StreamError
from .protocols import LATEST, Clock, MonotonicClock, require_time
from .report import Ending, StreamReport, with_counts


class Metronome:
    """The grid t₀ + k · period [s] with t₀ the first tick. `next` is the next time.

    early: the part of a period by which a tick may be early, for timers with jitter.
    """

    def __init__(self, period: float, early: float = ROUNDING) -> None:
        self.period = period
        self._early = early
        self.next = -inf
        self._origin = -inf
        self._index = 0

    def tick(self, now: float) -> int:
        """The number of periods of this cycle: 1 on time, more after a delay, 0 if early.

        −1 if time ran backwards by a period or more; the grid then restarts.

        Raises InputError for a time that is not finite or at least 1e12 s, and keeps the grid.
        """
        if not abs(require_time(now)) < LATEST:
            raise InputError(f"now must be seconds of a clock, below {LATEST:g}; got {shown(now)}")
        if self._origin == -inf:
            return self._begin(now, 1)
        phase = (now - self._origin) / self.period
        index = floor(phase + self._early)
        periods = index - self._index
        if periods < 0:
            return self._begin(now, -1)
        self._origin = min(self._origin, now - index * self.period)
        self._index = index
        self.next = self._origin + (index + 1) * self.period
        return periods

    def _begin(self, now: float, periods: int) -> int:
        self._origin, self._index, self.next = now, 0, now + self.period
        return periods


def drive(
    cycles: Cycles[C],
    *,
    clock: Clock | None,
    handle_signals: bool,
    on_cycle: Callable[[C], object] | None,
    longest: float = inf,
    until: Callable[[], bool] | None = None,
    before: Callable[[], object] | None = None,
) -> StreamReport:
    """Run cycles until one returns an ending, `longest` [s] pass, `until` returns True, or an interrupt.

    Then bring the arm to rest. `before` runs before each cycle and may raise `StreamError`.
    """
    time = MonotonicClock() if clock is None else require_method(clock, "clock", "sleep_until")
    metronome = Metronome(cycles.period)
    began = time.now()
    handled: AbstractContextManager[list[int]] = (
        ended_like_ctrl_c() if as_flag(handle_signals, "handle_signals") else nullcontext([])
    )
    with handled:
        ending, reason = Ending.INTERRUPTED, ""
        try:
            ending, reason = _drive(cycles, metronome, time, began + longest, until, before, on_cycle)
        except KeyboardInterrupt as interrupted:
            reason = str(interrupted)
        except StreamError as failed:
            ending, reason = failed.ending, failed.reason
        except BaseException as error:
            come_to_rest(cycles, metronome, time)
            _note(error, with_counts(cycles.tally.failures))
            raise
        at_rest = come_to_rest(cycles, metronome, time)
        return cycles.report(ending, reason, time.now() - began, at_rest)


def come_to_rest(cycles: Cycles[C], metronome: Metronome, clock: Clock) -> bool:
    """Brake cycle by cycle, then send zero rates, also when Ctrl-C shortens the braking.

    A clock that jumps ahead does not shorten the braking: the needed cycles run in any case.

    Args:
        cycles: The loop.
        metronome: The cycles' times.
        clock: The clock.

    Returns:
        Whether the arm is at rest.
    """
    require_method(cycles, "cycles", "brake")
    require_method(metronome, "metronome", "tick")
    require_method(clock, "clock", "now")
    try:
        latest, left = clock.now() + cycles.longest_braking, cycles.longest_braking / cycles.period
        while not cycles.at_rest and (left > 0.0 or clock.now() < latest):
            _wait(clock, metronome, inf)
            now = clock.now()
            if not abs(now) < LATEST:  # a broken clock
                break
            metronome.tick(now)
            cycles.brake(now)
            left -= 1.0
    except KeyboardInterrupt:
        pass
    finally:
        at_rest = cycles.at_rest
        cycles.halt(clock.now())
    return at_rest


def _drive(
    cycles: Cycles[C],
    metronome: Metronome,
    clock: Clock,
    end: float,
    until: Callable[[], bool] | None,
    before: Callable[[], object] | None,
    on_cycle: Callable[[C], object] | None,
) -> tuple[Ending, str]:
    """Cycles until one of the reasons to end, and which it was."""
    while True:
        now, due = clock.now(), metronome.next
        if now >= end:
            return Ending.DURATION, ""
        if until is not None and until():
            return Ending.DONE, ""
        periods = metronome.tick(now)
        if periods != 0:  # else the clock woke us a little early
            if due > -inf:
                cycles.tally.begin(now - due)
            if before is not None:
                before()
            cycle = cycles.cycle(now, periods)
            if on_cycle is not None:
                on_cycle(cycle)
            if cycle.ending is not None:
                return cycle.ending, cycle.reason
        _wait(clock, metronome, end)


def _wait(clock: Clock, metronome: Metronome, end: float) -> None:
    """Sleep until the next cycle or the end, at most a period. A clock may run backwards."""
    clock.sleep_until(min(metronome.next, end, clock.now() + metronome.period))


def _note(error: BaseException, failures: list[str]) -> None:
    """Say at the exception on its way what else went wrong, where Python (3.11 on) can."""
    if sys.version_info >= (3, 11):
        for failure in failures:
            error.add_note(f"while the arm came to rest, {failure}")
