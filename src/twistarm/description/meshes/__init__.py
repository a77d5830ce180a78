"""Mesh files as triangles, read once for drawing and for collisions."""

from .mesh import REMEDY, Mesh, Part, UnreadableMeshError
from .reading import extreme_points, read_mesh

__all__ = ["REMEDY", "Mesh", "Part", "UnreadableMeshError", "extreme_points", "read_mesh"]
