"""Mesh files, which somebody else made, as triangles: read in a process of their own, within limits."""

from .formats import LIGHTER, REMEDY, UnreadableMeshError
from .part import Part
from .reader import MeshReader

__all__ = ["LIGHTER", "REMEDY", "MeshReader", "Part", "UnreadableMeshError"]
