"""One commander at a time, for a short while, the latest message of it; everything else is said."""

from __future__ import annotations

import threading
import tracemalloc

import numpy as np
import pytest

from twistarm.control.servo import JogCommand, TwistCommand
from twistarm.control.stream import Inbox, MonotonicClock
from twistarm.support.errors import InputError

A, B = JogCommand(np.array([0.1])), JogCommand(np.array([0.2]))


def test_nothing_has_arrived():
    reading = Inbox().read(5.0)
    assert reading.command is None
    assert reading.age == np.inf
    assert reading.reason == "no command has arrived"


def test_the_latest_counts():
    inbox = Inbox(0.2)
    inbox.put("page", A, 1.0)
    inbox.put("page", B, 1.05)
    reading = inbox.read(1.1)
    assert reading.command is B
    assert reading.age == pytest.approx(0.05)
    assert reading.reason == ""


def test_a_command_without_a_time_arrives_now():
    inbox = Inbox(10.0)
    inbox.put("joystick", [0.0, 0.0, 0.05, 0.0, 0.0, 0.0])
    reading = inbox.read(MonotonicClock().now())
    assert isinstance(reading.command, TwistCommand)
    assert 0.0 <= reading.age < 10.0


def test_what_is_no_command_is_refused_where_it_is_put():
    with pytest.raises(InputError, match="a command is a TwistCommand"):
        Inbox().put("joystick", "up")
    with pytest.raises(InputError, match="sender must be"):
        Inbox().put(A, A, 1.0)


def test_a_command_must_be_repeated():
    inbox = Inbox(0.2)
    inbox.put("page", A, 1.0)
    assert inbox.read(1.199).command is A
    reading = inbox.read(1.35)
    assert reading.command is None
    assert reading.reason == "the last command is 0.35 s old (timeout 0.2 s)"
    inbox.put("page", A, 1.4)
    assert inbox.read(1.4).command is A


def test_two_commanders_are_none_until_one_has_been_silent_for_a_timeout():
    inbox = Inbox(0.2)
    inbox.put("page", A, 1.0)
    inbox.put("127.0.0.1:5005", B, 1.1)
    reading = inbox.read(1.1)
    assert reading.command is None
    assert "page and 127.0.0.1:5005" in reading.reason
    inbox.put("127.0.0.1:5005", B, 1.19)
    assert inbox.read(1.19).command is None
    inbox.put("127.0.0.1:5005", B, 1.21)
    assert inbox.read(1.21).command is B


def test_commanders_in_turn_never_move_the_arm():
    inbox = Inbox(0.2)
    inbox.put("one", A, 1.0)
    for k in range(1, 50):
        inbox.put(("one", "two", "three")[k % 3], B, 1.0 + 0.05 * k)
        assert inbox.read(1.0 + 0.05 * k).command is None


def test_older_numbers_of_a_sender_are_left_out():
    inbox = Inbox(0.2)
    inbox.put("page", B, 1.0, number=7)
    inbox.put("page", A, 1.1, number=6)
    inbox.put("page", A, 1.1, number=7)
    assert inbox.read(1.15).command is B
    reading = inbox.read(1.3)
    assert reading.command is None
    assert "number 7 came after 7 and was left out" in reading.reason


def test_a_sender_that_starts_anew_may_count_anew_after_a_silence():
    inbox = Inbox(0.2)
    inbox.put("page", A, 1.0, number=700)
    inbox.put("page", B, 1.1, number=0)
    assert inbox.read(1.1).command is A
    inbox.put("page", B, 1.25, number=3)
    assert inbox.read(1.25).command is B


def test_nonsense_stops_what_was_commanded():
    inbox = Inbox(0.2)
    inbox.put("page", A, 1.0)
    inbox.refuse("page", "twist must be finite", 1.01)
    reading = inbox.read(1.02)
    assert reading.command is None
    assert reading.reason == "command from page refused: twist must be finite"


def test_a_reader_s_clock_that_goes_back_forgets_what_was_commanded():
    inbox = Inbox(0.2)
    inbox.put("page", A, 10.0)
    assert inbox.read(10.05).command is A
    reading = inbox.read(7.05)
    assert reading.command is None
    assert reading.reason == "time went back by 3 s; no command has arrived since"
    inbox.put("page", B, 7.1)
    assert inbox.read(7.1).command is B


@pytest.mark.parametrize("late", [0.001, 0.037, 0.15])
def test_what_is_put_late_is_as_old_as_its_stamp(late):
    inbox = Inbox(0.2)
    inbox.put("page", A, 1.0)
    assert inbox.read(1.1).command is A  # the loop, while the page's thread waits for its turn
    inbox.put("page", B, 1.1 - late)
    reading = inbox.read(1.1)
    assert reading.command is B
    assert reading.age == pytest.approx(late)
    assert inbox.read(1.3 - late + 1e-6).reason.startswith("the last command is 0.2 s old")


def test_what_is_put_a_timeout_late_is_too_old():
    inbox = Inbox(0.2)
    assert inbox.read(5.0).command is None
    inbox.put("page", A, 4.7)
    assert inbox.read(5.0).reason == "the last command is 0.3 s old (timeout 0.2 s)"


def test_late_numbers_are_left_out_and_a_stranger_is_a_second_one():
    inbox = Inbox(0.2)
    inbox.put("page", A, 1.0, number=8)
    inbox.put("page", B, 0.97, number=7)
    assert inbox.read(1.01).command is A
    inbox.put("pad", B, 0.97)
    assert "page and pad" in inbox.read(1.02).reason


@pytest.mark.parametrize("ahead", [0.001, 0.05, 30.0])
def test_a_stamp_ahead_of_the_reader_ages_from_the_first_look(ahead):
    inbox = Inbox(0.2)
    inbox.put("page", A, 1.0 + ahead)
    reading = inbox.read(1.0)
    assert reading.command is A
    assert reading.age == 0.0
    assert inbox.read(1.19).command is A
    assert inbox.read(1.21).command is None


def test_a_flood_takes_no_memory():
    inbox = Inbox(0.2)
    tracemalloc.start()
    try:
        for k in range(1000):
            inbox.put(f"sender {k}", A, 1.0 + 1e-6 * k)
        before = tracemalloc.get_traced_memory()[0]
        for k in range(20_000):
            inbox.put(f"sender {k}", A, 1.1 + 1e-6 * k, number=k)
        after = tracemalloc.get_traced_memory()[0]
    finally:
        tracemalloc.stop()
    assert after - before < 2000
    assert inbox.read(1.12).command is None


def test_many_threads_at_once():
    inbox = Inbox(0.2)
    threads = [
        threading.Thread(target=lambda name=name: [inbox.put(name, A, 1.0) for _ in range(500)]) for name in "ab"
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert "two senders" in inbox.read(1.0).reason


def test_long_names_stay_readable():
    inbox = Inbox()
    inbox.refuse("x\n" * 5000, "why", 1.0)
    assert len(inbox.read(1.0).reason) < 200
    assert "\n" not in inbox.read(1.0).reason


@pytest.mark.parametrize("timeout", [0.0, -1.0, float("nan"), float("inf")])
def test_a_timeout_is_a_positive_number(timeout):
    with pytest.raises(InputError, match="timeout of a command must be a positive number"):
        Inbox(timeout)
