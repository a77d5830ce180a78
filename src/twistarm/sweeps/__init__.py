"""Sweeps over many items on any executor, and over designs of an arm."""

from .chunks import Sweep
from .designs import DesignTable, sweep

__all__ = ["DesignTable", "Sweep", "sweep"]
