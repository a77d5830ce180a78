"""The loop around the servo: commands in, setpoints out, watched joints. Also sources, sinks and simulated joints."""

from .cycles import Cycle
from .driving import come_to_rest
from .following.cycle import FollowControl, FollowCycle, Following
from .following.follow import FollowReport, follow
from .interlock import Interlock
from .links.inbox import Inbox, StateInbox
from .links.messages import command_of, parse_command, parse_state, setpoint_message
from .links.serial_link import SerialRobot, SerialSource
from .links.signing import Signer, Verifier, read_key
from .links.udp import UdpFeedback, UdpSink, UdpSource
from .metronome import Metronome, MonotonicClock
from .options import StreamOptions
from .protocols import Clock, Feedback, Measured, Reading, Setpoint, Sink, Source, UndeliveredError
from .recording import Recorder
from .report import Ending, StreamReport
from .simulation import SimulatedJoints
from .streaming import Streaming, run

__all__ = [
    "Clock", "Cycle", "Ending", "Feedback", "FollowControl", "FollowCycle", "FollowReport", "Following", "Inbox",
    "Interlock", "Measured", "Metronome", "MonotonicClock", "Reading", "Recorder", "SerialRobot", "SerialSource",
    "Setpoint", "Signer", "SimulatedJoints", "Sink", "Source", "StateInbox", "StreamOptions", "StreamReport",
    "Streaming", "UdpFeedback", "UdpSink", "UdpSource", "UndeliveredError", "Verifier", "come_to_rest",
    "command_of", "follow", "parse_command", "parse_state", "read_key", "run", "setpoint_message",
]  # fmt: skip
