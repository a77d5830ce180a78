"""Exercises on calibration: a displaced arm, its slopes, what a log shows, and weighted least squares."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import expm, motion_of, twist_matrix
from .instances import TIMES, chain, chains, own_chain
from .words import ANGULAR_FIRST, NO_HOME


def displaced_tool(twists: Array, home: Array, displacements: Array, x: Array) -> Array:
    """The tool's pose (4, 4) of an arm with displaced joints: exp(δ̂₁) exp(ξ̂₁x₁) ⋯ exp(δ̂ₘ) exp(ξ̂ₘxₘ) exp(δ̂ₘ₊₁)
    g_st(0).

    `twists` (6, m) and `home` (4, 4) are the nominal arm's, `x` (m,) the joints' values [rad, m]. Column i of
    `displacements` (6, m + 1) is the twist δᵢ, seen from the base. Each carries its joint and all beyond it. The last
    one carries the tool.
    """
    from twistarm import screws

    g = np.eye(4)
    for i in range(len(x)):
        g = g @ screws.exp(displacements[:, i]) @ screws.exp(twists[:, i], x[i])
    return g @ screws.exp(displacements[:, -1]) @ home


def position_slopes(twists: Array, home: Array, x: Array) -> Array:
    """The derivatives (3, 6m + 6) of the tool's position by the numbers of the displacements δ₁ … δₘ₊₁, at δ = 0.

    Each displacement has six columns, in the order of the arm. The joints before it carry its twist along:
    Ad(exp(ξ̂₁x₁) ⋯ exp(ξ̂ᵢ₋₁xᵢ₋₁)) δᵢ = (v, ω). This moves the tool's origin p by v + ω × p.
    """
    from twistarm import poe, screws

    p = poe.fk(twists, home, x)[:3, 3]
    g = np.eye(4)
    columns = []
    for i in range(len(x) + 1):
        V = screws.adjoint(g)
        columns.append(V[:3] + np.cross(V[3:], p, axis=0))
        if i < len(x):
            g = g @ screws.exp(twists[:, i], x[i])
    return np.hstack(columns)


def shown_combinations(A: Array, sigma: Array, most: float) -> int:
    """How many independent combinations of parameters a log shows with a standard deviation of at most `most`.

    `A` (N, P) has the derivatives of the N measured numbers by the P parameters. `sigma` (N,) has the standard
    deviations of the measured numbers. Divide each row of A by its sigma. A combination with the singular value s has
    the standard deviation 1/s.
    """
    s = np.linalg.svd(A / sigma[:, None], compute_uv=False)
    return int(np.count_nonzero(s * most >= 1.0))


def weighted_fit(A: Array, r: Array, sigma: Array) -> tuple[Array, Array]:
    """The parameters q (P,) for which Σ ((A q − r) / σ)² is least, and their standard deviations (P,).

    `A` (N, P) has the derivatives. `r` (N,) is measured minus nominal. `sigma` (N,) has the standard deviations of the
    measured numbers. The covariance of q is (BᵀB)⁻¹, where B is A with each row divided by its sigma.
    """
    B = A / sigma[:, None]
    q = np.linalg.lstsq(B, r / sigma, rcond=None)[0]
    return q, np.sqrt(np.diag(np.linalg.inv(B.T @ B)))  # type: ignore[return-value]


def _displaced(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for twists, home, x in chains(rng, arm):
        yield twists, home, rng.normal(scale=0.2, size=(6, len(x) + 1)), x


def _stacked(rng: np.random.Generator, arm: Arm, rows: int) -> Array:
    """Slopes (3 rows, P) at several configurations of the reader's arm."""
    return np.vstack([position_slopes(*own_chain(rng, arm)) for _ in range(rows)])


def _logs(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    """Precise and rough logs. `most` is between two singular values."""
    for k in range(TIMES):
        A = rng.normal(size=(20, 8)) * 10.0 ** -np.arange(8.0) if k < 6 else _stacked(rng, arm, 4)
        sigma = 10.0 ** (rng.uniform(-0.5, 0.5, len(A)) + (-1.0 if k % 2 else 1.0))
        s = np.linalg.svd(A / sigma[:, None], compute_uv=False)
        i = int(rng.integers(1, 4))
        yield A, sigma, float(1.0 / np.sqrt(s[i] * s[i + 1]))


def _fits(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for _ in range(TIMES):
        twists, home, x = chain(rng)
        slopes = np.vstack([position_slopes(twists, home, x + rng.normal(size=len(x))) for _ in range(4)])
        A = slopes @ rng.normal(size=(slopes.shape[1], 5))
        sigma = 10.0 ** rng.uniform(-1, 0, len(A))
        yield A, A @ rng.normal(size=5) + sigma * rng.normal(size=len(A)), sigma


def _moved(twists: Array, home: Array, displacements: Array, x: Array) -> Array:
    """The exponentials of displacements and joints, taken in turn by their power series."""
    both = np.stack([displacements[:, :-1], twists * x], axis=2).reshape(6, -1)
    g: Array = motion_of(both, np.ones(both.shape[1])) @ expm(twist_matrix(displacements[:, -1])) @ home
    return g


def _differences(twists: Array, home: Array, x: Array) -> Array:
    """By difference quotients of `_moved`."""
    m, h = len(x) + 1, 1e-5
    columns = []
    for step in h * np.eye(6 * m):
        ahead, behind = (_moved(twists, home, sign * step.reshape(m, 6).T, x)[:3, 3] for sign in (1.0, -1.0))
        columns.append((ahead - behind) / (2 * h))
    return np.column_stack(columns)


def _counted(A: Array, sigma: Array, most: float) -> int:
    """By the eigenvalues of the information matrix."""
    information = np.einsum("ki,kj,k->ij", A, A, sigma**-2.0)
    return int((np.linalg.eigvalsh(information) >= most**-2.0).sum())


def _normal(A: Array, r: Array, sigma: Array) -> list[Array]:
    """By the normal equations, solved for each unit vector."""
    information = np.einsum("ki,kj,k->ij", A, A, sigma**-2.0)
    covariance = np.linalg.solve(information, np.eye(A.shape[1]))
    return [covariance @ (A.T @ (r * sigma**-2.0)), np.array([c[i] ** 0.5 for i, c in enumerate(covariance)])]


EXERCISES = (
    Exercise(
        displaced_tool,
        _moved,
        _displaced,
        (
            Slip(
                "after its joint",
                "You displace each joint after it has moved. That leaves its axis where it was: exp(δ̂ᵢ) comes before "
                "exp(ξ̂ᵢxᵢ).",
                {
                    "screws.exp(displacements[:, i]) @ screws.exp(twists[:, i], x[i])": (
                        "screws.exp(twists[:, i], x[i]) @ screws.exp(displacements[:, i])"
                    )
                },
            ),
            Slip(
                "axes alone",
                "You displace only the axes. Multiply by exp(δ̂ᵢ): it moves everything beyond the joint.",
                {
                    "g @ screws.exp(displacements[:, i]) @ screws.exp(twists[:, i], x[i])": (
                        "g @ screws.exp(screws.adjoint(screws.exp(displacements[:, i])) @ twists[:, i], x[i])"
                    )
                },
            ),
            Slip(
                "added",
                "You add the displacement to the joint's motion. Sums in the exponent are products only if the two "
                "commute: exp(δ̂) exp(ξ̂x).",
                {
                    "screws.exp(displacements[:, i]) @ screws.exp(twists[:, i], x[i])": (
                        "screws.exp(displacements[:, i] + x[i] * twists[:, i])"
                    )
                },
            ),
            Slip(
                "tool not displaced",
                "The last displacement, that of the tool, is missing: there are m + 1 of them.",
                {" @ screws.exp(displacements[:, -1])": ""},
            ),
            Slip(
                "tool displaced in its own frame",
                "You multiply the tool's displacement behind home: that is seen from the tool. It is seen from the "
                "base, and comes before home.",
                {"screws.exp(displacements[:, -1]) @ home": "home @ screws.exp(displacements[:, -1])"},
            ),
            Slip("no home", NO_HOME, {" @ home": ""}),
        ),
    ),
    Exercise(
        position_slopes,
        _differences,
        chains,
        (
            Slip(
                "v for the velocity",
                "You take v alone: that is how the point at the base's origin moves. The tool's origin moves by v + "
                "ω × p.",
                {" + np.cross(V[3:], p, axis=0)": ""},
            ),
            Slip(
                "sign of ω × p",
                "You have p × ω, the other way round: a turning body moves its points with ω × p.",
                {"np.cross(V[3:], p, axis=0)": "np.cross(p, V[3:], axis=0)"},
            ),
            Slip(
                "not carried",
                "Your columns are those of the arm at rest: the joints before a displacement carry its twist along.",
                {"screws.adjoint(g)": "np.eye(6)"},
            ),
            Slip(
                "carried by its own joint",
                "You carry each displacement by its own joint too. It comes before this joint: take only those before.",
                {
                    "        V = screws.adjoint(g)\n": (
                        "        V = screws.adjoint(g @ screws.exp(twists[:, i], x[i])) if i < len(x) else "
                        "screws.adjoint(g)\n"
                    )
                },
            ),
            Slip(
                "tool at rest",
                "p is the tool's origin at rest. It is where the joints have brought it, at x.",
                {"poe.fk(twists, home, x)[:3, 3]": "home[:3, 3]"},
            ),
            Slip(
                "tool missing",
                "The six columns of the tool's own displacement are missing: there are m + 1 displacements.",
                {"return np.hstack(columns)": "return np.hstack(columns[:-1])"},
            ),
            Slip("angular first", ANGULAR_FIRST, {"screws.adjoint(g)": "np.roll(screws.adjoint(g), 3, axis=1)"}),
        ),
        tolerance=1e-5,
    ),
    Exercise(
        shown_combinations,
        _counted,
        _logs,
        (
            Slip(
                "noise left out",
                "You leave the noise out: a singular value of A alone has units, and does not show what can be seen.",
                {"A / sigma[:, None]": "A"},
            ),
            Slip(
                "multiplied by sigma",
                "You multiply the rows by sigma: so the worst measurements count most. Divide.",
                {"A / sigma[:, None]": "A * sigma[:, None]"},
            ),
            Slip(
                "all but zero",
                "You count every singular value that is not 0, the rank. A combination may be shown so weakly that its "
                "standard deviation is a metre.",
                {"s * most >= 1.0": "s > 1e-12 * s[0]"},
            ),
            Slip(
                "variance for deviation",
                "You compare the variance 1/s² with a standard deviation: that is 1/s.",
                {"s * most >= 1.0": "s**2 * most >= 1.0"},
            ),
            Slip("not shown counted", "You count those that the log does not show.", {">= 1.0": "< 1.0"}),
        ),
    ),
    Exercise(
        weighted_fit,
        _normal,
        _fits,
        (
            Slip(
                "not weighted",
                "You do not weigh the rows: one bad number counts as much as a good one. Divide the rows of A and r by "
                "sigma.",
                {"lstsq(B, r / sigma": "lstsq(A, r"},
            ),
            Slip(
                "r not divided",
                "You divide the rows of A by sigma, but not r: both are in units of the noise.",
                {"r / sigma": "r"},
            ),
            Slip(
                "weights not squared",
                "You divide by the root of sigma: the squares then have the weight 1/σ, and it should be 1/σ².",
                {"lstsq(B, r / sigma": "lstsq(A / np.sqrt(sigma)[:, None], r / np.sqrt(sigma)"},
            ),
            Slip(
                "sign",
                "The sign of q is reversed: r is measured minus nominal, so A q comes near r.",
                {"return q, ": "return -q, "},
            ),
            Slip(
                "variances",
                "These are the variances, the diagonal of the covariance: take the root.",
                {"np.sqrt(np.diag(np.linalg.inv(B.T @ B)))": "np.diag(np.linalg.inv(B.T @ B))"},
            ),
            Slip(
                "alone",
                "You invert the diagonal. These are the deviations if all other parameters were known: take the "
                "diagonal of the inverse.",
                {"np.sqrt(np.diag(np.linalg.inv(B.T @ B)))": "1.0 / np.sqrt(np.diag(B.T @ B))"},
            ),
        ),
    ),
)
