from __future__ import annotations

import asyncio
import json
import re
import socket
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import umsgpack
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.websocket import websocket_connect

from twistarm import Arm, arm_from_screws, available_arms, joints, load_arm, poe
from twistarm.errors import DescriptionError, InputError, LimitError, MissingExtraError, UnknownNameError
from twistarm.limits import usual_half
from twistarm.planning.joint_space import plan_joint
from twistarm.planning.trajectory import Trajectory
from twistarm.viewer import Viewer, save_html
from twistarm.viewer.guard import Guard
from twistarm.viewer.links import load_meshes
from twistarm.viewer.meshes import load_parts, shaded
from twistarm.viewer.messages import parse
from twistarm.viewer.scene import build_scene, partial_products
from twistarm.viewer.stage import Stage
from twistarm.viewer.summary import _describe

ROUNDING = 1e-14
"""Two ways to the same pose of an arm of about 1 m, in double precision."""

SINGLE = 1e-5
"""Meshes are sent in single precision, and normals are unit vectors."""

WAIT = 10.0
"""Seconds until something that should happen at once counts as not happening."""

ARM = """<robot name="small">
  <material name="red"><color rgba="1 0 0 0.5"/></material>
  <link name="base_link"><visual><geometry><box size="0.2 0.2 0.1"/></geometry><material name="red"/></visual></link>
  <link name="upper"><visual><origin xyz="0 0 0.2"/><geometry><cylinder radius="0.03" length="0.4"/></geometry></visual>
  </link>
  <link name="a/b &lt;i&gt;"><visual><geometry><mesh filename="lost.stl"/></geometry></visual></link>
  <link name="tool0"><visual><geometry><sphere radius="0.02"/></geometry></visual></link>
  <link name="left"/><link name="right"/>
  <joint name="yaw" type="continuous"><parent link="base_link"/><child link="upper"/>
    <origin xyz="0 0 0.05"/><axis xyz="0 0 1"/></joint>
  <joint name="pitch" type="revolute"><parent link="upper"/><child link="a/b &lt;i&gt;"/><origin xyz="0 0 0.4"/>
    <axis xyz="0 1 0"/><limit lower="-1.5" upper="1.5" velocity="2" effort="5"/></joint>
  <joint name="slide" type="prismatic"><parent link="a/b &lt;i&gt;"/><child link="tool0"/><origin xyz="0.3 0 0"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.2" velocity="0.5" effort="5"/></joint>
  <joint name="finger" type="prismatic"><parent link="tool0"/><child link="left"/><axis xyz="0 1 0"/>
    <limit lower="0.01" upper="0.04" velocity="0.1" effort="1"/></joint>
  <joint name="follower" type="prismatic"><parent link="tool0"/><child link="right"/><axis xyz="0 -1 0"/>
    <limit lower="0" upper="0.04" velocity="0.1" effort="1"/><mimic joint="finger"/></joint>
</robot>"""

THETA = (0.4, -0.7, 0.15)


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Arm:
    path = tmp_path_factory.mktemp("arm") / "small.urdf"
    path.write_text(ARM)
    return load_arm(path, tip="tool0")


@pytest.fixture
def viewer(arm: Arm) -> Iterator[Viewer]:
    with Viewer(arm, THETA, open_browser=False) as served:
        yield served


def swing(arm: Arm) -> Trajectory:
    return plan_joint(arm, [(0, 0, 0), (1, 1, 0.1), (0.5, -1, 0.2)], limits={"velocity": 1.0, "acceleration": 2.0})


def matrix(columns: list[float]) -> NDArray[np.float64]:
    placed: NDArray[np.float64] = np.array(columns, dtype=np.float64).reshape(4, 4).T
    return placed


class Page:
    """A page as a program: a socket whose messages are kept by type."""

    def __init__(self, address: str, headers: dict[str, str]) -> None:
        self.address, self.headers = address, headers
        self.latest: dict[str, Any] = {}
        self.objects: list[dict[str, Any]] = []

    async def open(self) -> Page:
        self.connection = await websocket_connect(HTTPRequest(self.address, headers=self.headers))
        await self.until(lambda: "frame" in self.latest)
        return self

    async def send(self, text: str | bytes) -> None:
        self.latest.pop("done", None)
        self.latest.pop("error", None)
        await self.connection.write_message(text, binary=isinstance(text, bytes))

    async def ask(self, **request: Any) -> None:
        await self.send(json.dumps({**request, "number": 7}))
        await self.until(lambda: "done" in self.latest)

    async def until(self, reached: Callable[[], bool]) -> None:
        await asyncio.wait_for(self._read_until(reached), WAIT)

    async def _read_until(self, reached: Callable[[], bool]) -> None:
        while not reached():
            message = await self.connection.read_message()
            assert message is not None, "the socket was closed"
            if isinstance(message, bytes):
                self.objects.append(umsgpack.unpackb(message))
            else:
                self.latest[json.loads(message)["type"]] = json.loads(message)

    async def until_closed(self) -> None:
        while await asyncio.wait_for(self.connection.read_message(), WAIT) is not None:
            pass


def visit(viewer: Viewer, visitor: Callable[[Page], Any], **headers: str) -> Page:
    """Open a page, let `visitor` use it, and return it."""

    async def go() -> Page:
        page = await Page(viewer.url.replace("http", "ws", 1) + "socket", headers).open()
        await visitor(page)
        page.connection.close()
        return page

    return asyncio.run(go())


async def nothing(page: Page) -> None: ...


def get(url: str, **headers: str) -> tuple[int, str, Any]:
    try:
        with urllib.request.urlopen(urllib.request.Request(url, headers=headers), timeout=WAIT) as answer:
            return answer.status, answer.read().decode(), answer.headers
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode(), error.headers


# what is drawn ----------------------------------------------------------------------------------------


def test_a_new_page_is_told_the_arm_the_scene_and_where_everything_stands(arm: Arm, viewer: Viewer) -> None:
    page = visit(viewer, nothing)
    hello, frame = page.latest["hello"], page.latest["frame"]
    assert [joint["name"] for joint in hello["arm"]["joints"]] == ["yaw", "pitch", "slide"]
    assert [joint["unit"] for joint in hello["arm"]["joints"]] == ["rad", "rad", "m"]
    assert hello["arm"]["joints"][0]["limits"] == [None, None]
    assert_allclose(hello["arm"]["joints"][0]["range"], [-np.pi, np.pi])
    assert hello["arm"]["joints"][2]["range"] == [0, 0.2]
    assert [joint["name"] for joint in hello["arm"]["others"]] == ["finger"]
    assert hello["arm"]["poses"] == ["zero", "ready"]
    assert hello["objects"] == len(page.objects)
    assert hello["notes"] == ["not drawn, the mesh was not found: 'a/b <i>'"]
    assert frame["theta"] == list(THETA)
    poses = arm.poses(THETA, {"finger": 0.01})
    for link, path in hello["links"].items():
        assert_array_equal(matrix(frame["transforms"][path]), poses[link])
    assert_array_equal(matrix(frame["transforms"]["/frames/tool"]), poses[arm.tip])
    assert_allclose(frame["tool"]["position"], poses[arm.tip][:3, 3], atol=0)


def test_the_last_screw_carries_home_to_the_tool(arm: Arm) -> None:
    assert_allclose(partial_products(arm, np.array(THETA))[-1] @ arm.home, arm.fk(THETA), atol=ROUNDING)


def test_arms_without_a_description_are_drawn_from_their_axes() -> None:
    screws = np.column_stack(
        [
            joints.revolute([0, 0, 1], [0, 0, 0]),
            joints.helical([0, 1, 0], [0, 0, 0.4], 0.05),
            joints.prismatic([0, 0, 1]),
        ]
    )
    home = np.eye(4)
    home[:3, 3] = [0.5, 0, 0.4]
    arm = arm_from_screws(screws, home)
    stage, scene = Stage(arm, [0.3, 0.4, -0.1]), build_scene(arm)
    frame = stage.frame()
    assert_allclose(
        matrix(frame["transforms"]["/arm/rod:1"]), poe.fk(screws[:, :2], np.eye(4), [0.3, 0.4]), atol=ROUNDING
    )
    assert stage.hello(scene.links)["arm"]["screws"] == ["helical", "prismatic", "revolute"]
    assert scene.notes == ()
    assert {"/arm/rod:0/rod", "/arm/rod:1/rail"} <= {umsgpack.unpackb(part)["path"] for part in scene.objects}


def test_a_cylinder_stands_along_z(arm: Arm) -> None:
    drawn = {part["path"]: part["object"] for part in map(umsgpack.unpackb, build_scene(arm).objects)}
    upper = drawn["/arm/link:upper/visual0"]
    assert upper["geometries"][0]["type"] == "CylinderGeometry"
    placed = matrix(upper["object"]["matrix"])
    assert_allclose(placed @ [0, 0.2, 0, 1], [0, 0, 0.4, 1], atol=ROUNDING)  # three.js's top end, at URDF's
    red = drawn["/arm/link:base_link/visual0"]["materials"][0]
    assert (red["color"], red["opacity"], red["transparent"]) == (0xFF0000, 0.5, True)


def test_a_link_whose_mesh_is_missing_is_a_stick_to_the_joint_it_carries(arm: Arm) -> None:
    drawn = {part["path"]: part["object"] for part in map(umsgpack.unpackb, build_scene(arm).objects)}
    stick = drawn["/arm/link:a%2Fb%20%3Ci%3E/stick0"]
    assert_allclose(stick["geometries"][0]["height"], 0.3)
    assert_allclose(matrix(stick["object"]["matrix"])[:3, 3], [0.15, 0, 0], atol=ROUNDING)


@pytest.mark.parametrize(
    ("kind", "lower", "upper", "expected"),
    [
        ("revolute", -1.0, 2.0, (-1.0, 2.0)),
        ("continuous", -np.inf, np.inf, (-np.pi, np.pi)),
        ("prismatic", -np.inf, np.inf, (-1.0, 1.0)),
        ("prismatic", 0.5, np.inf, (0.5, 1.5)),
        ("revolute", -np.inf, -4.0, (-4.0 - np.pi, -4.0)),
    ],
)
def test_slider_range(kind: str, lower: float, upper: float, expected: tuple[float, float]) -> None:
    assert_allclose(_describe("joint", kind, lower, upper, usual_half(kind))["range"], expected)


# meshes -----------------------------------------------------------------------------------------------


def test_a_cube_keeps_its_edges_and_a_sphere_is_smooth() -> None:
    import trimesh

    cube = trimesh.creation.box((1, 2, 3))
    vertices, normals, faces = shaded(cube.triangles)
    assert len(vertices) == 24
    assert_allclose(np.repeat(cube.face_normals, 3, axis=0), normals[faces].reshape(-1, 3), atol=SINGLE)
    ball = trimesh.creation.icosphere(3)
    vertices, normals, _ = shaded(ball.triangles)
    assert len(vertices) == len(ball.vertices)
    assert_allclose(normals, vertices, atol=0.02)  # facets of 8°: their mean is radial to a degree


def test_an_stl_with_zero_normals_gets_its_normals_from_its_triangles(tmp_path: Path) -> None:
    import trimesh

    cube = trimesh.creation.box((1, 1, 1))
    path = tmp_path / "cube.stl"
    data = bytearray(trimesh.exchange.stl.export_stl(cube))
    for face in range(12):
        data[84 + 50 * face : 96 + 50 * face] = bytes(12)
    path.write_bytes(data)
    (part,) = load_parts(path)
    assert part.colour is None
    assert_allclose(np.linalg.norm(part.normals, axis=1), 1, atol=SINGLE)


def test_a_collada_file_in_millimetres_is_drawn_in_metres(tmp_path: Path) -> None:
    import trimesh

    text = trimesh.creation.box((100, 200, 300)).export(file_type="dae").decode()
    path = tmp_path / "box.dae"
    path.write_text(text.replace("<up_axis>", '<unit name="millimeter" meter="0.001"/><up_axis>'))
    (part,) = load_parts(path)
    assert_allclose(np.ptp(part.vertices, axis=0), [0.1, 0.2, 0.3], atol=SINGLE)


def test_every_material_of_a_collada_file_is_a_part_of_its_own_colour() -> None:
    if "ur5" not in available_arms():
        pytest.skip("example-robot-data is not installed")
    description = load_arm("ur5").description
    assert description is not None
    path = description.links["forearm_link"].visuals[0].mesh
    assert path is not None
    parts = load_parts(path)
    assert len(parts) == 4
    assert len({part.colour for part in parts}) == 3


def test_a_mesh_that_cannot_be_read_is_noted_and_the_rest_is_drawn(tmp_path: Path) -> None:
    (tmp_path / "lost.stl").write_text("no mesh at all")
    (tmp_path / "arm.urdf").write_text(ARM)
    broken = load_arm(tmp_path / "arm.urdf", tip="tool0")
    assert broken.description is not None
    (reason,) = load_meshes(broken.description).values()
    assert isinstance(reason, str)
    assert re.search(r"cannot read mesh .*lost\.stl: .*; export it again as STL, DAE or OBJ", reason)
    assert build_scene(broken).notes == (reason,)
    with pytest.raises(DescriptionError, match="cannot read mesh"):
        load_parts(tmp_path / "lost.stl")


# who may come in --------------------------------------------------------------------------------------


def test_the_page_and_its_files_are_served_under_the_token_only(viewer: Viewer) -> None:
    status, text, headers = get(viewer.url)
    assert status == 200
    assert "<title>twistarm</title>" in text
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "script-src 'self';" in policy
    assert "unsafe-eval" not in policy
    for name in re.findall(r'(?:src|href)="([\w.]+)"', text):
        assert get(viewer.url + name)[0] == 200, name
    root = viewer.url.rsplit("/", 2)[0]
    for address in (f"{root}/", f"{root}/wrong/", f"{root}/wrong/main.js", f"{root}/wrong/socket", root):
        status, text, _ = get(address)
        assert status == 403, address
        assert "wrong token" in text
    assert get(viewer.url + "../../etc/passwd")[0] in (403, 404)
    assert get(viewer.url + "nothing.js")[0] == 404
    assert get(viewer.url.rstrip("/"))[1].startswith("<!DOCTYPE html>")


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:80", "127.0.0.1.evil.example", "a@127.0.0.1", "127.0.0.1:x"]
)
def test_a_foreign_host_is_refused(viewer: Viewer, host: str) -> None:
    status, text, _ = get(viewer.url, Host=host)
    assert status in (400, 403)
    assert "<title>" not in text


@pytest.mark.parametrize("host", ["localhost:1234", "127.0.0.1", "[::1]:8080", "LOCALHOST"])
def test_forwarded_ports_are_accepted(viewer: Viewer, host: str) -> None:
    assert get(viewer.url, Host=host)[0] == 200


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "file://", "http://127.0.0.1.evil.example"])
def test_a_foreign_origin_opens_no_socket(viewer: Viewer, origin: str) -> None:
    with pytest.raises(HTTPClientError, match="403"):
        visit(viewer, nothing, Origin=origin)


def test_an_origin_on_a_forwarded_port_opens_a_socket(viewer: Viewer) -> None:
    assert "hello" in visit(viewer, nothing, Origin="http://localhost:9999").latest


def test_a_wrong_token_opens_no_socket(viewer: Viewer) -> None:
    class Stranger:
        url = re.sub(r"/[^/]+/$", "/wrong/", viewer.url)

    with pytest.raises(HTTPClientError, match="403"):
        visit(Stranger, nothing)  # type: ignore[arg-type]


def test_a_view_on_every_interface_admits_addresses_but_no_foreign_names() -> None:
    guard = Guard("0.0.0.0")
    assert guard.admits_host("192.168.1.7:8000")
    assert guard.admits_host(f"{socket.gethostname()}:8000")
    assert not guard.admits_host("evil.example:8000")
    assert Guard("rover.local").admits_host("rover.local:80")
    assert not Guard("127.0.0.1").admits_host("192.168.1.7")
    assert Guard("127.0.0.1").token != Guard("127.0.0.1").token


# messages ---------------------------------------------------------------------------------------------

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


# Python's side ----------------------------------------------------------------------------------------


def test_the_latest_configuration_wins(viewer: Viewer) -> None:
    async def watch(page: Page) -> None:
        for i in range(5000):
            viewer.show([0.0, 0.0, i / 2**16])
        await page.until(lambda: page.latest["frame"]["theta"][2] == 4999 / 2**16)

    visit(viewer, watch)
    assert viewer.theta[2] == 4999 / 2**16


def test_a_page_that_never_reads_holds_up_nobody_and_costs_nothing(viewer: Viewer) -> None:
    host, port = "127.0.0.1", int(viewer.url.split(":")[2].split("/")[0])
    with socket.socket() as mute:
        mute.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        mute.connect((host, port))
        path = "/" + viewer.url.split("/", 3)[3] + "socket"
        mute.sendall(
            f"GET {path} HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        until(lambda: len(viewer._server.clients) == 1)
        (client,) = viewer._server.clients
        frames = 0
        while "frame" not in client._outbox:  # until the system's buffers are full
            assert frames < 50_000
            frames += 1
            viewer.show([0.0, 0.0, frames / 2**18])
            _ = viewer.theta
        for _ in range(1000):
            frames += 1
            viewer.show([0.0, 0.0, frames / 2**18])
            _ = viewer.theta
        assert len(client._outbox) <= 3
        assert visit(viewer, nothing).latest["frame"]["theta"][2] == frames / 2**18
        start = time.monotonic()
        viewer.close()
        assert time.monotonic() - start < 1.0


@pytest.mark.parametrize(
    ("theta", "reason"),
    [
        ([0, 0], r"theta must have shape \(\.\.\., 3\): yaw, pitch, slide; got \(2,\)"),
        ([0, 0, np.nan], "theta must be finite"),
        ([[0, 0, 0]], r"theta must be one configuration, shape \(3,\); got \(1, 3\)"),
        ([0, 0, 1e300], r"at most 1e\+06 in size; got 1e\+300"),
    ],
)
def test_a_bad_configuration_is_refused_at_the_door(arm: Arm, viewer: Viewer, theta: Any, reason: str) -> None:
    for door in (viewer.show, lambda bad: Viewer(arm, bad, open_browser=False)):
        with pytest.raises(InputError, match=reason):
            door(theta)
    assert_array_equal(viewer.theta, THETA)


def test_a_trajectory_plays_in_real_time_and_can_be_paused_and_sought(arm: Arm, viewer: Viewer) -> None:
    motion = swing(arm)

    async def watch(page: Page) -> None:
        viewer.play(motion, speed=4.0)
        await page.until(lambda: page.latest.get("player", {}).get("duration") == motion.duration)
        await page.until(lambda: page.latest["frame"]["running"] and page.latest["frame"]["time"] > 0.5)
        frame = page.latest["frame"]
        assert_allclose(frame["theta"], motion(frame["time"]), atol=ROUNDING)
        await page.ask(type="pause")
        assert not page.latest["frame"]["running"]
        await page.ask(type="seek", time=1.0)
        assert_allclose(page.latest["frame"]["theta"], motion(1.0), atol=ROUNDING)
        await page.ask(type="play")
        await page.until(lambda: not page.latest["frame"]["running"])
        assert page.latest["frame"]["time"] == motion.duration

    visit(viewer, watch)
    assert_allclose(viewer.theta, motion(motion.duration), atol=ROUNDING)


def test_a_looping_trajectory_starts_again(arm: Arm) -> None:
    stage, motion = Stage(arm), swing(arm)
    stage.load(motion, speed=2.0, loop=True, now=100.0)
    stage.advance(100.0 + (motion.duration + 0.5) / 2)
    assert stage.running
    assert_allclose(stage.theta, motion(0.5), atol=1e-12)  # a moment that went through a division by the speed
    stage.show(np.zeros(3))
    assert not stage.running


def test_a_motion_without_length_stops_at_once(arm: Arm) -> None:
    stage = Stage(arm)
    stage.load(plan_joint(arm, [THETA, THETA], limits={"velocity": 1.0, "acceleration": 1.0}), 1.0, True, 0.0)
    stage.advance(1.0)
    assert not stage.running
    assert_allclose(stage.theta, THETA)


def test_a_trajectory_of_another_arm_is_refused(arm: Arm, viewer: Viewer, tmp_path: Path) -> None:
    other = arm_from_screws(joints.revolute([0, 0, 1], [0, 0, 0]), np.eye(4), joints=["elbow"])
    motion = plan_joint(other, [[0], [1]], limits={"velocity": 1.0, "acceleration": 1.0})
    with pytest.raises(
        InputError, match="the trajectory moves elbow; small has yaw, pitch, slide: plan it for this arm"
    ):
        viewer.play(motion)
    with pytest.raises(InputError, match="plan it for this arm"):
        viewer.save_html(tmp_path / "view.html", motion)
    with pytest.raises(InputError, match="speed must be a positive number; got 0"):
        viewer.play(swing(arm), speed=0)
    assert list(tmp_path.iterdir()) == []


def test_stage_refuses_what_it_does_not_know(arm: Arm) -> None:
    stage = Stage(arm)
    with pytest.raises(UnknownNameError, match="no joint 'elbow' in small"):
        stage.handle(parse('{"type": "joint", "name": "elbow", "value": 0}'), 0.0)
    with pytest.raises(LimitError, match="outside its limits"):
        stage.handle(parse('{"type": "joint", "name": "slide", "value": -1}'), 0.0)


# starting and stopping --------------------------------------------------------------------------------


def test_a_port_in_use_is_one_line(arm: Arm, viewer: Viewer) -> None:
    port = int(viewer.url.split(":")[2].split("/")[0])
    with pytest.raises(
        InputError, match=rf"^port {port} is in use on 127\.0\.0\.1; take another, or --port 0 \(port=0\)"
    ):
        Viewer(arm, port=port, open_browser=False)


@pytest.mark.parametrize("port", [-1, 65536, "80", 1.5, True])
def test_a_port_that_is_none(arm: Arm, port: Any) -> None:
    with pytest.raises(InputError, match="port must be 0"):
        Viewer(arm, port=port, open_browser=False)


@pytest.mark.parametrize("host", ["no.such.host.invalid", "203.0.113.7", "x" * 300])
def test_a_host_that_is_not_this_machine(arm: Arm, host: str) -> None:
    with pytest.raises(InputError, match=r"cannot listen on host .*; use 127\.0\.0\.1, or an address of this machine"):
        Viewer(arm, host=host, open_browser=False)


def test_closing_leaves_nothing(arm: Arm, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_process(*arguments: Any, **options: Any) -> None:
        raise AssertionError("the viewer starts no process, Meshcat's server least of all")

    monkeypatch.setattr(subprocess, "Popen", no_process)
    threads = set(threading.enumerate())
    viewer = Viewer(arm, open_browser=False)
    port = int(viewer.url.split(":")[2].split("/")[0])

    async def outlive(page: Page) -> None:
        await asyncio.to_thread(viewer.close)
        await page.until_closed()

    visit(viewer, outlive)
    viewer.close()
    assert set(threading.enumerate()) - threads == set()
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.1", port))
    Viewer(arm, port=port, open_browser=False).close()
    assert_array_equal(viewer.theta, arm.ready)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for one child")
def test_ctrl_c_ends_waiting_cleanly() -> None:
    program = (
        "import os, signal, threading, numpy as np; from twistarm import arm_from_screws, joints\n"
        "from twistarm.viewer import Viewer\n"
        "arm = arm_from_screws(joints.revolute([0, 0, 1], [0, 0, 0]), np.eye(4))\n"
        "with Viewer(arm, open_browser=False) as v:\n"
        "    threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT)).start()\n"
        "    v.wait(); print('done')\n"
    )
    child = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert (child.stdout, child.stderr, child.returncode) == ("done\n", "", 0)


def test_wait_returns_when_the_view_is_closed_elsewhere(viewer: Viewer) -> None:
    threading.Timer(0.1, viewer.close).start()
    start = time.monotonic()
    viewer.wait()
    assert time.monotonic() - start < WAIT


def test_without_meshcat_the_error_says_what_to_install(
    arm: Arm, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setitem(sys.modules, "meshcat", None)
    for view in (lambda: Viewer(arm, open_browser=False), lambda: save_html(arm, tmp_path / "view.html")):
        with pytest.raises(MissingExtraError, match=r"the viewer needs meshcat, .*: pip install 'twistarm\[view\]'"):
            view()
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(MissingExtraError, match=r"drawing a mesh needs trimesh"):
        load_parts(tmp_path / "x.stl")


def test_importing_the_viewer_imports_no_extra() -> None:
    program = (
        "import sys, twistarm.viewer; print(sorted({'meshcat', 'tornado', 'trimesh', 'umsgpack'} & set(sys.modules)))"
    )
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True)
    assert result.stdout == "[]\n"


def test_a_missing_browser_is_no_error(
    arm: Arm, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setenv("BROWSER", "none-of-this-name")
    with Viewer(arm) as viewer:
        assert opened == [viewer.url]
    if sys.platform.startswith("linux"):
        for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
            monkeypatch.delenv(name, raising=False)
        with Viewer(arm) as viewer:
            assert viewer.url.startswith("http://127.0.0.1:")
        assert len(opened) == 1
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("host", "name"), [("localhost", "localhost"), ("0.0.0.0", "127.0.0.1"), ("::1", "[::1]")])
def test_other_hosts(arm: Arm, host: str, name: str) -> None:
    if host == "::1" and not socket.has_ipv6:
        pytest.skip("this machine has no IPv6")
    with Viewer(arm, host=host, open_browser=False) as viewer:
        assert viewer.url.startswith(f"http://{name}:")
        assert get(viewer.url)[0] == 200


# the stand-alone page ---------------------------------------------------------------------------------


def test_the_stand_alone_page_needs_nothing_from_anywhere(arm: Arm, tmp_path: Path) -> None:
    path = save_html(arm, tmp_path / "view.html", swing(arm))
    text = path.read_text(encoding="utf-8")
    assert re.search(r"""(?:src|href)=["'](?!data:)""", re.sub(r"<script.*?</script>", "", text, flags=re.S)) is None
    assert text.count("<script") == text.count("</script>") == 3
    assert "default-src 'none'" in text
    data = stored(text)
    assert data["samples"]["times"][-1] == swing(arm).duration
    assert len(data["samples"]["nodes"]["/frames/tool"]) == len(data["samples"]["times"])


def test_names_cannot_break_out_of_the_stand_alone_page(tmp_path: Path) -> None:
    nasty = "</script><img src=x onerror=alert(1)>"
    arm = arm_from_screws(joints.revolute([0, 0, 1], [0, 0, 0]), np.eye(4), joints=[nasty], name=nasty)
    text = save_html(arm, tmp_path / "view.html").read_text(encoding="utf-8")
    assert "<img" not in text
    assert stored(text)["arm"]["name"] == nasty


def test_a_stand_alone_page_of_the_view_shows_what_the_view_shows(viewer: Viewer, tmp_path: Path) -> None:
    viewer.show([0.3, 0.2, 0.1])
    data = stored(viewer.save_html(tmp_path / "view.html").read_text(encoding="utf-8"))
    assert data["samples"]["theta"] == [[0.3, 0.2, 0.1]]


def test_a_stand_alone_page_is_written_whole_or_not_at_all(arm: Arm, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not exist; create it first"):
        save_html(arm, tmp_path / "nowhere" / "view.html")
    assert list(tmp_path.iterdir()) == []


def stored(text: str) -> Any:
    match = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, flags=re.S)
    assert match is not None
    return json.loads(match[1])


def until(reached: Callable[[], bool]) -> None:
    end = time.monotonic() + WAIT
    while not reached():
        assert time.monotonic() < end
        time.sleep(0.01)
