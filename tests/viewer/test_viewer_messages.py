"""Messages of the pages: what they move, random and refused joints, and nonsense that gets its reason."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import schema_samples as samples
from recorded_poses import ask, done
from twistarm import Arm, ArmBuilder, load_arm
from twistarm.control.servo import ServoOutput
from twistarm.support.errors import InputError, LimitError
from twistarm.support.strict_json import encode
from twistarm.viewer import Viewer
from twistarm.viewer.messages import SCHEMA, failure, parse
from twistarm.viewer.parts.arm_data import tool_path
from twistarm.viewer.parts.custom import Draw
from twistarm.viewer.scene.arm_drawing import Drawing
from twistarm.viewer.server.driver import servo_words
from twistarm.viewer.stage import Stage
from viewer_page import THETA, Page, visit

BAD_MESSAGES: list[tuple[Any, str]] = [
    ("{", "JSON"),
    ('{"type": "play", "type": "pause"}', "once"),
    ("[" * 30_000, "JSON"),
    (b"\x00\xff", "bytes"),
    ('{"type": "explode"}', "'explode'"),
    ('{"type": "theta", "theta": [NaN, 0, 0]}', "NaN"),
    (f'{{"type": "theta", "theta": [1{"0" * 5000}, 0, 0]}}', "digits"),
    ('{"type": "theta", "theta": [0, 0]}', "yaw, pitch, slide; got (2,)"),
    ('{"type": "theta", "theta": [0, 2, 0]}', "pitch = 114.592°"),
    ('{"type": "joint", "name": "finger", "value": 1}', "0.01 … 0.04"),
    ('{"type": "joint", "name": "pich", "value": 0}', "closest: 'pitch'"),
    ('{"type": "pose", "name": "redy", "ease": true}', "closest: 'ready'"),
    ('{"type": "pose", "name": "\\ud800", "ease": true}', "no configuration"),
    ('{"type": "play"}', "play"),
]


def test_a_bad_message_gets_its_reason_and_the_server_lives_on(viewer: Viewer) -> None:
    with Page(viewer) as page:
        for text, reason in BAD_MESSAGES:
            page.send(text)
            page.until(lambda: "error" in page.latest)
            assert reason in page.latest["error"]["message"], text[:60]
            assert page.latest["frame"]["theta"] == list(THETA)
        page.ask(type="joint", name="pitch", value=0.5)
        page.until(lambda: page.latest["frame"]["theta"][1] == 0.5)


def test_a_message_too_long_closes_that_page_only(viewer: Viewer) -> None:
    with Page(viewer) as page:
        page.send(" " * 100_000)
        page.until_closed()  # what the process told before may come first
        assert page.connection.close_code == 1009  # message too big
    assert "hello" in visit(viewer).latest


@pytest.mark.parametrize("kind", SCHEMA["requests"])
def test_requests_are_taken_in_the_schema_s_shape_alone(kind: str) -> None:
    good = samples.request(kind)
    request = parse(json.dumps({**good, "number": 5}))
    assert (request.kind, request.number, set(request.fields)) == (kind, 5, set(good) - {"type"})
    for text in samples.spoilt(kind):
        with pytest.raises(InputError) as refused:
            parse(text)
        reason = str(refused.value)
        assert reason, text[:80]
        assert "\n" not in reason
        assert len(reason) < 700


def test_a_page_moves_the_arm_and_python_and_other_pages_see_it(arm: Arm, viewer: Viewer) -> None:
    with Page(viewer) as page:
        other = page.other()
        page.ask(type="theta", theta=[0.1, 0.2, 0.05])
        page.ask(type="joint", name="finger", value=0.03)
        other.until(lambda: other.latest["frame"]["others"] == {"finger": 0.03})
        assert other.latest["frame"]["theta"] == [0.1, 0.2, 0.05]
        other.close()
    assert_array_equal(viewer.theta, [0.1, 0.2, 0.05])


def told(arm: Arm) -> Iterator[dict[str, Any]]:
    """Whatever the process says, with everything on show that can be."""
    stage = Stage(arm, THETA)
    yield from (stage.hello({}), Drawing(arm).message(), failure(InputError("no")))
    yield {"type": "notice", "words": "loaded again", "wrong": False}
    yield from ({"type": "done", "number": 1}, {"type": "work", "jobs": [{"key": "plan", "share": 0.5}]})
    yield from stage.messages()
    stage.needed = frozenset({"collision", "reach"})
    done(stage.reach.due(stage))
    done(stage.collisions.due(stage))
    for name, theta in (("a", THETA), ("b", (0.0, 0.1, 0.05))):
        done(ask(stage, "theta", theta=list(theta)))
        done(ask(stage, "record", name=name))
        yield from stage.messages()
    done(ask(stage, "plan", kind="s_curve", stop=True))
    stage.draw_path(tool_path(arm, [THETA, (0.0, 0.1, 0.05)]))
    yield from stage.messages()
    stage.take_commands()
    stage.set_servo_status(servo_words(ServoOutput.stale(np.zeros(3), "the link is lost")))
    Draw(lambda drawn: stage.drawings.update({drawn["node"]: drawn})).text("note", "here", [0, 0, 1])
    yield from stage.messages()


def test_whatever_the_process_says_keeps_to_the_schema(arm: Arm) -> None:
    said = list(told(arm))
    assert [reason for reason in map(samples.complaint, said) if reason] == []
    for message in said:
        assert json.loads(encode(message)) == message
    assert {message["type"] for message in said} == set(SCHEMA["messages"])


ROVER = load_arm("rover_arm")  # its roll has no limits


def test_random_configurations_are_inside_the_limits_and_leave_joints_beside_the_arm_alone() -> None:
    stage, drawn = Stage(ROVER), []
    ask(stage, "joint", name="finger_left", value=0.02)
    for _ in range(200):
        ask(stage, "random", ease=False)
        drawn.append(stage.theta)
    lower, upper = np.clip([ROVER.limits.lower, ROVER.limits.upper], -np.pi, np.pi)
    share = (np.array(drawn) - lower) / (upper - lower)
    assert np.all((share >= 0.0) & (share <= 1.0))
    assert len(np.unique(drawn, axis=0)) == 200
    # Of 200 even draws, none in one of the tenths at the ends: less than 1 in 10^8 for each joint.
    assert np.all(share.min(axis=0) < 0.1)
    assert np.all(share.max(axis=0) > 0.9)
    assert stage.others["finger_left"] == 0.02


PAIR = (
    ArmBuilder("pair")
    .revolute("turn", [0, 0, 1], [0, 0, 0], lower=-1.5, upper=1.5)
    .prismatic("slide", [1, 0, 0], lower=-0.2, upper=0.2)
    .tool(np.eye(4))
    .build()
)


@pytest.mark.parametrize("beyond", [1e-4, 2e-6])
@pytest.mark.parametrize(("name", "limit"), [("turn", 1.5), ("turn", -1.5), ("slide", 0.2), ("slide", -0.2)])
def test_a_little_beyond_a_limit_is_refused(name: str, limit: float, beyond: float) -> None:
    stage, value = Stage(PAIR), limit * (1 + beyond / abs(limit))
    with pytest.raises(LimitError, match=f"{name} = .* is outside its limits"):
        ask(stage, "joint", name=name, value=value)
    with pytest.raises(LimitError, match=f"{name} = .* is outside its limits"):
        ask(stage, "theta", theta=[value if joint == name else 0.0 for joint in PAIR.joint_names])
    assert_array_equal(stage.theta, PAIR.ready)
