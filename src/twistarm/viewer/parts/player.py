"""The trajectory on show: its clock and player, and plots of every joint with the limits."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...arm.usual_limits import with_defaults
from ...limits.joint_limits import JointLimits, usual_range
from ...planning.trajectory import Trajectory
from ...support.checks import Array
from ...support.errors import InputError
from ..jobs import Memo
from ..messages import Message
from .arm_data import checked_theta
from .show import Part, Playback, Route, Show

# Slowest and fastest speed from a page. Python may set a speed beyond them, which a page then keeps.
SPEEDS = (0.05, 20.0)
RATES = ("position", "velocity", "acceleration")  # Names of the derivatives by order.
MOST_POINTS = 300  # Most points of a line: about a plot's width in pixels.
BEFORE = 1e-9  # Share of the duration before a breakpoint, so that a jump is drawn as one.
DECIMALS = 6  # Decimals of values [rad, m, and per s and s²]; finer than any plot.

NO_PLOTS: Message = {"type": "plots", "times": [], "joints": [], **{rate: [] for rate in RATES}, "tool": {}}


class Player(Part):
    """Plays the loaded trajectory as the pages ask, and plots it."""

    def __init__(self) -> None:
        self._plots = Memo(plots)
        self.routes = {
            "play": Route(self._play, moves=True),
            "pause": Route(self._pause),
            "seek": Route(self._seek, moves=True),
            "pace": Route(self._pace),
        }

    def _play(self, show: Show, now: float) -> None:
        at = _loaded(show, "play")
        show.stop()
        at.play(now)

    def _pause(self, show: Show, now: float) -> None:
        _loaded(show, "pause").running = False

    def _seek(self, show: Show, now: float, time: float) -> None:
        at = _loaded(show, "seek")
        show.stop()
        at.seek(time)
        show.theta = checked_theta(show.arm, at.theta())

    def _pace(self, show: Show, now: float, speed: float, loop: bool) -> None:
        at, (slowest, fastest) = _loaded(show, "pace"), SPEEDS
        if speed != at.speed and not slowest <= speed <= fastest:
            raise InputError(f"speed must be {slowest:g} … {fastest:g} times the trajectory's own; got {speed:g}")
        at.speed, at.loop = speed, loop

    def messages(self, show: Show) -> Iterator[Message]:
        """The trajectory that is loaded, and its plots; duration null where none is."""
        at = show.playback
        yield {
            "type": "player",
            "duration": None if at is None else at.duration,
            "speed": 1.0 if at is None else at.speed,
            "loop": at is not None and at.loop,
        }
        yield self._plots(show.arm, None if at is None else at.trajectory)


def _loaded(show: Show, doing: str) -> Playback:
    if show.playback is None:
        raise InputError(f"there is no motion to {doing}: plan one in the Poses panel")
    return show.playback


def plots(arm: Arm, trajectory: Trajectory | None) -> Message:
    """Times [s], the plotted joints, and the values of each for each derivative [rad, m, per s, s²].

    The limits are those of the motion, or the arm's. Infinite or missing values give no plot.
    """
    if trajectory is None:
        return NO_PLOTS
    limits = trajectory.limits or arm.limits
    times = _times(trajectory)
    values = [np.round(trajectory(times, order), DECIMALS).T for order in range(len(RATES))]
    peaks = [trajectory.peak(order) for order in range(len(RATES))]
    if not np.isfinite([*values]).all() or not np.isfinite(peaks).all():
        return NO_PLOTS
    # Speeds of the tool's origin [m/s] and rotation [rad/s]: the norms of the halves of J^b θ̇.
    twists = (arm.body_jacobian(trajectory(times)) @ trajectory(times, 1)[..., None])[..., 0]
    linear, angular = (np.round(np.linalg.norm(half, axis=-1), DECIMALS) for half in (twists[:, :3], twists[:, 3:]))
    return {
        "type": "plots",
        "times": times.tolist(),
        "joints": _joints(arm, limits, peaks),
        **{rate: rows.tolist() for rate, rows in zip(RATES, values, strict=True)},
        "tool": {"linear": linear.tolist(), "angular": angular.tolist()},
    }


def _times(trajectory: Trajectory) -> Array:
    """Even times from start to end, with both sides of each breakpoint if these are few."""
    inner = trajectory.breakpoints[1:-1]
    jumps = inner if 4 * len(inner) <= MOST_POINTS else inner[:0]
    even = np.linspace(0.0, trajectory.duration, MOST_POINTS - 2 * len(jumps) if trajectory.duration > 0 else 1)
    times: Array = np.unique(np.concatenate([even, jumps - BEFORE * trajectory.duration, jumps]))
    return times


def _joints(arm: Arm, limits: JointLimits, peaks: list[Array]) -> list[dict[str, Any]]:
    """Name and unit. `range`: the range of positions; `usual`: assumed limits; `peak`: largest values."""
    rates = ((rate, [getattr(of, rate) for of in (arm.limits, limits, with_defaults(arm))]) for rate in RATES[1:])
    usual = {rate: np.isinf(own) & (ours == assumed) for rate, (own, ours, assumed) in rates}
    lower, upper = usual_range(limits.lower, limits.upper, arm.usual_half)
    return [
        {
            "name": name,
            "unit": unit,
            "range": [float(lower[i]), float(upper[i])],
            "limits": {
                "position": [_or_null(limits.lower[i]), _or_null(limits.upper[i])],
                **{rate: _or_null(getattr(limits, rate)[i]) for rate in RATES[1:]},
            },
            "usual": [rate for rate, flags in usual.items() if flags[i]],
            "peak": {rate: float(peak[i]) for rate, peak in zip(RATES, peaks, strict=True)},
        }
        for i, (name, unit) in enumerate(zip(arm.joint_names, arm.units, strict=True))
    ]


def _or_null(limit: float) -> float | None:
    return float(limit) if np.isfinite(limit) else None
