"""The ready configuration of an arm: one that its description names, else a computed one in round numbers."""

from .merit import Mechanism
from .named import USUAL_NAMES, named_ready
from .overlaps import Overlapping, overlapping_links
from .search import computed_ready

__all__ = ["USUAL_NAMES", "Mechanism", "Overlapping", "computed_ready", "named_ready", "overlapping_links"]
