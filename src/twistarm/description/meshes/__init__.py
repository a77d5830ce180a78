"""Mesh files as triangles, read in a separate process within limits."""

from .formats import LIGHTER, REMEDY, UnreadableMeshError
from .part import Part
from .reader import MeshReader

__all__ = ["LIGHTER", "REMEDY", "MeshReader", "Part", "UnreadableMeshError"]
