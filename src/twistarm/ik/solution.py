"""What inverse kinematics answers: a configuration, how far it is from what was asked, and the reason."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from ..arm import Arm
from ..checks import Array, frozen
from ..errors import NotConvergedError
from .damped import Tolerances
from .task_space import Target


class StopReason(Enum):
    """Why a solver stopped."""

    CONVERGED = "the target is met"
    OUT_OF_REACH = "out of reach"
    IMPOSSIBLE_DIRECTION = "impossible direction: the arm has no joint for it"
    BLOCKED_BY_LIMITS = "blocked by joint limits"
    EXHAUSTED = "no answer found, and none excluded"
    TIMED_OUT = "the time was up"


@dataclass(frozen=True, eq=False)
class IKSolution:
    """The answer to one target.

    theta (n,) [rad, m]: an answer if `converged`; else the nearest configuration: the least position error inside the
    limits, then, with the position held, the least rotation error (for TIMED_OUT and EXHAUSTED: the best so far).
    position_error [m], orientation_error [rad]: from forward kinematics at theta, of what the target constrains.
    iterations, restarts: steps of the search that found theta (of all of them where none did); searches that were run.
    unlimited (n,): where limits block, an answer without them.
    """

    theta: Array
    position_error: float
    orientation_error: float
    within_limits: bool
    iterations: int
    restarts: int
    method: str
    notes: tuple[str, ...]
    stop: StopReason
    arm: Arm = field(repr=False)
    target: Target = field(repr=False)
    tolerances: Tolerances = field(repr=False)
    unlimited: Array | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "theta", frozen(self.theta))
        if self.unlimited is not None:
            object.__setattr__(self, "unlimited", frozen(self.unlimited))

    @property
    def converged(self) -> bool:
        """Whether the target is met to the tolerances."""
        return self.stop is StopReason.CONVERGED

    def explain(self) -> str:
        """What was asked, what was reached, why not more, in plain words, line by line. Computed when called."""
        from .explain import explain

        return explain(self)

    def require(self) -> Array:
        """theta (n,), or NotConvergedError, which carries this solution, where the target is not met."""
        if self.converged:
            return self.theta
        from .explain import summary

        raise NotConvergedError(f"{summary(self)}; solution.explain() says more", self)
