"""Datagrams on loopback: what arrives, who sent it, and floods, lost receivers; docs/streaming.md."""

from __future__ import annotations

import json
import re
import socket
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest

from stream_stand_ins import FakeClock, Robot, Says, jog
from twistarm.control.stream import (
    Ending,
    Interlock,
    SimulatedJoints,
    UdpFeedback,
    UdpSink,
    UdpSource,
    Verifier,
    parse_command,
    run,
)
from twistarm.control.stream.messages import obey_interlock_message
from twistarm.control.stream.udp import MOST_PER_CYCLE
from twistarm.support.errors import InputError

JOG = {"jog": {"elbow": -0.3}}


@pytest.fixture
def client():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        yield out


@pytest.fixture
def source(rover):
    with UdpSource(rover) as opened:
        opened.read(0.0)
        yield opened


def listener(address=("127.0.0.1", 0)):
    receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    receiver.settimeout(1.0)
    receiver.bind(address)
    return receiver


def send(client, message, to):
    client.sendto(message if isinstance(message, bytes) else json.dumps(message).encode(), to.address)


def test_a_command_arrives(rover, client, source):
    send(client, JOG, source)
    reading = source.read(0.1)
    assert reading.command.theta_dot.tolist() == [0.0, 0.0, -0.3, 0.0, 0.0]
    assert source.read(0.35).command is None


@pytest.mark.parametrize("message", [b"", b"\xff" * 9_000, b'{"jog": {"elbow": NaN}}'])
def test_nonsense_is_refused_in_the_senders_name(client, source, message):
    send(client, JOG, source)
    send(client, message, source)
    reading = source.read(0.1)
    assert reading.command is None
    assert f"127.0.0.1:{client.getsockname()[1]}" in reading.reason
    assert len(reading.reason) < 500


def test_what_waited_while_nobody_looked_is_left_out(rover, client, source):
    send(client, JOG, source)
    assert source.read(10.0).command is None
    send(client, JOG, source)
    assert source.read(10.1).command is not None
    with UdpSource(rover) as fresh:
        send(client, JOG, fresh)
        assert fresh.read(5.0).command is None


def test_a_flood_costs_a_bounded_time_per_cycle_and_the_latest_counts(rover, client, source):
    for k in range(10_000):
        with suppress(OSError):  # a system may say that its buffers are full
            send(client, b'{"jog":{"elbow":-0.3},"number":%d}' % k, source)
    began = time.perf_counter()
    taken = sum(1 for _ in source.waiting())
    assert 0 < taken <= MOST_PER_CYCLE
    assert next(source.waiting(), None) is None
    assert time.perf_counter() - began < 0.1
    send(client, JOG, source)
    assert source.read(0.1).command is not None


def test_joint_states_arrive_by_name(rover, client):
    with UdpFeedback(rover) as feedback:
        assert feedback.read(1.0).theta is None
        names = list(reversed(rover.joint_names))
        send(client, {"joint_names": names, "theta": [5, 4, 3, 2, 1]}, feedback)
        measured = feedback.read(1.05)
        assert measured.theta.tolist() == [1.0, 2.0, 3.0, 4.0, 5.0]
        assert measured.time == pytest.approx(1.05)
        for name in names:  # one message for each joint, all in one cycle
            send(client, {"joint_names": [name, "wheel"], "theta": [0.5, 9]}, feedback)
        send(client, {"joint_names": ["wheel"], "theta": [9]}, feedback)
        measured = feedback.read(1.1)
        assert measured.theta.tolist() == [0.5] * 5
        assert measured.time == pytest.approx(1.1)


class Following(Says):
    """The arm does as it is told, so that nothing but the sink is amiss; `events`: what happens when."""

    def __init__(self, robot, command, events):
        super().__init__(command)
        self.robot, self.events = robot, dict(events)

    def read(self, now, state):
        if state is not None:
            self.robot.theta = state.theta
        for moment in [moment for moment in self.events if moment < now]:
            self.events.pop(moment)()
        return super().read(now, state)


def test_a_robot_that_restarts_is_waited_for(rover):
    """From 0.5 s to 1.0 s nobody listens. Where a system tells of it one call later, one setpoint later is blamed."""
    clock, heard, seen = FakeClock(), [], []
    robot, first = Robot(rover.ready, clock), listener()
    address = first.getsockname()
    events = {100.505: first.close, 101.005: lambda: heard.append(listener(address))}
    with UdpSink(rover, *address) as sink:
        source = Following(robot, jog(rover, elbow=-0.3), events)
        report = run(rover, source, sink, robot, duration=1.5, clock=clock, on_cycle=seen.append)
    (second,) = heard
    assert json.loads(second.recv(65536))["number"] == 101
    second.close()
    lost = [cycle.setpoint.number for cycle in seen if not cycle.delivered]
    assert lost in (list(range(51, 101)), list(range(52, 102)))
    assert report.undelivered == {seen[60].reason: 50}
    assert seen[60].reason.endswith(f"127.0.0.1:{address[1]}")
    assert (report.ending, report.delivered, report.ok) == (Ending.DURATION, True, True)


def test_what_else_a_system_refuses_ends_the_stream(rover):
    clock = FakeClock()
    robot, receiver = Robot(rover.ready, clock), listener()
    with receiver, UdpSink(rover, *receiver.getsockname()) as sink:
        source = Following(robot, None, {100.505: sink.close})
        report = run(rover, source, sink, robot, duration=1.0, clock=clock)
    assert report.ending is Ending.SINK_FAILED
    assert report.reason.startswith("OSError: ")
    assert not report.delivered


@pytest.mark.parametrize(("host", "port"), [("127.0.0.1", 70_000), ("127.0.0.1", "9870"), ("no..host", 9870)])
def test_addresses_that_cannot_be_and_a_port_in_use_are_named(rover, source, host, port):
    for opened in (UdpSource, UdpFeedback, UdpSink):
        with pytest.raises(InputError, match=f"{port}|{host}"):
            opened(rover, host, port)
    with pytest.raises(InputError, match=f"127.0.0.1:{source.address[1]}"):
        UdpFeedback(rover, *source.address)


PAGE = (Path(__file__).parents[2] / "docs" / "streaming.md").read_text("utf-8")
CLIENT, SIGNED = re.findall(r"<!-- another program -->\n```python\n(.*?)```", PAGE, flags=re.S)

GAPS = {
    "[vx, vy, vz, wx, wy, wz]": "[0, 0, 0, 0, 0, 0]",
    '"twist": [...]': '"twist": [0, 0, 0, 0, 0, 0]',
    '"frame": ...': '"frame": "tool"',
    "[x, y, z]": "[0.5, 0, 0.5]",
    "[w, x, y, z]": "[1, 0, 0, 0]",
    '"pose": ...': '"pose": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]',
}


def test_the_client_moves_the_arm(rover):
    with UdpSource(rover) as source:
        program = compile(CLIENT.replace("9870", str(source.address[1])), "docs/streaming.md", "exec")
        joints = SimulatedJoints(rover, rover.ready)
        client = threading.Thread(target=lambda: exec(program, {}))
        client.start()
        run(rover, source, joints, joints, duration=0.6)
        client.join()
    assert rover.fk(joints.theta)[2, 3] > rover.fk(rover.ready)[2, 3] + 0.005


def test_what_another_program_signs_is_taken():
    names = {}
    exec(compile(SIGNED, "docs/streaming.md", "exec"), names)
    key = names["key"]
    verifier = Verifier(key)
    assert verifier.verified(names["signed"](b"{}")) == b"{}"


def test_every_command_of_the_table_is_one(rover):
    table = PAGE[PAGE.index("Commands, to") : PAGE.index("Each may have")]
    messages = re.findall(r"^\| `(\{.*?\})` \|", table, flags=re.M)
    words = [message for message in messages if "interlock" in message]
    assert (len(messages), len(words)) == (11, 4)
    for message in messages:
        for gap, filled in GAPS.items():
            message = message.replace(gap, filled)
        if message not in words:
            parse_command(rover, message)
        else:
            assert obey_interlock_message(Interlock(), message.encode(), True)
