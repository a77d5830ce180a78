"""An arm drawn as a line from axis to axis: its corners, and the distances of its strokes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...support.checks import Array

STROKES = 12
"""The most strokes to keep apart: the longest."""

SHORT = 0.03
"""A stroke below this share of the arm's size does not count."""

FOLDED = 0.766
"""−cos of the bend, 140°, from which a stroke counts as folded onto the one before."""

PARALLEL = 1e-9
"""The squared sine of an angle, or of a unit twist's turn, that counts as zero."""

APART, OF_WAY = 0.1, 0.8
"""Wanted distances of strokes: a share of the arm's size, and of the length between them if that is less."""


@dataclass(frozen=True)
class Sketch:
    """Corners at theta = 0, (k, 3), base to tool, and the moving joint that carries each (0: none), (k,).

    A revolute joint's corner is the point of its axis nearest to the corner before. A slide repeats that corner.
    Strokes connect corners from the `first` revolute joint on; the rest is the mount.
    """

    corners: Array
    carriers: np.ndarray[tuple[int, ...], np.dtype[np.intp]]
    first: int

    def at(self, motions: Array) -> Array:
        """The corners (..., k, 3) for what each joint has undergone, (..., m + 1, 4, 4), the identity first."""
        moved = motions[..., self.carriers, :, :]
        placed: Array = np.einsum("...ij,...j->...i", moved[..., :3, :3], self.corners) + moved[..., :3, 3]
        return placed

    @cached_property
    def lengths(self) -> Array:
        """Of the strokes, (k − 1,), at theta = 0."""
        lengths: Array = np.linalg.norm(np.diff(self.corners, axis=0), axis=1)
        return lengths

    @cached_property
    def strokes(self) -> list[int]:
        """The corners where the longest strokes begin, base to tool."""
        long = [k for k in np.argsort(-self.lengths, kind="stable")[:STROKES] if self.lengths[k] > SHORT * self.size]
        return sorted(k for k in map(int, long) if k >= self.first)

    @cached_property
    def size(self) -> float:
        """Length of the stretched arm from its first axis to the tool [m]; 1 m for an arm without length."""
        return float(self.lengths[self.first :].sum()) or 1.0

    def crowding(self, placed: Array) -> Array:
        """Crowding (...) from 0, no strokes near, to 1, two touch or one is folded onto the next."""
        pairs = [(a, b) for i, a in enumerate(self.strokes) for b in self.strokes[i + 1 :]]
        touching = [(a, b) for a, b in pairs if self.lengths[a + 1 : b].sum() < SHORT * self.size]
        apart = [pair for pair in pairs if pair not in touching]
        worst = np.zeros(placed.shape[:-2])
        if touching:
            worst = np.maximum(worst, self._folding(placed, *np.array(touching).T).max(-1))
        if apart:
            a, b = np.array(apart).T
            between = np.array([self.lengths[a + 1 : b].sum() for a, b in apart])
            enough = np.minimum(APART * self.size, OF_WAY * between)
            distance = between_strokes(
                placed[..., a, :], placed[..., a + 1, :], placed[..., b, :], placed[..., b + 1, :]
            )
            worst = np.maximum(worst, np.maximum(0.0, 1.0 - distance / enough).max(-1))
        return worst

    def _folding(self, placed: Array, a: Array, b: Array) -> Array:
        """Folding of strokes that meet: 0 up to a bend of 140°, 1 if they lie on each other."""
        one, other = placed[..., a + 1, :] - placed[..., a, :], placed[..., b + 1, :] - placed[..., b, :]
        lengths = np.linalg.norm(one, axis=-1) * np.linalg.norm(other, axis=-1)
        cosine = np.sum(one * other, axis=-1) / np.maximum(lengths, 1e-12)
        folded: Array = np.clip((-cosine - FOLDED) / (1.0 - FOLDED), 0.0, 1.0)
        return folded


def sketched(screws: Array, tool: Array) -> Sketch:
    """The sketch of a chain of `screws` (6, m) to a tool with origin `tool` (3,) at theta = 0."""
    corners, carriers = [np.zeros(3)], [0]
    turning = np.sum(screws[3:] ** 2, axis=0) > PARALLEL
    for i, (v, w) in enumerate(screws.T.reshape(-1, 2, 3)):
        corner = corners[-1]
        if turning[i]:
            on_axis = np.cross(w, v) / (w @ w)
            corner = on_axis + w * ((corner - on_axis) @ w) / (w @ w)
        corners.append(corner)
        carriers.append(i + 1)
    return Sketch(np.array([*corners, tool]), np.array([*carriers, len(carriers) - 1]), 1 + int(np.argmax(turning)))


def between_strokes(a: Array, b: Array, c: Array, d: Array) -> Array:
    """Distances (...) of the segments a–b and c–d, points (..., 3). Ericson, Real-Time Collision Detection, §5.1.9."""
    along, other, gap = b - a, d - c, a - c
    aa, bb, ab = (np.sum(x * y, axis=-1) for x, y in ((along, along), (other, other), (along, other)))
    ag, bg = np.sum(along * gap, axis=-1), np.sum(other * gap, axis=-1)
    aa, bb = np.maximum(aa, 1e-18), np.maximum(bb, 1e-18)
    across = aa * bb - ab * ab
    s = np.where(across > PARALLEL * aa * bb, np.clip((ab * bg - ag * bb) / np.maximum(across, 1e-30), 0.0, 1.0), 0.0)
    t = np.clip((ab * s + bg) / bb, 0.0, 1.0)
    s = np.clip((ab * t - ag) / aa, 0.0, 1.0)
    distances: Array = np.linalg.norm(gap + along * s[..., None] - other * t[..., None], axis=-1)
    return distances
