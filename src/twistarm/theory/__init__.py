"""The theory of screws in NumPy: rotations, twists, joints, products of exponentials. Knows no arm."""

from . import joints, poe, rotations, screws

__all__ = ["joints", "poe", "rotations", "screws"]
