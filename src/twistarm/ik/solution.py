"""The answer of inverse kinematics: a configuration, its distance from the target, and the reason in words."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arm.abilities import abilities_of, cannot_move, cannot_turn, position_limit
from ..arm.arm import Arm
from ..support.checks import Array
from ..support.directions import length_in_words, metres, numbers, value_in_words
from ..support.display import short_repr
from ..support.errors import NotConvergedError, printable
from ..support.messages import Argument, Quantity, Text, joined, plural
from ..support.units import length_hint, theta_hint
from .answer import CLOSED_FORM, CONVERGED, DAMPED, NEAREST, STOPS, Record, StopReason, record_type
from .ranges import joint_ranges
from .targets import AnyTarget, Approach, Position, target_of
from .task_space import Tolerances

if TYPE_CHECKING:
    from ..collision import Contact

AT_BOUND = 1e-6  # How near [rad, m] to its bound a joint stands at it.
NEGLIGIBLE = math.radians(0.005)  # Angles [rad] that would be printed as 0.00°.
NARROW_MISS = 10.0  # A target that is missed by fewer tolerances may have been asked for too exactly.
# How many times as wide a position tolerance is tried where the rotation is missed.
WIDER = (2.0, 4.0, NARROW_MISS)
WIDER_SEARCHES = 100  # The most searches for each of them. `explain` takes their time too.

SQUARE = 1e-3  # The cosine of an angle that counts as right.
MANY_JOINTS = 16  # On arms with more joints, the nearest-configuration search finds one of very many minima.


# `frozen` would cost a tenth of a short search. Public attributes have no setters, and only caches change.
@dataclass(eq=False, repr=False, slots=True)
class IKResult:
    """The answer to one target, which cannot be changed. It computes what costs time only when you ask for it."""

    _arm: Arm
    _memory: bytearray | Record
    """What holds the record."""
    _target: AnyTarget | None = None
    _contacts: tuple[Contact, ...] = ()
    _avoided: str = ""
    _record: Record | None = None

    @property
    def record(self) -> Record:
        """The answer as a NumPy record (), read-only: theta, errors, stop, what was asked, ... (ik/answer.py)."""
        if self._record is None:
            self._record = np.ndarray((), record_type(self._arm.n), self._memory)
            self._record.flags.writeable = False
        return self._record

    @property
    def arm(self) -> Arm:
        """The arm that was solved for."""
        return self._arm

    @property
    def target(self) -> AnyTarget:
        """The target that was solved for."""
        if self._target is None:
            self._target = target_of(int(self.record["kind"]), self.record["numbers"])
        return self._target

    @property
    def tolerances(self) -> Tolerances:
        """The tolerances of the call."""
        return Tolerances(float(self.record["position_tol"]), float(self.record["orientation_tol"]))

    @property
    def theta(self) -> Array:
        """(n,) [rad, m], read-only: an answer if `converged`, else the nearest configuration.

        The nearest has the least position error inside the limits. The least rotation error with that position comes
        second. For TIMED_OUT and EXHAUSTED it is the best so far.
        """
        return self.record["theta"]

    @property
    def unlimited(self) -> Array | None:
        """(n,) where limits block: an answer without them, or what comes nearest, the position first. Else None."""
        return self.record["unlimited"] if self.record["has_unlimited"] else None

    @property
    def position_error(self) -> float:
        """[m], from forward kinematics at theta, in what the target constrains."""
        return float(self.record["position_error"])

    @property
    def orientation_error(self) -> float:
        """[rad], from forward kinematics at theta, in what the target constrains."""
        return float(self.record["orientation_error"])

    @property
    def within_limits(self) -> bool:
        """Whether theta is inside the arm's limits."""
        return bool(self._arm.limits.contains(self.theta))

    @property
    def iterations(self) -> int:
        """Steps of the search that found theta; of all searches where none did."""
        return int(self.record["iterations"])

    @property
    def restarts(self) -> int:
        """Number of searches, the one from theta0 included."""
        return int(self.record["restarts"])

    @property
    def method(self) -> str:
        """The method that found theta: a damped search, the nearest-configuration search, or the closed form."""
        if self.record["by_closed_form"]:
            return CLOSED_FORM
        return NEAREST if self.record["nearest"] else DAMPED

    @property
    def certain(self) -> bool:
        """Whether the closed form proves that nothing inside the limits reaches the target exactly."""
        return bool(self.record["certain"])

    @property
    def stop(self) -> StopReason:
        """Why the solver stopped."""
        return StopReason.IN_COLLISION if self._contacts else STOPS[self.record["stop"].item()]

    @property
    def converged(self) -> bool:
        """Whether theta reaches the target to the tolerances, and is free of collisions with the scene."""
        return self.record["stop"].item() == CONVERGED and not self._contacts

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """The pairs that collide at theta, if the call had a scene."""
        return self._contacts

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the answer: joints of theta0 brought inside, another branch, no core."""
        notes = self._moved_starts() if self.record["start_moved"] else []
        if self.record["other_branch"]:
            notes.append(self._other_branch())
        if self._avoided:
            notes.append(self._avoided)
        if self.record["nearest"] and not self.converged and self._arm.n > MANY_JOINTS:
            notes.append("an arm of so many joints may come nearer: try another rng or theta0")
        if not self.converged and self._arm.compiled is None:
            need = "the nearest one, and the reason, need the compiled core"
            notes.append(f"this is the best configuration found: {need}, and `twistarm info` says why it is missing")
        return tuple(notes)

    def explain(self) -> str:
        """The target, what was reached and why not more, line by line. Computed when called."""
        lines = [f"target of {self.arm.name}: {self.target.describe()}"]
        lines.append(Text("reached: {errors}", errors=errors_in_words(self)))
        if not self.converged:
            lines += why_not(self)
        steps, starts = plural(self.iterations, "iteration"), plural(self.restarts, "start")
        lines.append(f"found by {self.method}: {steps} from {starts}")
        lines += [Text("note: {note}", note=note) for note in self.notes]
        return joined("\n", map(printable, lines))

    def require(self) -> Array:
        """theta (n,). Raises NotConvergedError, which carries this solution, where the target is not reached."""
        if self.converged:
            return self.theta
        raise NotConvergedError(joined("; ", [_missed(self), _reason(self), "solution.explain() says more"]), self)

    @property
    def _start(self) -> Array:
        """theta0 inside the limits, where the search began."""
        return joint_ranges(self._arm).inside(self.record["theta0"])

    def _moved_starts(self) -> list[str]:
        arm, given = self._arm, self.record["theta0"]
        hint = theta_hint(given, arm.units, arm.limits.lower, arm.limits.upper)
        notes: list[str] = [Text("theta0: {hint}", hint=hint)] if hint else []
        for name, was, now, unit in zip(arm.joint_names, given, self._start, arm.units, strict=True):
            if was != now:
                moved = f"{name} {value_in_words(was, unit)} was brought inside, to {value_in_words(now, unit)}"
                notes.append(f"theta0 lay outside the limits: {moved}")
        return notes

    def _other_branch(self) -> str:
        moved = np.abs(self.theta - self._start)
        i = int(np.argmax(moved))
        why = "the nearest configuration is not near theta0, where the arm stays farther from the target"
        if self.converged:
            why = "the target is near the pose of theta0, but the answer is not near theta0"
        moves = f"{self._arm.joint_names[i]} moves by {value_in_words(moved[i], self._arm.units[i])}"
        return f"another branch: {why}; {moves}"

    def __reduce__(self) -> tuple[Any, ...]:
        return IKResult, (self._arm, self._memory, self._target, self._contacts, self._avoided)

    def __repr__(self) -> str:
        off = {"position_error": self.position_error, "orientation_error": self.orientation_error}
        return short_repr("IKResult", {"stop": self.stop, "theta": self.theta, **off, "method": self.method})


def why_not(solution: IKResult) -> list[str]:
    """The reason why the target is not reached, line by line."""
    reason, details = _why(solution)
    return [f"reason: {reason}", *(f"  {line}" for line in details)]


def in_one_line(solution: IKResult) -> str:
    """What was asked, how far off the answer is, the reason and its details."""
    reason, details = _why(solution)
    return joined("; ", [_missed(solution), *map(printable, [reason, *details])])


def _reason(solution: IKResult) -> str:
    """The reason, which names what is out of reach."""
    if solution.stop is not StopReason.OUT_OF_REACH:
        return solution.stop.value
    missed = solution.position_error > solution.tolerances.position
    return f"the {'position' if missed else 'orientation'} is {solution.stop.value}{'' if missed else ' there'}"


def _missed(solution: IKResult) -> str:
    if solution.stop is StopReason.IN_COLLISION:
        return f"{solution.arm.name} collides at {solution.target.describe()}"
    what = "{arm} does not reach {target}: {errors}"
    return Text(what, arm=solution.arm.name, target=solution.target.describe(), errors=errors_in_words(solution))


def errors_in_words(solution: IKResult) -> str:
    """The two errors in words."""
    if math.isinf(solution.position_error):
        return "nothing yet"
    target, parts = solution.target, list[str]()
    if len(target._position_tolerance):
        error, tolerance = solution.position_error, solution.tolerances.position
        hint = length_hint(target.position_error(np.eye(4)), solution.arm.reach)
        hint = f" ({hint}: lengths are in metres)" if hint else ""
        wider = _wider(error, tolerance, "position_tol", "m")
        off = Text("position {far} off{wider}{hint}", far=length_in_words(error), wider=wider, hint=hint)
        parts.append(off if error > tolerance else "position reached")
    if len(target._rotation_tolerance):
        error, tolerance = solution.orientation_error, solution.tolerances.orientation
        wider = _wider(error, tolerance, "orientation_tol", "rad") or _wider_position_tolerance(solution)
        off = Text("orientation {angle} off, {by}{wider}", angle=_degrees(error), by=target._off_by, wider=wider)
        parts.append(off if error > tolerance else "orientation reached")
    return joined(", ", parts)


def _wider(error: float, tolerance: float, argument: str, unit: str) -> str:
    """The tolerance and the argument that widens it, for an error of few tolerances."""
    if error >= NARROW_MISS * tolerance:
        return ""
    what = " (the tolerance is {tolerance}; {argument} widens it)"
    return Text(what, tolerance=Quantity(tolerance, unit), argument=Argument(argument, None))


def _wider_position_tolerance(solution: IKResult) -> str:
    """The wider position tolerance with which the arm reaches the rotation."""
    chain, target, tolerances = solution.arm.compiled, solution.target, solution.tolerances
    if chain is None or solution.position_error > tolerances.position or not len(target._position_tolerance):
        return ""
    for times in WIDER:
        wide = times * tolerances.position
        how = wide, tolerances.orientation, WIDER_SEARCHES, 0, None, None
        found = chain.solve(target.kind, target.numbers, solution.theta, *how)
        if found is not None and found[0] == CONVERGED:
            return Text(" (reached with {wide})", wide=Argument("position_tol", Quantity(wide, "m", 3)))
    return ""


def _why(solution: IKResult) -> tuple[str, list[str]]:
    """The reason, and the lines that explain it."""
    stop, reason = solution.stop, _reason(solution)
    if math.isinf(solution.position_error):
        return reason, ["it was not finished in time, and theta is its start; give a longer max_time"]
    if stop is StopReason.TIMED_OUT:
        return reason, ["this is the best so far; give a longer max_time, or a theta0 nearer to the answer"]
    if stop is StopReason.IN_COLLISION:
        other = "position" if isinstance(solution.target, Position) else "position or orientation"
        remedy = f"ask for another {other}, move the obstacle, or give a smaller margin"
        return reason, [*map(str, solution.contacts[:3]), remedy]
    if stop is StopReason.EXHAUSTED:
        nearest = solution.method == NEAREST
        what = "the search for the nearest did not converge" if nearest else "no search reached the target"
        return reason, [f"{what}; try more restarts, another rng or another theta0"]
    bounds = _at_bounds(solution)
    if stop is StopReason.BLOCKED_BY_LIMITS:
        details = _blocked(solution)
    elif solution.position_error > solution.tolerances.position:
        details = _out_of_reach(solution)
    else:
        turn, prevented = _impossible(solution, solution.theta), split_rotation(solution, solution.theta)[1]
        by = "limits or the reach" if bounds else "the reach"
        details = [f"{_degrees(prevented)} of the rotation are prevented by {by}"] if prevented > NEGLIGIBLE else []
        if turn and stop is StopReason.IMPOSSIBLE_DIRECTION:
            reason = turn[0]
        else:
            details = [*details, *turn] or [f"{_degrees(solution.orientation_error)} of the rotation are missing"]
    if bounds:
        details.append(f"at {', '.join(bounds)}")
    if stop is StopReason.IMPOSSIBLE_DIRECTION:
        details.append(_remedy(solution))
    if solution.certain:
        details.append("the arm's closed form has no answer inside the limits: that is certain")
    return reason, details


def _remedy(solution: IKResult) -> str:
    """What to ask for where no joint makes the missing turn."""
    if not isinstance(solution.target, Approach):
        return "ask for the position alone, or with the direction of the tool"
    nearest = solution.arm.fk(solution.theta)[:3, :3] @ solution.target.axis
    # At right angles every direction that the tool can have is as near as this one.
    which = "the nearest" if solution.target.direction @ nearest > SQUARE else "for example"
    return f"ask for the position alone, or for the direction {numbers(nearest)}, {which}"


def _at_bounds(solution: IKResult) -> list[str]:
    """The joints at a bound, in words."""
    arm, words = solution.arm, []
    bounds = arm.limits.lower, arm.limits.upper, joint_ranges(arm).turns
    for name, unit, x, lower, upper, turns in zip(arm.joint_names, arm.units, solution.theta, *bounds, strict=True):
        at_lower, at_upper = abs(x - lower) <= AT_BOUND, abs(x - upper) <= AT_BOUND
        if not turns and (at_lower or at_upper):
            side = "only" if at_lower and at_upper else "lower" if at_lower else "upper"
            words.append(f"{position_limit(side, name)} ({value_in_words(x, unit)})")
    return words


def _blocked(solution: IKResult) -> list[str]:
    """The joint values outside the limits, and the error that remains without limits."""
    arm, theta, turns = solution.arm, solution.unlimited, joint_ranges(solution.arm).turns
    if theta is None:
        return []
    needs = []
    for i, name in enumerate(arm.joint_names):
        inside = np.clip(theta[i], arm.limits.lower[i], arm.limits.upper[i])
        if theta[i] != inside and not turns[i]:
            side = "lower" if theta[i] < inside else "upper"
            value, bound = (value_in_words(x, arm.units[i]) for x in (theta[i], inside))
            needs.append(f"{name} {value} ({side} bound {bound})")
    where = f"for one with {', '.join(needs)}" if needs else "a hair beyond them"
    rotation = solution.target.orientation_error(arm.fk(theta))
    if rotation <= solution.tolerances.orientation:
        return [f"without limits it could be reached, {where}"]
    if solution.position_error > solution.tolerances.position:
        return [f"without limits its position could be reached, {where}", *_impossible(solution, theta)]
    return [
        f"{_degrees(solution.orientation_error - rotation)} of the rotation are prevented by limits",
        f"without limits it could be reached to within {_degrees(rotation)}, {where}",
        *_impossible(solution, theta),
    ]


def _out_of_reach(solution: IKResult) -> list[str]:
    """The position that is out of reach, and the rotation beyond all joints there."""
    arm, g = solution.arm, solution.arm.fk(solution.theta)
    place = f", at {metres(np.round(g[:3, 3], 3))}" if len(solution.target._position_tolerance) == 3 else ""
    far = length_in_words(solution.position_error)
    lines = [f"the nearest position the arm reaches inside its limits is {far} away{place}"]
    error, axes = solution.target._position_rows(g, np.eye(6, 3))
    offset = g[:3, :3] @ axes.T @ error
    immovable = [axis for axis in abilities_of(arm).immovable if abs(axis @ offset) > solution.tolerances.position]
    lines += [cannot_move(axis, "base") for axis in immovable]
    return lines + _impossible(solution, solution.theta)


def _impossible(solution: IKResult, theta: Array) -> list[str]:
    """The rotation beyond all joints at theta (n,)."""
    impossible, _, axis = split_rotation(solution, theta)
    if impossible <= (0.0 if solution.stop is StopReason.IMPOSSIBLE_DIRECTION else NEGLIGIBLE):
        return []
    held = "the position" if len(solution.target._position_tolerance) else ""
    return [f"{cannot_turn(axis, 'tool', held)}; {_degrees(impossible)} of the rotation are missing"]


def split_rotation(solution: IKResult, theta: Array) -> tuple[float, float, Array]:
    """The rotation error [rad] at theta (n,) with the position held: beyond all joints, the rest, and the axis (3,).

    The axis, in tool axes, is that of the part beyond all joints. The compiled core splits the error
    (core/include/twistarm/ik/reason.hpp). Rotation rows times the null space of the position rows span what can be
    undone. Without the core both parts are 0.
    """
    chain, target = solution.arm.compiled, solution.target
    found = None if chain is None else chain.split_rotation(target.kind, target.numbers, theta)
    return (0.0, 0.0, np.zeros(3)) if found is None else (float(found[0]), float(found[1]), found[2:])


def _degrees(radians: float) -> str:
    degrees = math.degrees(radians)
    return f"{degrees:.1f}°" if degrees >= 0.1 else f"{degrees:.2g}°"
