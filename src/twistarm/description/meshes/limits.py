"""Limits of reading meshes: far above exported arms, far below a machine's capacity."""

from __future__ import annotations

LARGEST_FILE = 100_000_000
"""Bytes of a mesh file, and of all that it refers to: the heaviest of some hundred arms has 5 MB."""

TRIANGLES = 1_000_000
"""Of one file: a screen has as many pixels for an arm."""

PARTS = 5_000
"""Of one file, each an object that is drawn by itself: the heaviest have some hundred."""

MEMORY = 1_200_000_000
"""Bytes of addresses: a million triangles take 0.9 GB while they are simplified and shaded."""

LONGEST = 1e9
"""[m], of a coordinate, as in a description: its square still is a number with a square."""

SECONDS, SECONDS_PER_MEGABYTE, SECONDS_AT_MOST = 3.0, 1.0, 30.0
"""Processor time for one mesh: a megabyte of COLLADA takes 0.1 s."""

ARM_SECONDS, ARM_SECONDS_AT_MOST = 8.0, 90.0
"""Processor time for all meshes of an arm, and SECONDS_PER_MEGABYTE of each that is read."""

PATIENCE = 4.0
"""Times its processor time that a mesh may take on the clock: a machine has other work too, or its disk is slow."""


def seconds_for(size: int) -> float:
    """Processor time [s] that a mesh of `size` bytes may take."""
    return min(SECONDS + SECONDS_PER_MEGABYTE * size / 1e6, SECONDS_AT_MOST)
