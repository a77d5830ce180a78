"""The compiled kernels; `twistarm.arm.engine.core()` is the door to them.

Arrays are float64 and contiguous; other numbers are Python's float and int. A call answers None (solve_batch: False)
where an argument is another, or out of its range. Python then says what is wrong, or converts it and calls again. In
kinematics a single row beyond two turns goes to Python too, as it may be in degrees.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .support.checks import Array

INTERFACE: int

def instruction_sets() -> list[str]:
    """What this processor runs, best first: avx512, avx2, baseline."""

def pose(g: object, /) -> Array | None:
    """The numbers of a `Pose`, (4, 4), read-only; like those that follow, None where Python has to look."""

def position(p: object, /) -> Array | None:
    """The numbers of a `Position`, (3,)."""

def approach(p: object, direction: object, tool_axis: object, /) -> Array | None:
    """The numbers of an `Approach`: (9,), or (6,) where the tool axis is None."""

def task(g: object, tolerance: object, base_axes: bool, /) -> Array | None:
    """The numbers of a `TolerancedPose`, (23,)."""

def path_velocity(
    breakpoints: object,
    coefficients: object,
    velocity: object,
    acceleration: object,
    ceiling: object,
    grid: object,
    a: object,
    b: object,
    most: float,
    /,
) -> tuple[Array, Array] | None:
    """x (N + 1,) at most `most` and share (N,) on a grid along a `LimitedPath`: a `Profile`.

    At its points a s̈ + b ṡ² ≤ 1 holds too, for k rows, (N + 1, k) each.

    None for what is no plain array, and for paths of more rows or of a higher degree than the core takes.
    """

def shares_of_average(
    breakpoints: object,
    coefficients: object,
    velocity: object,
    acceleration: object,
    ceiling: object,
    grid: object,
    a: object,
    b: object,
    x: object,
    jerk: object,
    window: float,
    /,
) -> tuple[Array, Array] | None:
    """The shares (3, m) of the limits that the law x (N + 1,) uses, averaged over a window [s], and the largest ṡ (m,).

    None as for `path_velocity`.
    """

class Chain:
    """g_st(theta) = Π exp(ξ_i (Aθ)_i) · home, its Jacobians and its inverse, from screws (6, m), home (4, 4), A (m, n).

    Bounds are (n,), infinite where there are none but for random starts. `theta` is one configuration (n,) or a batch
    (N, n), which runs several at a time; everything runs without the interpreter lock.
    """

    def __init__(
        self,
        screws: Array,
        home: Array,
        coupling: Array,
        lower: Array,
        upper: Array,
        start_lower: Array,
        start_upper: Array,
        reach: float,
        instruction_set: str = "",
    ) -> None: ...
    @property
    def n(self) -> int:
        """Degrees of freedom."""
    @property
    def instruction_set(self) -> str:
        """The one that its kernels were compiled for."""
    def constants(self) -> dict[str, Any]:
        """What the kernels have made of screws and home (core/include/twistarm/chain.hpp).

        joints, coordinates, identity; base and tip (4, 4) and coupling (joints, coordinates) as nested lists; links, of
        which each has offset (3,), cos_alpha, sin_alpha, turn, phase, slide and revolute.
        """
    def fk(self, theta: object, /) -> Array | None:
        """g_st, (4, 4) or (N, 4, 4). MLS §3.2.2, eq. 3.3."""
    def spatial_jacobian(self, theta: object, /) -> Array | None:
        """J^s, (6, n) or (N, 6, n), linear part first. MLS §3.4.1."""
    def body_jacobian(self, theta: object, /) -> Array | None:
        """J^b, (6, n) or (N, 6, n), linear part first. MLS §3.4.1."""
    def fk_and_body_jacobian(self, theta: object, /) -> tuple[Array, Array] | None:
        """g_st and J^b in one pass."""
    def split_rotation(self, kind: object, numbers: object, theta: object, /) -> Array | None:
        """Of a target's rotation error [rad] at theta: impossible, prevented, and a unit vector (3,) of the tool."""
    def solve(
        self,
        kind: object,
        numbers: object,
        theta0: object,
        position_tol: object,
        orientation_tol: object,
        restarts: object,
        seed: object,
        max_time: object,
        posture: object,
        /,
    ) -> tuple[int, bytearray] | None:
        """Inverse kinematics of one target, given as its kind and its numbers (ik/targets.py).

        The number of the reason, and the bytes of a record (ik/answer.py).
        """
    def solve_batch(
        self,
        kind: object,
        numbers: object,
        theta0: object,
        position_tol: object,
        orientation_tol: object,
        restarts: object,
        seed: object,
        max_time: object,
        posture: object,
        threads: object,
        progress: object,
        records: NDArray[np.void],
        /,
    ) -> bool:
        """The same of N targets of one kind, a record for each; theta0 and posture for all (n,) or for each (N, n).

        `threads` share the work; `progress(done, count)` or None. Where the time was up before a target was finished,
        its stop is −1, and nothing but what was asked is written.
        """
    def reachable(
        self,
        kind: object,
        numbers: object,
        theta0: object,
        position_tol: object,
        orientation_tol: object,
        restarts: object,
        seed: object,
        chunks: object,
        threads: object,
        progress: object,
        /,
    ) -> tuple[NDArray[np.bool_], NDArray[np.float64]] | None:
        """Which of N targets of one kind are reached (N,), and their theta (N, n), NaN where one is not.

        A search begins at the answer before. It begins at theta0 (n,) at each of `chunks` (m + 1,): where chunks begin,
        in order, then N. Threads and progress are those of `solve_batch`.
        """

class ClosedForm:
    """The closed form of an arm's family for one kind of target; ik/closed_form/compiled.py says what it is made of."""

    def __init__(
        self,
        chain: Chain,
        kind: int,
        first: int,
        last: int,
        keeps: int,
        axes: Array,
        joint: Array,
        kept: Array,
        held: Array,
        held_axes: Array,
        rate: Array,
        home: Array,
        idle: Array,
        /,
    ) -> None: ...
    def solve(
        self, numbers: object, theta0: object, held: object, position_tol: object, orientation_tol: object, /
    ) -> tuple[Array, int, int, int, int] | None:
        """Every configuration that reaches a target: the fields of `Configurations` (ik/answer.py).

        held: values (m, h) of the held joints, each of which is tried; None for those of theta0.
        """
    def verify(
        self, numbers: object, theta0: object, candidates: object, position_tol: object, orientation_tol: object, /
    ) -> tuple[Array, int, int, int, int] | None:
        """Every configuration among candidates (k, n), as `solve` gives them. Held joints are as in the first."""
    def candidates(self, numbers: object, theta0: object, held: object, slack: object, /) -> Array | None:
        """Candidates (k, n) that forward kinematics has not verified, with held joints at values (h,).

        slack: by how much of its size an equation may be missed. Free joints are as in theta0, then elsewhere.
        """
    def solve_batch(
        self, numbers: object, theta0: object, position_tol: object, orientation_tol: object, threads: object, /
    ) -> tuple[Array, NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]] | None:
        """The same of N targets: the fields of `ConfigurationsBatch`. Held joints are at their values in theta0.

        theta0 is one for all (n,) or one for each (N, n).
        """

class Servo:
    """One arm's servo (core/include/twistarm/servo.hpp).

    Limits are those of the motors' rows x = C theta + c, k of them, and then of each coordinate; unit is 1, or for a
    slide the length [m] that compares metres with radians; singular values less than `below` are said to be
    singular. damping [s] is that of the resolved rates; stops: on the commanded course, where the arm cannot follow.
    """

    def __init__(
        self,
        screws: Array,
        home: Array,
        coupling: Array,
        C: Array,
        c: Array,
        lower: Array,
        upper: Array,
        velocity: Array,
        acceleration: Array,
        unit: Array,
        ready: Array,
        length: float,
        below: float,
        damping: float,
        stops: bool,
        /,
    ) -> None: ...
    def step(
        self,
        theta: object,
        theta_dot: object,
        held: object,
        kind: int,
        flags: int,
        numbers: object,
        dt: float,
        period: float,
        near: Array | None,
        /,
    ) -> tuple[Array, Array, Array | None, int, int, float, Array, float, bool, float, float, float] | None:
        """theta, theta_dot, held, cause, row, scale, lost, its share, halted, position and angle that remain, period.

        kind 0 for no command, else with flags and numbers as in control/servo/command.py. near (k, n + 2): how joints
        bring k pairs of bodies closer, the room of each pair and its time; at most 16 count.
        """

class Gaps:
    """Lower bounds of the distances of pairs of bodies: of a ball round one and a rounded box round the other.

    Each body has its joint, 0 for the world, and [p R] (3, 4) of its box in the frame of that joint. Each pair has the
    body with the ball and that with the box. `sizes` (k, 5) are half the box, the radii of both together, and 1 where
    the gap is the distance. Each of m joints has its twist (m, 6) in its own frame. `between` (k, m) is 1 where it
    carries the first body of a pair, -1 where the second. coupling (m, n): how fast it follows theta. `frames` are
    [p R] of these joints side by side (3, 4 m).
    """

    def __init__(
        self, joints: list[int], placements: Array, balls: list[int], boxes: list[int], sizes: Array,
        twists: Array, between: Array, coupling: Array, /,
    ) -> None: ...  # fmt: skip
    def gaps(self, frames: Array, pairs: list[int], /) -> Array:
        """The lower bounds (j,) [m] of these pairs."""

    def nearest(self, frames: Array, start: int, slack: float, measure: Callable[[int], float], /) -> tuple[int, float]:
        """The pair of the smallest distance, the first of equal ones, and that distance [m].

        `measure` gives the distance of a pair, less than the gap by at most `slack`. `start` is measured first.
        """

    def closest(
        self, frames: Array, limits: Array, margins: Array, count: int, measure: Callable[[int], tuple[float, ...]], /
    ) -> tuple[NDArray[np.int64], Array, NDArray[np.bool_], NDArray[np.int64], Array]:
        """The pairs (j,) whose gap is below their limit (k,), their distances or gaps (j,), and which are distances.

        Then the rows (c,) of at most `count` of them, with the least room beyond their margin (k,), and their
        -∂distance/∂theta (c, n). `measure` gives the distance [m] of a pair, its direction from first body to second,
        and the moment of that about the origin.
        """
