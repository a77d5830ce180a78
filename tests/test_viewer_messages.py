"""Messages of the pages: what they move, and nonsense that gets its reason."""

from __future__ import annotations

from typing import Any

from numpy.testing import assert_array_equal

from twistarm import Arm
from twistarm.viewer import Viewer
from twistarm.viewer.messages import SCHEMA, parse
from twistarm.viewer.stage import Stage
from viewer_page import THETA, Page, matrix, nothing, visit
from viewer_page import arm as arm
from viewer_page import viewer as viewer

BAD_MESSAGES: list[tuple[Any, str]] = [
    ("", "a message is one JSON object"),
    ("{", "a message is one JSON object"),
    ("[1, 2]", "a message is one JSON object; got"),
    ('{"type": "play", "type": "pause"}', "a message has each name once"),
    ("[" * 30_000, "a message is one JSON object"),
    (b"\x00\xff", "JSON text; got bytes"),
    ("{}", "unknown message type None; one of theta, joint"),
    ('{"type": "explode"}', "unknown message type 'explode'"),
    ('{"type": ["theta"]}', "unknown message type"),
    ('{"type": "theta"}', "theta needs theta; got []"),
    ('{"type": "play", "extra": 1}', "play needs no fields; got ['extra']"),
    ('{"type": "play", "number": -1}', "number must be a whole number"),
    ('{"type": "theta", "theta": 3}', "theta must be a list of numbers"),
    ('{"type": "theta", "theta": [0, 0]}', "theta must have shape (..., 3): yaw, pitch, slide; got (2,)"),
    ('{"type": "theta", "theta": [0, 0, "x"]}', "theta[2] must be a number; got 'x'"),
    ('{"type": "theta", "theta": [0, 0, true]}', "theta[2] must be a number"),
    ('{"type": "theta", "theta": [NaN, 0, 0]}', "numbers must be finite; got NaN"),
    ('{"type": "theta", "theta": [0, -Infinity, 0]}', "numbers must be finite; got -Infinity"),
    ('{"type": "theta", "theta": [1e999, 0, 0]}', "theta[0] must be finite and at most 1e+06"),
    (f'{{"type": "theta", "theta": [1{"0" * 400}, 0, 0]}}', "theta[0] must be finite and at most 1e+06"),
    (f'{{"type": "theta", "theta": [1{"0" * 5000}, 0, 0]}}', "a message is one JSON object"),
    ('{"type": "theta", "theta": [0, 2, 0]}', "pitch = 2 is outside its limits -1.5 … 1.5"),
    ('{"type": "joint", "name": "pitch", "value": 1.6}', "pitch = 1.6 is outside its limits"),
    ('{"type": "joint", "name": "finger", "value": 1}', "finger = 1 is outside its limits 0.01 … 0.04"),
    ('{"type": "joint", "name": "follower", "value": 0}', "no joint 'follower' in small"),
    ('{"type": "joint", "name": "pich", "value": 0}', "no joint 'pich' in small; closest: 'pitch'"),
    ('{"type": "joint", "name": 3, "value": 0}', "name must be text; got 3"),
    ('{"type": "pose", "name": "redy"}', "no pose 'redy' in small; closest: 'ready'"),
    ('{"type": "pose", "name": "\\ud800"}', "no pose"),
    ('{"type": "play"}', "nothing to play: no trajectory is loaded"),
    ('{"type": "seek", "time": 1}', "nothing to seek: no trajectory is loaded"),
    ('{"type": "visible", "what": "screws", "visible": 1}', "visible must be true or false"),
    ('{"type": "visible", "what": "grid", "visible": true}', "no layer 'grid'"),
]


def test_a_bad_message_gets_its_reason_and_the_server_lives_on(viewer: Viewer) -> None:
    async def misbehave(page: Page) -> None:
        for text, reason in BAD_MESSAGES:
            await page.send(text)
            await page.until(lambda: "error" in page.latest)
            assert reason in page.latest["error"]["message"], text[:60]
            assert page.latest["frame"]["theta"] == list(THETA)
        await page.ask(type="joint", name="pitch", value=0.5)
        await page.until(lambda: page.latest["frame"]["theta"][1] == 0.5)

    visit(viewer, misbehave)


def test_a_message_too_long_closes_that_page_only(viewer: Viewer) -> None:
    async def shout(page: Page) -> None:
        await page.send(" " * 100_000)
        assert await page.connection.read_message() is None

    visit(viewer, shout)
    assert "hello" in visit(viewer, nothing).latest


def test_ten_thousand_messages_of_rubbish(viewer: Viewer) -> None:
    async def flood(page: Page) -> None:
        for i in range(10_000):
            await page.connection.write_message(BAD_MESSAGES[i % 3][0] + str(i))
        await page.ask(type="pose", name="zero")
        await page.until(lambda: page.latest["frame"]["theta"] == [0, 0, 0])

    visit(viewer, flood)


def test_a_page_moves_the_arm_and_python_and_other_pages_see_it(arm: Arm, viewer: Viewer) -> None:
    async def move(page: Page) -> None:
        other = await Page(page.address, {}).open()
        await page.ask(type="theta", theta=[0.1, 0.2, 0.05])
        await page.ask(type="joint", name="finger", value=0.03)
        await other.until(lambda: other.latest["frame"]["others"] == {"finger": 0.03})
        path = other.latest["hello"]["links"]["right"]
        expected = arm.poses([0.1, 0.2, 0.05], {"finger": 0.03})["right"]
        assert_array_equal(matrix(other.latest["frame"]["transforms"][path]), expected)
        await page.ask(type="visible", what="screws", visible=False)
        await other.until(lambda: not other.latest["visible"]["screws"])
        other.connection.close()

    visit(viewer, move)
    assert_array_equal(viewer.theta, [0.1, 0.2, 0.05])


def test_a_request_and_its_number() -> None:
    request = parse('{"type": "seek", "time": 2, "number": 3}')
    assert (request.kind, request.fields, request.number) == ("seek", {"time": 2.0}, 3)


def test_whatever_the_process_says_keeps_to_the_schema(arm: Arm) -> None:
    stage = Stage(arm, THETA)
    said = [
        stage.hello({}) | {"objects": 0, "notes": []},
        {"type": "done", "number": 1},
        {"type": "error", "message": ""},
    ]
    for message in [*said, {"type": "work", "jobs": []}, *stage.messages()]:
        assert set(message) - {"type"} == set(SCHEMA["messages"][message["type"]])
    assert {message["type"] for message in stage.messages()} <= set(SCHEMA["messages"])
