"""The loop around the servo: commands in, setpoints out, watched joints. Also sources, sinks and simulated joints."""

from .cycles import Cycle, Metronome, come_to_rest
from .drives import SimulatedJoints
from .following import FollowControl, FollowCycle, Following, FollowOptions, FollowReport, follow
from .inbox import Inbox, StateInbox
from .messages import Recorder, command_of, parse_command, parse_state, setpoint_message
from .protocols import (
    Clock,
    Feedback,
    Interlock,
    LoopOptions,
    Measured,
    MonotonicClock,
    Reading,
    Setpoint,
    Sink,
    Source,
    UndeliveredError,
)
from .report import Ending, StreamReport
from .serial_link import SerialRobot, SerialSource
from .streaming import Streaming, StreamOptions, run
from .udp import Signer, UdpFeedback, UdpSink, UdpSource, Verifier, read_key

__all__ = [
    "Clock", "Cycle", "Ending", "Feedback", "FollowControl", "FollowCycle", "FollowOptions", "FollowReport",
    "Following", "Inbox", "Interlock", "LoopOptions", "Measured", "Metronome", "MonotonicClock", "Reading", "Recorder",
    "SerialRobot", "SerialSource", "Setpoint", "Signer", "SimulatedJoints", "Sink", "Source", "StateInbox",
    "StreamOptions", "StreamReport", "Streaming", "UdpFeedback", "UdpSink", "UdpSource", "UndeliveredError",
    "Verifier", "come_to_rest", "command_of", "follow", "parse_command", "parse_state", "read_key", "run",
    "setpoint_message",
]  # fmt: skip
