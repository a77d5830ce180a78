"""Mesh files as triangles, read by a separate process within limits of time and memory."""

from .mesh_file import REMEDY, Part, UnreadableMeshError, size_of
from .reader import MeshReader

__all__ = ["REMEDY", "MeshReader", "Part", "UnreadableMeshError", "size_of"]
