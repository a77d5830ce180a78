"""The loop around the servo: commands in, setpoints out, watched joints. Also sources, sinks and simulated joints."""

from .cycles import Cycle
from .driving import Metronome, come_to_rest
from .following import FollowControl, FollowCycle, Following, FollowReport, follow
from .inbox import Inbox, StateInbox
from .interlock import Interlock
from .messages import command_of, parse_command, parse_state, setpoint_message
from .protocols import (
    Clock,
    Feedback,
    Measured,
    MonotonicClock,
    Reading,
    Setpoint,
    Sink,
    Source,
    StreamOptions,
    UndeliveredError,
)
from .recording import Recorder
from .report import Ending, StreamReport
from .serial_link import SerialRobot, SerialSource
from .signing import Signer, Verifier, read_key
from .simulation import SimulatedJoints
from .streaming import Streaming, run
from .udp import UdpFeedback, UdpSink, UdpSource

__all__ = [
    "Clock", "Cycle", "Ending", "Feedback", "FollowControl", "FollowCycle", "FollowReport", "Following", "Inbox",
    "Interlock", "Measured", "Metronome", "MonotonicClock", "Reading", "Recorder", "SerialRobot", "SerialSource",
    "Setpoint", "Signer", "SimulatedJoints", "Sink", "Source", "StateInbox", "StreamOptions", "StreamReport",
    "Streaming", "UdpFeedback", "UdpSink", "UdpSource", "UndeliveredError", "Verifier", "come_to_rest",
    "command_of", "follow", "parse_command", "parse_state", "read_key", "run", "setpoint_message",
]  # fmt: skip
