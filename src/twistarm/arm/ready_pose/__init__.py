"""The ready configuration of an arm: one that its description names, else a computed one in round numbers."""

from .bodies import Bodies
from .merit import Mechanism
from .named import USUAL_NAMES, named_ready
from .search import Overlapping, computed_ready

__all__ = ["USUAL_NAMES", "Bodies", "Mechanism", "Overlapping", "computed_ready", "named_ready"]
