"""Limits of reading meshes, far above any exported arm and within the means of any machine."""

from __future__ import annotations

LARGEST_FILE = 100_000_000
"""Bytes of a mesh file, and of all that it refers to. The largest of some hundred arms has 5 MB."""

TRIANGLES = 1_000_000
"""Triangles of one file, about as many as an arm's pixels on a screen."""

PARTS = 5_000
"""Parts of one file, each drawn by itself. The largest files have some hundred."""

MEMORY = 1_200_000_000
"""Bytes of address space. To simplify and shade a million triangles takes 0.9 GB."""

LONGEST = 1e9
"""Largest coordinate [m], as in a description. Its fourth power is still a finite number."""

SECONDS, SECONDS_PER_MEGABYTE, SECONDS_AT_MOST = 3.0, 1.0, 30.0
"""Processor time for one mesh. A megabyte of COLLADA takes 0.1 s."""

ARM_SECONDS, ARM_SECONDS_AT_MOST = 8.0, 90.0
"""Processor time for all meshes of an arm, plus SECONDS_PER_MEGABYTE of each."""

PATIENCE = 4.0
"""Wall time of a mesh over its processor time. The machine may be busy, or its disk slow."""


def seconds_for(size: int) -> float:
    """Processor time [s] that a mesh of `size` bytes may take."""
    return min(SECONDS + SECONDS_PER_MEGABYTE * size / 1e6, SECONDS_AT_MOST)
