"""Whose datagrams count: allowed hosts, and a key whose signatures hold once and in time."""

from __future__ import annotations

import hashlib
import hmac
import json
import os
import socket

import numpy as np
import pytest

from stream_stand_ins import answer
from twistarm.control.stream import Setpoint, Signer, UdpFeedback, UdpSink, UdpSource, Verifier, read_key
from twistarm.support.errors import InputError

KEY = b"0123456789abcdef"
JOG = {"jog": {"elbow": -0.3}}
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
def time():
    return Time()


def test_a_signature_is_hmac_sha256_as_another_would_compute_it(time):
    session, counter, mac, text = Signer(KEY, time).sign(b'{"stop": true}').split(b" ", 3)
    expected = hmac.new(KEY, session + b" " + counter + b" " + text, hashlib.sha256).hexdigest()
    assert (mac.decode(), text, int(counter)) == (expected, b'{"stop": true}', time.now)


def test_each_datagram_counts_once_in_order_and_in_time(time):
    verifier, signer = Verifier(KEY, time), Signer(KEY, time)
    time.pass_by(0.1)
    first, second = signer.sign(b"{}"), signer.sign(b"{}")
    assert verifier.verified(second) == b"{}"
    for replayed in (first, second):
        with pytest.raises(InputError, match="was here before, came after a later one"):
            verifier.verified(replayed)
    third = signer.sign(b"{}")
    time.pass_by(2.1)
    with pytest.raises(InputError, match=r"its time is -2.1 s from ours"):
        verifier.verified(third)


def test_a_restart_of_the_sender_or_its_clock_does_not_lock_it_out(time):
    verifier, ahead = Verifier(KEY, time), Time(time.now + 1 * SECOND)
    time.pass_by(0.1)
    assert verifier.verified(Signer(KEY, ahead).sign(b"1"))
    assert verifier.verified(Signer(KEY, time).sign(b"2"))  # anew, with its clock set back
    wrong = Signer(KEY, Time(time.now + 3600 * SECOND)).sign(b"3")
    with pytest.raises(InputError, match="set both clocks"):
        verifier.verified(wrong)
    assert verifier.verified(Signer(KEY, time).sign(b"4"))


def test_replayed_messages_never_count_after_a_restart(time):
    verifier, signer = Verifier(KEY, time), Signer(KEY, time)
    time.pass_by(1.0)
    recorded = signer.sign(b"{}")
    verifier.verified(recorded)
    time.pass_by(0.5)
    with pytest.raises(InputError, match="older than this program"):
        Verifier(KEY, time).verified(recorded)
    time.pass_by(10.0)
    verifier.verified(Signer(KEY, time).sign(b"{}"))
    time.pass_by(-10.4)
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


def test_forgeries_are_refused(time):
    verifier, signer = Verifier(KEY, time), Signer(KEY, time)
    time.pass_by(0.1)
    signed = signer.sign(json.dumps(JOG).encode())
    for what, forged in (*forgeries(signed), ("another key", Signer(b"x" * 16, time).sign(b"{}"))):
        with pytest.raises(InputError, match="not signed|signature is wrong"):
            pytest.fail(f"{what}: {verifier.verified(forged)!r}")
    assert verifier.verified(signed)


@pytest.fixture
def client():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        yield out


def test_strangers_move_nothing_stop_nothing_and_are_told_of(rover, client):
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
        assert "; 3 datagrams were left out, the last from 127.0.0.1:" in reading.reason
        assert reading.reason.endswith("it was here before, came after a later one, or is older than this program")


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
    for content in (b"short", b"x" * 2000):
        path.write_bytes(content)
        with pytest.raises(InputError, match="key"):
            read_key(path)
    with pytest.raises(InputError, match="cannot read the key"):
        read_key(tmp_path / "none")
    os.mkfifo(tmp_path / "fifo")
    with pytest.raises(InputError, match="cannot read the key"):
        read_key(tmp_path / "fifo")


def test_what_is_no_host_and_no_key_is_refused(rover):
    with pytest.raises(InputError, match=r"no such host among those that may send, 'no\.\.host'"):
        UdpSource(rover, senders=["no..host"])
    with pytest.raises(InputError, match="senders"):
        UdpSource(rover, senders="127.0.0.1")
    for key in ("0123456789abcdef", b"", b"short"):
        with pytest.raises(InputError, match="a key is 16 to 1024 bytes"):
            UdpSource(rover, key=key)
