"""Roots of the subproblems' equations in an angle's sine and cosine, or in a length.

Each function returns the real roots, or None where every value is a root. An equation that misses by less than `slack`
of its size has its nearest root. A stretched arm has one answer, in spite of rounding. Forward kinematics decides later
which roots are answers.
"""

from __future__ import annotations

import math

import numpy as np

from ...support.checks import Array

NEGLIGIBLE = 1e-9
"""A coefficient below this part of the equation's scale is zero."""

NEAREST = 1e100
"""Slack that accepts every miss, with the nearest value as root."""

LEVEL = 1e-7
"""Greatest constant, relative to the equation's scale, if all other coefficients are zero."""

DOUBLE_ROOT = 1e-13
"""A discriminant below this part of its size is rounding, and two roots are one."""

OFFSETS = 0.7 * np.arange(8)
"""Zeros of the angle to try, so that no root is at its half turn."""

CORRECTIONS = 3
"""Newton's steps for a root of the quartic."""


def harmonic(a: float, b: float, c: float, scale: float, slack: float) -> list[float] | None:
    """Angles x with a cos x + b sin x = c: atan2(b, a) ± acos(c / √(a² + b²)).

    `scale`: the size of the equation's other coefficients, by which zero is judged.
    """
    amplitude = math.hypot(a, b)
    if amplitude <= NEGLIGIBLE * scale:
        return None if abs(c) <= (LEVEL + slack) * scale else []
    if abs(c) > amplitude * (1.0 + slack) + NEGLIGIBLE * scale:
        return []
    square = (amplitude - c) * (amplitude + c)
    middle, opening = math.atan2(b, a), math.sqrt(square) if square > DOUBLE_ROOT * amplitude**2 else 0.0
    half = math.atan2(opening, c)
    return [middle + half] if opening == 0.0 else [middle + half, middle - half]


def quadratic(f: float, b: float, c: float, slack: float) -> list[float]:
    """Lengths x with f x² + b x + c = 0, without cancellation."""
    if abs(f) <= NEGLIGIBLE * abs(b):
        return [] if b == 0.0 else [-c / b]
    discriminant, size = b * b - 4.0 * f * c, b * b + abs(4.0 * f * c)
    if discriminant < -slack * size:
        return []
    root = math.sqrt(discriminant) if discriminant > DOUBLE_ROOT * size else 0.0
    q = -0.5 * (b + math.copysign(root, b))
    return [0.0] if q == 0.0 else [q / f, c / q] if root > 0.0 else [q / f]


def second_harmonic(k: Array, slack: float, terms: float = 0.0) -> list[float] | None:
    """Angles x with k₀ + k₁ c + k₂ s + k₃ c² + k₄ c s + k₅ s² = 0, c = cos x and s = sin x: up to four.

    A quartic in tan((x − x₀)/2). x₀ makes its leading coefficient large. `terms`: the size of what the coefficients are
    sums of. Where they all cancel to rounding every x is a root.
    """
    scale = float(np.abs(k).max())
    if scale <= NEGLIGIBLE * terms:
        return None
    offset = max(OFFSETS, key=lambda start: abs(_value(k, start + math.pi)))
    polynomial = _in_half_tangent(k, float(offset))
    if float(np.abs(polynomial).max()) <= NEGLIGIBLE * scale:
        return None
    roots = np.roots(polynomial)
    real = roots[np.abs(roots.imag) <= 3.0 * math.sqrt(slack) * (1.0 + np.abs(roots) ** 2)].real
    return [_corrected(k, 2.0 * math.atan(t) + float(offset), scale) for t in real]


def _value(k: Array, x: float) -> float:
    c, s = math.cos(x), math.sin(x)
    return float(k @ [1.0, c, s, c * c, c * s, s * s])


def _slope(k: Array, x: float) -> float:
    c, s = math.cos(x), math.sin(x)
    return float(k @ [0.0, -s, c, -2.0 * c * s, c * c - s * s, 2.0 * s * c])


def _in_half_tangent(k: Array, offset: float) -> Array:
    """Coefficients (5,), highest power first, of the equation times (1 + t²)², t = tan((x − offset)/2)."""
    c0, s0 = math.cos(offset), math.sin(offset)
    one, cosine, sine = np.array([1.0, 0.0, 1.0]), np.array([-1.0, 0.0, 1.0]), np.array([0.0, 2.0, 0.0])
    c, s = c0 * cosine - s0 * sine, s0 * cosine + c0 * sine
    pairs = ((one, one), (c, one), (s, one), (c, c), (c, s), (s, s))
    polynomial: Array = sum(weight * np.convolve(p, q) for weight, (p, q) in zip(k, pairs, strict=True))
    return polynomial


def _corrected(k: Array, x: float, scale: float) -> float:
    """x after some short steps of Newton's, which do not improve a double root."""
    for _ in range(CORRECTIONS):
        slope = _slope(k, x)
        if abs(slope) < NEGLIGIBLE * scale:
            break
        step = _value(k, x) / slope
        if abs(step) > 0.01:
            break
        x -= step
    return x
