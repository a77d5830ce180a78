"""Datagrams on loopback: what arrives, who sent it, floods, lost receivers, and signatures; docs/streaming.md."""

import json
import os
import re
import socket
import statistics
import threading
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from stream_stand_ins import FakeClock, Robot, Says, answer, jog
from twistarm.control.stream import (
    Ending,
    Interlock,
    Setpoint,
    Signer,
    SimulatedJoints,
    StateInbox,
    UdpFeedback,
    UdpSink,
    UdpSource,
    Verifier,
    parse_command,
    read_key,
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
    count = sum(1 for _ in source.waiting())
    assert 0 < count <= MOST_PER_CYCLE
    assert next(source.waiting(), None) is None
    assert time.perf_counter() - began < 0.1
    send(client, JOG, source)
    assert source.read(0.1).command is not None


@pytest.mark.slow
@pytest.mark.parametrize(
    "datagram", [b"[" * 60_000, b'{"theta":[' + b"0," * 30_000 + b"0]}", b'{"theta":[1' + b"0" * 60_000 + b"]}"]
)
def test_a_cycle_stays_short_while_nonsense_floods_in(client, source, datagram):
    """At 100 Hz a cycle has 10 ms. What arrives may take half of them, in the processor's time."""
    spent = []
    for cycle in range(1, 11):
        for _ in range(200):
            with suppress(OSError):
                client.sendto(datagram, socket.MSG_DONTWAIT, source.address)
        began = time.thread_time()
        assert source.read(0.01 * cycle).command is None
        spent.append(time.thread_time() - began)
    assert statistics.median(spent) < 0.005


def test_joint_states_arrive_by_name(rover, client):
    with UdpFeedback(rover) as feedback:
        send(client, {"joint_names": rover.joint_names, "theta": [9] * 5}, feedback)  # of an unknown age
        unread = feedback.read(1.0)
        assert (unread.theta, unread.reason == StateInbox(rover).read(1.0).reason) == (None, False)
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


def test_what_another_program_signs_is_accepted():
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


# -- signatures -------------------------------------------------------------------------------------------------------

KEY = b"0123456789abcdef"
SECOND = 10**9


class Time:
    """Nanoseconds that tests move."""

    def __init__(self, now=1_700_000_000 * SECOND):
        self.now = now

    def __call__(self):
        return self.now

    def pass_by(self, seconds):
        self.now += round(seconds * SECOND)


@pytest.fixture
def clock():
    return Time()


@pytest.fixture
def pair(clock):
    """A verifier, and a signer a little later."""
    verifier = Verifier(KEY, clock)
    clock.pass_by(0.1)
    return verifier, Signer(KEY, clock)


def test_each_datagram_counts_once_in_order_and_in_time(clock, pair):
    verifier, signer = pair
    first, second, third = (signer.sign(b"{}") for _ in range(3))
    assert verifier.verified(second) == b"{}"
    for replayed in (first, second):
        with pytest.raises(InputError, match="here before"):
            verifier.verified(replayed)
    clock.pass_by(2.1)
    with pytest.raises(InputError, match=r"-2.1 s"):
        verifier.verified(third)


def test_a_restart_of_the_sender_or_its_clock_does_not_lock_it_out(clock, pair):
    verifier, _ = pair
    assert verifier.verified(Signer(KEY, Time(clock.now + 1 * SECOND)).sign(b"1"))
    assert verifier.verified(Signer(KEY, clock).sign(b"2"))  # anew, with its clock set back
    with pytest.raises(InputError, match="set both clocks"):
        verifier.verified(Signer(KEY, Time(clock.now + 3600 * SECOND)).sign(b"3"))
    assert verifier.verified(Signer(KEY, clock).sign(b"4"))


def test_replayed_messages_never_count_after_a_restart(clock, pair):
    verifier, signer = pair
    recorded = signer.sign(b"{}")
    verifier.verified(recorded)
    clock.pass_by(0.5)
    with pytest.raises(InputError, match="older than this program"):
        Verifier(KEY, clock).verified(recorded)
    clock.pass_by(10.0)
    verifier.verified(Signer(KEY, clock).sign(b"{}"))
    clock.pass_by(-10.4)
    with pytest.raises(InputError, match="older than this program"):
        verifier.verified(recorded)


def forgeries(signed):
    session, counter, mac, text = signed.split(b" ", 3)
    yield "no signature", text
    yield "another text", b" ".join((session, counter, mac, text + b" "))
    yield "another counter", b" ".join((session, b"%d" % (int(counter) + 1), mac, text))
    yield "another session", b" ".join((b"f" * 16, counter, mac, text))
    yield "a signature of words", b" ".join((session, counter, b"\xff" * 64, text))
    yield "a counter without end", b" ".join((session, b"9" * 5000, mac, text))


def test_forgeries_are_refused(clock, pair):
    verifier, signer = pair
    signed = signer.sign(json.dumps(JOG).encode())
    for what, forged in (*forgeries(signed), ("another key", Signer(b"x" * 16, clock).sign(b"{}"))):
        with pytest.raises(InputError, match="not signed|signature is wrong"):
            pytest.fail(f"{what}: {verifier.verified(forged)!r}")
    assert verifier.verified(signed)


def test_strangers_move_nothing_stop_nothing_and_are_counted(rover, client):
    """The signed command holds while unsigned ones, an emergency stop among them, are left out."""
    with UdpSource(rover, key=KEY) as source:
        source.read(0.0)
        signed = Signer(KEY).sign(json.dumps(JOG).encode())
        for datagram in (signed, b'{"interlock": "emergency stop"}', b"nonsense", signed):
            client.sendto(datagram, source.address)
        assert source.read(0.1).command.theta_dot[2] == -0.3
        assert source.interlock.allows_motion
        client.sendto(Signer(KEY).sign(b'{"interlock": "emergency stop"}'), source.address)
        reading = source.read(0.4)
        assert source.interlock.word == "emergency stop"
        assert reading.command is None
        assert "3 datagrams" in reading.reason
        assert "here before" in reading.reason


@pytest.mark.parametrize(("senders", "counts"), [(["localhost"], True), (["192.0.2.7"], False)])
def test_hosts_that_may_send(rover, client, senders, counts):
    with UdpSource(rover, senders=senders) as source:
        source.read(0.0)
        client.sendto(json.dumps(JOG).encode(), source.address)
        reading = source.read(0.1)
        assert (reading.command is not None) is counts
        assert counts or "not an allowed sender" in reading.reason


def test_setpoints_and_joint_states_are_signed_by_the_same_key(rover, client):
    verifier, still = Verifier(KEY), np.zeros(5)
    client.bind(("127.0.0.1", 0))
    client.settimeout(1.0)
    with UdpSink(rover, *client.getsockname(), key=KEY) as sink:
        sink.write(Setpoint(0, 1.0, still, still, answer(still)))
        assert json.loads(verifier.verified(client.recv(65536)))["theta"] == [0.0] * 5
    state = json.dumps({"joint_names": list(rover.joint_names), "theta": [0.0] * 5}).encode()
    with UdpFeedback(rover, key=KEY) as feedback:
        feedback.read(0.0)
        client.sendto(Signer(KEY).sign(state), feedback.address)
        assert feedback.read(0.1).theta is not None
        client.sendto(state, feedback.address)
        assert "it is not signed" in feedback.read(0.5).reason


def test_a_key_is_read_from_a_file(tmp_path):
    path = tmp_path / "key"
    path.write_bytes(KEY + b"\n")
    assert read_key(path) == KEY
    os.mkfifo(tmp_path / "fifo")
    for content, name in ((b"short", "key"), (b"x" * 2000, "key"), (b"", "none"), (b"", "fifo")):
        path.write_bytes(content)
        with pytest.raises(InputError, match="key"):
            read_key(tmp_path / name)


@pytest.mark.parametrize(
    ("options", "culprit"),
    [
        ({"senders": ["no..host"]}, r"'no\.\.host'"),
        ({"senders": "127.0.0.1"}, "senders"),
        *(({"key": key}, "a key is") for key in ("0123456789abcdef", b"", b"short")),
    ],
)
def test_what_is_no_host_and_no_key_is_refused(rover, options, culprit):
    with pytest.raises(InputError, match=culprit):
        UdpSource(rover, **options)
