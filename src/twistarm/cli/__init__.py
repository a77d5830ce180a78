"""The command line: the only place that prints or exits."""

from .application import main

__all__ = ["main"]
