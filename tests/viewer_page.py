"""A small arm in a served view, and a page of it as a program."""

from __future__ import annotations

import asyncio
import json
import re
import socket
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Coroutine, Iterator
from typing import Any

import numpy as np
import pytest
import umsgpack
from numpy.typing import NDArray
from tornado.httpclient import HTTPRequest
from tornado.websocket import WebSocketClientConnection, websocket_connect

from twistarm import Arm, load_arm
from twistarm.planning.joint_space import plan_joint
from twistarm.planning.trajectory import Trajectory
from twistarm.viewer import Viewer

ROUNDING = 1e-14  # Two ways to the same pose of an arm of about 1 m, in double precision.
WAIT = 10.0  # Seconds until something that should happen at once counts as not happening.

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


LOOP = asyncio.new_event_loop()  # Of all pages, in a thread of its own.

threading.Thread(target=LOOP.run_forever, name="pages", daemon=True).start()


def on_loop(coroutine: Coroutine[Any, Any, Any]) -> Any:
    """What a coroutine returns, within the usual patience."""
    return asyncio.run_coroutine_threadsafe(asyncio.wait_for(coroutine, WAIT), LOOP).result()


class Page:
    """A page as a program: a socket whose messages are kept by type."""

    def __init__(self, viewer: Viewer, **headers: str) -> None:
        self.viewer, self.number = viewer, 0
        self.latest: dict[str, Any] = {}
        self.objects: list[dict[str, Any]] = []
        self.connection = on_loop(self._connected(HTTPRequest(address(viewer), headers=headers)))
        self.until(lambda: "frame" in self.latest)

    def __enter__(self) -> Page:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        LOOP.call_soon_threadsafe(self.connection.close)

    def other(self) -> Page:
        """Another page of the same view."""
        return Page(self.viewer)

    def send(self, text: str | bytes) -> None:
        self.latest.pop("done", None)
        self.latest.pop("error", None)
        on_loop(self._write(text))

    def ask(self, **request: Any) -> None:
        """Send, and wait for the answer to exactly this."""
        self.number += 1
        self.send(json.dumps({**request, "number": self.number}))
        self.until(lambda: self.latest.get("done", {}).get("number") == self.number)

    def until(self, reached: Callable[[], bool]) -> None:
        on_loop(self._read_until(reached))

    def until_closed(self) -> None:
        on_loop(self._read_to_the_end())

    async def _connected(self, request: HTTPRequest) -> WebSocketClientConnection:
        return await websocket_connect(request)

    async def _write(self, text: str | bytes) -> None:
        await self.connection.write_message(text, binary=isinstance(text, bytes))

    async def _read_until(self, reached: Callable[[], bool]) -> None:
        while not reached():
            message = await self.connection.read_message()
            assert message is not None, "the socket was closed"
            if isinstance(message, bytes):
                self.objects.append(umsgpack.unpackb(message))
            else:
                self.latest[json.loads(message)["type"]] = json.loads(message)

    async def _read_to_the_end(self) -> None:
        while await self.connection.read_message() is not None:
            pass


def visit(viewer: Viewer, **headers: str) -> Page:
    """What a page is told, which then goes."""
    with Page(viewer, **headers) as page:
        return page


def address(viewer: Viewer) -> str:
    """Of the socket."""
    return viewer.url.replace("http", "ws", 1) + "socket"


def port_of(viewer: Viewer) -> int:
    return int(viewer.url.split(":")[2].split("/")[0])


def connection(viewer: Viewer, receive: int = 0) -> socket.socket:
    """A bare connection to the server, with a window of `receive` bytes."""
    made = socket.socket()
    made.settimeout(5.0)
    if receive:
        made.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive)
    made.connect(("127.0.0.1", port_of(viewer)))
    return made


def until(reached: Callable[[], bool]) -> None:
    end = time.monotonic() + WAIT
    while not reached():
        assert time.monotonic() < end
        time.sleep(0.005)


def stored(text: str) -> Any:
    """What a saved page holds: its messages by type and node, and beside them `hello`, `motion` and `objects`."""
    (data,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    held = json.loads(data)
    return held | {message["type"] + message.get("node", ""): message for message in held.pop("messages")}


def get(url: str, **headers: str) -> tuple[int, str, Any]:
    try:
        with urllib.request.urlopen(urllib.request.Request(url, headers=headers), timeout=WAIT) as answer:
            return answer.status, answer.read().decode(), answer.headers
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode(), error.headers
