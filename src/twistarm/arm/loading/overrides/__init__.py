"""Overrides of a description, fitted to the chain: limits, named poses and states, actuators."""

from .actuators import fitted_actuators
from .limits import Changes, fitted_limits
from .poses import fitted_poses, fitted_states

__all__ = ["Changes", "fitted_actuators", "fitted_limits", "fitted_poses", "fitted_states"]
