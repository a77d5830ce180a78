"""What a program draws in the scene, by name."""

from collections.abc import Iterable

from ..protocol.messages import Message
from .part import Part, Show


class Drawings(Part):
    """The latest message of each node. A removed one stays as a message that draws nothing."""

    def __init__(self) -> None:
        self.drawn: dict[str, Message] = {}

    def messages(self, show: Show) -> Iterable[Message]:
        """A message for each node."""
        return self.drawn.values()
