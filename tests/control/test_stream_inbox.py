"""One commander at a time, for a short while, the latest message of it; everything else is said."""

import tracemalloc

import numpy as np
import pytest

from twistarm.control.servo import JogCommand, TwistCommand
from twistarm.control.stream import Inbox, MonotonicClock, StateInbox
from twistarm.support.errors import InputError

A, B = JogCommand(np.array([0.1])), JogCommand(np.array([0.2]))
TIMEOUT = 0.2
PAD = "127.0.0.1:5005"

# What is put (sender, command, time, number), a number alone being a look; then a look and what it finds.
CASES = {
    "nothing": ([], 5.0, None, "no command has arrived"),
    "the latest": ([("page", A, 1.0), ("page", B, 1.05)], 1.1, B, ""),
    "it holds": ([("page", A, 1.0)], 1.199, A, ""),
    "until it is old": ([("page", A, 1.0)], 1.35, None, "0.35 s old"),
    "repeated": ([("page", A, 1.0), 1.35, ("page", A, 1.4)], 1.4, A, ""),
    "two": ([("page", A, 1.0), (PAD, B, 1.1)], 1.1, None, f"two senders of a command, page and {PAD}"),
    "still two": ([("page", A, 1.0), (PAD, B, 1.1), (PAD, B, 1.19)], 1.19, None, "two senders"),
    "one fell silent": ([("page", A, 1.0), (PAD, B, 1.1), (PAD, B, 1.21)], 1.21, B, ""),
    "an older number": ([("page", B, 1.0, 7), ("page", A, 1.1, 6)], 1.15, B, ""),
    "the same number": ([("page", B, 1.0, 7), ("page", A, 1.1, 7)], 1.3, None, "0.3 s old"),
    "counted anew at once": ([("page", A, 1.0, 700), ("page", B, 1.1, 0)], 1.1, A, ""),
    "counted anew after a silence": ([("page", A, 1.0, 700), ("page", B, 1.25, 3)], 1.25, B, ""),
    "an older number put late": ([("page", A, 1.0, 8), ("page", B, 0.97, 7)], 1.01, A, ""),
    "a stranger put late": ([("page", A, 1.0), 1.01, ("pad", B, 0.97)], 1.02, None, "page and pad"),
    "as old as its stamp, put late": ([("page", A, 1.0), 1.1, ("page", B, 0.95)], 1.149, B, ""),
    "and no younger": ([("page", A, 1.0), 1.1, ("page", B, 0.95)], 1.151, None, "the last command is 0.201 s old"),
    "a stamp ahead": ([("page", A, 31.0)], 1.0, None, "the last command is -30 s old"),
    "a stamp a little ahead": ([("page", A, 1.05)], 1.0, A, ""),
    "put a timeout late": ([5.0, ("page", A, 4.7)], 5.0, None, "the last command is 0.3 s old"),
    "the reader's time went back": ([("page", A, 10.0), 10.05], 7.05, None, "the last command is -2.95 s old"),
    "and on": ([("page", A, 10.0, 5), 10.05, 7.05, ("page", B, 7.1, 2)], 7.1, B, ""),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_what_counts(case):
    steps, now, command, reason = CASES[case]
    inbox = Inbox(TIMEOUT)
    for step in steps:
        inbox.read(step) if isinstance(step, float) else inbox.put(*step)
    reading = inbox.read(now)
    assert reading.command is command
    assert reason in reading.reason
    assert bool(reason) == (command is None)


def test_a_command_is_six_numbers_too_and_arrives_now():
    inbox = Inbox(10.0)
    inbox.put("joystick", [0.0, 0.0, 0.05, 0.0, 0.0, 0.0])
    reading = inbox.read(MonotonicClock().now())
    assert isinstance(reading.command, TwistCommand)
    assert 0.0 <= reading.age < 10.0
    for given, culprit in ((("joystick", "up"), "TwistCommand"), ((A, A, 1.0), "sender")):
        with pytest.raises(InputError, match=culprit):
            inbox.put(*given)
    for timeout in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(InputError, match="timeout"):
            Inbox(timeout)


def test_nonsense_stops_what_was_commanded_in_a_short_line():
    inbox = Inbox(TIMEOUT)
    inbox.put("page", A, 1.0)
    inbox.refuse("page", "twist must be finite", 1.01)
    reading = inbox.read(1.02)
    assert reading.command is None
    assert "twist must be finite" in reading.reason
    inbox.refuse("x\n" * 5000, "why", 1.5)
    reason = inbox.read(1.5).reason
    assert len(reason) < 200
    assert "\n" not in reason


def test_a_flood_takes_no_memory():
    inbox = Inbox(TIMEOUT)
    tracemalloc.start()
    try:
        for k in range(1000):
            inbox.put(f"sender {k}", A, 1.0 + 1e-6 * k)
        before = tracemalloc.get_traced_memory()[0]
        for k in range(5000):
            inbox.put(f"sender {k}", A, 1.1 + 1e-6 * k, number=k)
        after = tracemalloc.get_traced_memory()[0]
    finally:
        tracemalloc.stop()
    assert after - before < 2000


NAMES = ("slide", "shoulder", "elbow", "wrist_pitch", "wrist_roll")
WHOLE = dict(zip(NAMES, [1.0, 2.0, 3.0, 4.0, 5.0], strict=True))


@pytest.fixture
def states(rover):
    return StateInbox(rover, 0.2)


def test_a_joint_state_is_as_old_as_its_arrival(states):
    assert states.read(1.0).theta is None
    states.put("robot", np.arange(5.0), 1.0)
    measured = states.read(1.1)
    assert measured.theta.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert measured.time == pytest.approx(1.0)
    assert "0.5 s old" in states.read(1.5).reason


def test_parts_are_merged_and_as_old_as_the_oldest(states):
    states.put("one bus", {"elbow": 3.0, "slide": 1.0, "fan": 7.0}, 1.0)
    states.put("another", {"shoulder": 2.0, "wrist_pitch": 4.0}, 1.05)
    states.put("wheels", {"left_wheel": 1.0, "wrist_rol": np.nan}, 1.06)
    reason = states.read(1.1).reason
    assert "(wrist_roll)" in reason
    assert reason.endswith("'wrist_rol'")
    states.put("a third", {"wrist_roll": 5.0}, 1.15)
    measured = states.read(1.19)
    assert measured.theta.tolist() == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert measured.time == pytest.approx(1.0)
    assert states.read(1.22).reason.endswith("(slide, elbow)")
    states.put("one bus", {"slide": 1.5}, 1.23)
    states.put("one bus", {"elbow": 3.5}, 1.23)
    assert states.read(1.24).theta.tolist() == [1.5, 2.0, 3.5, 4.0, 5.0]


@pytest.mark.parametrize(
    ("say", "why"),
    [
        (lambda s: s.put("b", {"elbow": 9.0}, 1.0), "a and b"),
        (lambda s: s.put("a", {"elbow": np.nan}, 1.0), "elbow"),
        (lambda s: s.put("a", [1.0, 2.0], 1.0), "shape"),
        (lambda s: s.refuse("a", "twice: 'elbow'", 1.0), "twice"),
        (lambda s: s.read(0.5), "-0.5"),
    ],
)
def test_nonsense_a_rival_and_time_that_goes_back_leave_no_joint_state(states, say, why):
    states.put("a", WHOLE, 1.0)
    assert states.read(1.0).theta is not None
    say(states)
    measured = states.read(1.01 if "-0.5" not in why else 0.5)
    assert measured.theta is None
    assert why in measured.reason


def test_numbers_are_counted_by_joint(states):
    states.put("a", WHOLE, 1.0, number=4)
    states.put("a", {"elbow": 8.0}, 1.01, number=6)
    states.put("a", {"slide": 8.0}, 1.02, number=5)
    states.put("a", {"elbow": 9.0}, 1.03, number=5)
    assert states.read(1.05).theta.tolist() == [8.0, 2.0, 8.0, 4.0, 5.0]
