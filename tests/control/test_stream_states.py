"""Joint states that come in parts: merged by name and age, each joint by the rules of one sender."""

from __future__ import annotations

import numpy as np
import pytest

from twistarm.control.stream import StateInbox

NAMES = ("slide", "shoulder", "elbow", "wrist_pitch", "wrist_roll")
WHOLE = dict(zip(NAMES, [1.0, 2.0, 3.0, 4.0, 5.0], strict=True))


@pytest.fixture
def states(rover):
    return StateInbox(rover, 0.2)


def test_a_joint_state_is_as_old_as_its_arrival(states):
    assert states.read(1.0).reason == "no joint state has arrived"
    states.put("robot", np.arange(5.0), 1.0)
    measured = states.read(1.1)
    assert measured.theta.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert measured.time == pytest.approx(1.0)
    assert states.read(1.5).reason == "the last joint state is 0.5 s old (timeout 0.2 s)"


def test_parts_are_merged_and_as_old_as_the_oldest(states):
    states.put("one bus", {"elbow": 3.0, "slide": 1.0, "fan": 7.0}, 1.0)
    states.put("another", {"shoulder": 2.0, "wrist_pitch": 4.0}, 1.05)
    states.put("wheels", {"left_wheel": 1.0, "wrist_rol": np.nan}, 1.06)
    assert states.read(1.1).reason == (
        "no joint state of wrist_roll has arrived; 1 messages told of others alone, "
        "the last of 'left_wheel', 'wrist_rol'; closest: 'wrist_rol'"
    )
    states.put("a third", {"wrist_roll": 5.0}, 1.15)
    measured = states.read(1.19)
    assert measured.theta.tolist() == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert measured.time == pytest.approx(1.0)
    assert states.read(1.22).reason == "the last joint state of slide, elbow is 0.22 s old (timeout 0.2 s)"
    states.put("one bus", {"slide": 1.5}, 1.23)
    states.put("one bus", {"elbow": 3.5}, 1.23)
    assert states.read(1.24).theta.tolist() == [1.5, 2.0, 3.5, 4.0, 5.0]


@pytest.mark.parametrize(
    ("say", "why"),
    [
        (lambda s: s.put("b", {"elbow": 9.0}, 1.0), "two senders of a joint state of elbow, a and b: stop one of them"),
        (lambda s: s.put("a", {"elbow": np.nan}, 1.0), "joint state from a refused: the joint state of elbow must be"),
        (lambda s: s.put("a", [1.0, 2.0], 1.0), "must have shape"),
        (lambda s: s.refuse("a", "twice: 'elbow'", 1.0), "joint state from a refused: twice"),
        (lambda s: s.read(0.5), "time went back by 0.5 s; no joint state has arrived since"),
    ],
)
def test_nonsense_a_rival_and_time_that_goes_back_leave_no_joint_state(states, say, why):
    states.put("a", WHOLE, 1.0)
    assert states.read(1.0).theta is not None
    say(states)
    measured = states.read(1.01 if "time" not in why else 0.5)
    assert measured.theta is None
    assert why in measured.reason


def test_numbers_are_counted_by_joint(states):
    states.put("a", WHOLE, 1.0, number=4)
    states.put("a", {"elbow": 8.0}, 1.01, number=6)
    states.put("a", {"slide": 8.0}, 1.02, number=5)
    states.put("a", {"elbow": 9.0}, 1.03, number=5)
    assert states.read(1.05).theta.tolist() == [8.0, 2.0, 8.0, 4.0, 5.0]
