"""Hypothesis strategies: batch shapes, rotations, poses, twists; and the exact references tests hold them to.

Nothing here uses twistarm: rotations come from SciPy, exponentials from integer arithmetic.
"""

import numpy as np
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

EPS = np.finfo(float).eps

BATCHES = ((), (1,), (4,), (2, 3), (0,))
SCALES = (1e-9, 1e-3, 1.0, 1e3, 1e6)
HARD_ANGLES = (
    0.0, 1e-300, 1e-160, 1e-16, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 0.1, np.pi / 2,
    2 * np.pi / 3, np.pi - 1e-3, np.pi - 1e-6, np.pi - 1e-8, np.pi - 1e-9, np.pi - 1e-12, np.pi - 1e-15, np.pi,
)  # fmt: skip
"""Where series, quotients and branches of rotations go wrong [rad]."""

batches = st.sampled_from(BATCHES)
scales = st.sampled_from(SCALES)
generators = st.integers(0, 2**32 - 1).map(np.random.default_rng)


@st.composite
def vectors(draw, batch=(), size=3, scale=1.0):
    """Normally distributed (*batch, size), of order `scale`, each component sometimes exactly 0."""
    rng = draw(generators)
    values = scale * rng.normal(size=(*batch, size))
    return np.where(rng.random(values.shape) < 0.1, 0.0, values)


@st.composite
def directions(draw, batch=()):
    """Unit vectors (*batch, 3), a quarter of them along a coordinate axis."""
    rng = draw(generators)
    values = rng.normal(size=(*batch, 3))
    along = np.eye(3)[rng.integers(3, size=batch)] * rng.choice([-1.0, 1.0], size=(*batch, 1))
    values = np.where(rng.random((*batch, 1)) < 0.25, along, values)
    return values / np.linalg.norm(values, axis=-1, keepdims=True)


@st.composite
def angles(draw, batch=()):
    """Angles (*batch) in [0, π] [rad], half of them hard ones."""
    rng = draw(generators)
    return np.where(rng.random(batch) < 0.5, rng.choice(HARD_ANGLES, size=batch), rng.uniform(0, np.pi, batch))


@st.composite
def twists(draw, batch=(), scale=1.0):
    """(v, w) (*batch, 6) with v of order `scale` [m] and ‖w‖ ≤ π [rad]."""
    w = draw(directions(batch)) * np.asarray(draw(angles(batch)))[..., None]
    return np.concatenate([draw(vectors(batch, 3, scale)), w], axis=-1)


@st.composite
def rotations(draw, batch=()):
    """Rotation matrices (*batch, 3, 3) whose angles include the hard ones."""
    w = draw(directions(batch)) * np.asarray(draw(angles(batch)))[..., None]
    return Rotation.from_rotvec(w.reshape(-1, 3)).as_matrix().reshape(*batch, 3, 3)


@st.composite
def poses(draw, batch=(), scale=1.0):
    """Homogeneous poses (*batch, 4, 4), translations of order `scale` [m]."""
    g = np.zeros((*batch, 4, 4))
    g[..., :3, :3] = draw(rotations(batch))
    g[..., :3, 3] = draw(vectors(batch, 3, scale))
    g[..., 3, 3] = 1.0
    return g


def exact_exp(matrix):
    """e^matrix of one small matrix, correctly rounded: its Taylor series in integers, 400 bits after the point."""
    one = 1 << 400
    M = np.array([[_fixed_point(value) for value in row] for row in matrix], dtype=object)
    term = total = np.array([[one * (i == j) for j in range(len(M))] for i in range(len(M))], dtype=object)
    for k in range(1, 120):
        term = (term @ M) // (one * k)
        total = total + term
    return np.array([[entry / one for entry in row] for row in total])


def _fixed_point(value):
    numerator, denominator = float(value).as_integer_ratio()
    return (numerator << 400) // denominator


def close(a, b, tol=64 * EPS):
    """Equal within `tol`; by default the rounding of products of a few exponentials, for arms of a few metres."""
    np.testing.assert_allclose(a, b, rtol=0, atol=tol)


def derivative(f, t=0.0, h=1e-3):
    """df/dt by central differences of sixth order."""
    steps = ((1, 45.0), (2, -9.0), (3, 1.0))
    return sum(c * (np.asarray(f(t + k * h)) - np.asarray(f(t - k * h))) for k, c in steps) / (60.0 * h)
