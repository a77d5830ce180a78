"""The fixtures of the tests of streams."""

from stream_stand_ins import clock, robot, stream

__all__ = ["clock", "robot", "stream"]
