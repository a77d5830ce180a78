"""The answer of inverse kinematics: a configuration, its distance from the target, and the reason."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arm.almost_exact import angle_in_words, length_in_words
from ..arm.arm import Arm
from ..support.checks import Array
from ..support.directions import value_in_words
from ..support.display import told
from ..support.errors import NotConvergedError
from ..support.messages import Text, joined
from ..support.unit_hints import theta_hint
from .answer import CLOSED_FORM, DAMPED, FIELDS, NEAREST, STOPS, Answer, StopReason
from .explain import explain, summary
from .ranges import joint_ranges
from .targets import AnyTarget, target_of
from .task_space import Tolerances

if TYPE_CHECKING:
    from ..collision import Contact

NEGLIGIBLE_LENGTH = 1e-8
"""Shorter lengths [m] are not mentioned."""


def missed_by_rounding(position_error: float, orientation_error: float) -> str:
    """The note on a target that rounded axes miss by these errors [m], [rad]."""
    missed = [length_in_words(position_error)] if position_error >= NEGLIGIBLE_LENGTH else []
    missed += [angle_in_words(orientation_error)] if orientation_error > 0 else []
    return (
        f"the rounding of the arm's axes makes it miss the target by {' and '.join(missed)}: "
        "the doctor's finding axes-almost-exact names them"
    )


ANOTHER_BRANCH = "the target is near the pose of theta0, but the answer is not near theta0"
NEAREST_ELSEWHERE = "the nearest configuration is not near theta0, where the arm stays farther from the target"

MANY_JOINTS = 16
"""On arms with more joints, the nearest-configuration search finds one of very many minima."""

PERHAPS_NEARER = "an arm of so many joints may come nearer: try another rng or theta0"

WITHOUT_CORE = (
    "this is the best configuration found: the nearest one, and the reason, need the compiled core, "
    "and `twistarm info` says why it is missing"
)


@dataclass(eq=False, repr=False, slots=True)
class IKResult:
    """The answer to one target, which cannot be changed. It computes what costs time only when you ask for it."""

    _arm: Arm
    _answer: Answer
    _target: AnyTarget | None = None
    _contacts: tuple[Contact, ...] = ()
    _avoided: str = ""

    @property
    def arm(self) -> Arm:
        """The arm that was solved for."""
        return self._arm

    @property
    def target(self) -> AnyTarget:
        """The target that was solved for."""
        if self._target is None:
            self._target = target_of(int(self._answer.kind), self._answer.numbers)
        return self._target

    @property
    def tolerances(self) -> Tolerances:
        """The tolerances of the call; a `rounded` answer may miss by the arm's `rounding` instead."""
        return Tolerances(float(self._answer.position_tol), float(self._answer.orientation_tol))

    @property
    def theta(self) -> Array:
        """(n,) [rad, m], read-only: an answer if `converged`, else the nearest configuration.

        The nearest has the least position error inside the limits. The least rotation error with that position comes
        second. For TIMED_OUT and EXHAUSTED it is the best so far.
        """
        return self._answer.theta

    @property
    def unlimited(self) -> Array | None:
        """(n,) where limits block: an answer without them, or what comes nearest, the position first. Else None."""
        return self._answer.unlimited if self._answer.has_unlimited else None

    @property
    def position_error(self) -> float:
        """[m], from forward kinematics at theta, in what the target constrains."""
        return float(self._answer.position_error)

    @property
    def orientation_error(self) -> float:
        """[rad], from forward kinematics at theta, in what the target constrains."""
        return float(self._answer.orientation_error)

    @property
    def within_limits(self) -> bool:
        """Whether theta is inside the arm's limits."""
        return bool(self._arm.limits.contains(self.theta))

    @property
    def iterations(self) -> int:
        """Steps of the search that found theta; of all searches where none did."""
        return int(self._answer.iterations)

    @property
    def restarts(self) -> int:
        """Number of searches, the one from theta0 included."""
        return int(self._answer.restarts)

    @property
    def method(self) -> str:
        """The method that found theta: a damped search, the nearest-configuration search, or the closed form."""
        if self._answer.by_closed_form:
            return CLOSED_FORM
        return NEAREST if self._answer.nearest else DAMPED

    @property
    def certain(self) -> bool:
        """Whether the closed form proves that nothing inside the limits meets the target within tolerance."""
        return bool(self._answer.certain)

    @property
    def stop(self) -> StopReason:
        """Why the solver stopped."""
        return StopReason.IN_COLLISION if self._contacts else STOPS[int(self._answer.stop)]

    @property
    def converged(self) -> bool:
        """Whether theta is free and meets the target, to the tolerances or to the axes' rounding (`rounded`)."""
        return bool(self._answer.stop == 0) and not self._contacts

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """The pairs that collide at theta, if the call had a scene."""
        return self._contacts

    @property
    def rounded(self) -> bool:
        """Whether only the rounding of the arm's axes allows the answer: `notes` has its miss."""
        return self.converged and not self.tolerances.met(self.position_error, self.orientation_error)

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the answer: rounded axes, joints of theta0 brought inside, another branch, no core."""
        notes = self._moved_starts() if self._answer.start_moved else []
        notes += [self._other_branch()] if self._answer.other_branch else []
        notes += [self._avoided] if self._avoided else []
        notes += [missed_by_rounding(self.position_error, self.orientation_error)] if self.rounded else []
        if self._answer.nearest and not self.converged and self._arm.n > MANY_JOINTS:
            notes.append(PERHAPS_NEARER)
        return tuple(notes if self.converged or self._arm.compiled is not None else [*notes, WITHOUT_CORE])

    def explain(self) -> str:
        """What was asked, what was reached and why not more, line by line. Computed when called."""
        return explain(self)

    def require(self) -> Array:
        """theta (n,). Raises NotConvergedError, which carries this solution, where the target is not met."""
        if self.converged:
            return self.theta
        raise NotConvergedError(joined("; ", [summary(self), "solution.explain() says more"]), self)

    @property
    def _start(self) -> Array:
        """theta0 inside the limits, where the search began."""
        return joint_ranges(self._arm).inside(self._answer.theta0)

    def _moved_starts(self) -> list[str]:
        given, inside = self._answer.theta0, self._start
        arm = self._arm
        hint = theta_hint(given, arm.units, arm.limits.lower, arm.limits.upper)
        return [Text("theta0: {hint}", hint=hint)] * bool(hint) + [
            f"theta0 lay outside the limits: {name} {value_in_words(was, unit)} was brought inside, to "
            f"{value_in_words(now, unit)}"
            for name, was, now, unit in zip(arm.joint_names, given, inside, arm.units, strict=True)
            if was != now
        ]

    def _other_branch(self) -> str:
        moved = np.abs(self.theta - self._start)
        i = int(np.argmax(moved))
        why = ANOTHER_BRANCH if self.converged else NEAREST_ELSEWHERE
        moves = f"{self._arm.joint_names[i]} moves by {value_in_words(moved[i], self._arm.units[i])}"
        return f"another branch: {why}; {moves}"

    def __reduce__(self) -> tuple[Any, ...]:
        answer = [getattr(self._answer, name) for name in FIELDS]
        return _restored, (self._arm, answer, self._target, self._contacts, self._avoided)

    def __repr__(self) -> str:
        off = {"position_error": self.position_error, "orientation_error": self.orientation_error}
        return told("IKResult", {"stop": self.stop, "theta": self.theta, **off, "method": self.method})


def _restored(arm: Arm, fields: list[Any], *known: Any) -> IKResult:
    return IKResult(arm, Answer(*fields), *known)
