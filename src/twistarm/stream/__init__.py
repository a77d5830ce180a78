"""The loop around the servo: commands in, setpoints out, the joints watched; sources, sinks and simulated joints."""

from .interlock import Interlock
from .links.gate import ExposedPortWarning, Signer, Verifier, read_key
from .links.inbox import Inbox
from .links.messages import command_of, parse_command, parse_state, setpoint_message
from .links.serial_link import SerialRobot, SerialSource
from .links.state_inbox import StateInbox
from .links.udp import UdpFeedback, UdpSink, UdpSource
from .loop import come_to_rest, run
from .metronome import Metronome, MonotonicClock
from .protocols import Clock, Feedback, Measured, Reading, Setpoint, Sink, Source, UndeliveredError
from .recording import Recording, read_recording
from .replay import Replay
from .report import Ending, StreamReport
from .simulation import SimulatedJoints
from .streaming import Cycle, Streaming

__all__ = [
    "Clock",
    "Cycle",
    "Ending",
    "ExposedPortWarning",
    "Feedback",
    "Inbox",
    "Interlock",
    "Measured",
    "Metronome",
    "MonotonicClock",
    "Reading",
    "Recording",
    "Replay",
    "SerialRobot",
    "SerialSource",
    "Setpoint",
    "Signer",
    "SimulatedJoints",
    "Sink",
    "Source",
    "StateInbox",
    "StreamReport",
    "Streaming",
    "UdpFeedback",
    "UdpSink",
    "UdpSource",
    "UndeliveredError",
    "Verifier",
    "come_to_rest",
    "command_of",
    "parse_command",
    "parse_state",
    "read_key",
    "read_recording",
    "run",
    "setpoint_message",
]
