"""A computed configuration to start from, in round numbers."""

from .search import computed_ready

__all__ = ["computed_ready"]
