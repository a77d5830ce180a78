"""The live view under load: a frame's cost, a page's round trip, 60 frames a second to three pages, start, meshes.

The measured process is the server. The pages are programs: in another thread of it for the round trips, in another
process for the 60 frames. Each figure is printed beside its limit. With Chromium and playwright installed, the times of
a real page are measured too.
"""

from __future__ import annotations

import argparse
import asyncio
import gc
import json
import multiprocessing
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import time
import tracemalloc
import urllib.request
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from twistarm import Arm, load_arm
from twistarm.support.errors import TwistarmError
from twistarm.support.strict_json import encode
from twistarm.viewer import Viewer
from twistarm.viewer.protocol.messages import ChangePublisher
from twistarm.viewer.stage import Stage

from .machine import machine
from .viewer_page import in_chromium, open_page, received

ARMS = ("rover_arm", "rover_arm_6dof", "panda")
RATE, PAGES = 60, 3
SWING = 0.3
"""How far the joints go about the ready pose [rad, m]."""

LARGE_TIME = 30.0
"""s after which the large model is not waited for any longer."""

LARGE_FILES, LARGE_SIDES = 20, 112
"""Meshes of the large model and the sides of each: 49,280 triangles, 2.5 MB as STL."""


def timed(call: Callable[[int], object], count: int) -> str:
    """Median and 99 % of so many calls [ms], after a tenth to warm up."""
    times = []
    for k in range(-count // 10, count):
        begin = time.perf_counter()
        call(k)
        times.append(1e3 * (time.perf_counter() - begin))
    return percentiles(times[-count:])


def percentiles(ms: list[float]) -> str:
    median, p99 = np.percentile(ms, [50, 99])
    return f"{median:.3f} ms median, {p99:.3f} ms 99 %"


def swing(arm: Arm, k: int) -> Any:
    return arm.ready + 0.5 * SWING * np.sin(0.05 * k + np.arange(arm.n))


# figures ----------------------------------------------------------------------------------------------


def frame(arm: Arm, count: int) -> str:
    """Forward kinematics, the messages of every part and their text, for a new configuration each time."""
    stage, news = Stage(arm), ChangePublisher()

    def one(k: int) -> None:
        stage.show(swing(arm, k))
        news.gather(stage.sources())

    size = len(encode(stage.frame()))
    links = 0 if arm.description is None else len(arm.description.links)
    return f"{timed(one, count)}; {links} links, {size} bytes (allowed 0.15 ms for 10 links)"


async def round_trips(url: str, requests: list[dict[str, Any]], answer: str) -> list[float]:
    """ms from each request until the page has been told the message `answer` that follows from it."""
    connection, _ = await open_page(url)
    times = [await round_trip(connection, {**each, "number": k}, answer) for k, each in enumerate(requests, 1)]
    connection.close()
    return times[len(times) // 10 :]


async def round_trip(connection: Any, request: dict[str, Any], answer: str) -> float:
    begin = time.perf_counter()
    await connection.write_message(json.dumps(request))
    while (message := received(await connection.read_message())).get("type") != answer:
        if message.get("type") == "error":
            raise RuntimeError(message["message"])
    return 1e3 * (time.perf_counter() - begin)


def sliders(arm: Arm, count: int) -> list[dict[str, Any]]:
    inside = [np.clip(swing(arm, k), arm.limits.lower, arm.limits.upper) for k in range(count)]
    return [{"type": "theta", "theta": theta.tolist()} for theta in inside]


def targets(arm: Arm, count: int) -> list[dict[str, Any]]:
    """A path of the tool's origin as a hand drags it: half a millimetre at a time."""
    g = arm.fk(arm.ready)
    way = [(g[:3, 3] + 0.02 * np.sin(0.025 * k) * np.array([0.3, 0.5, -0.8])).tolist() for k in range(1, count + 1)]
    return [{"type": "target", "kind": "position", "position": p, "xyzw": [0, 0, 0, 1]} for p in way]


def pages(url: str, count: int, report: Connection) -> None:
    """Several pages in one process. They report when they are ready, and at the end how many frames each received."""

    async def watch() -> list[int]:
        opened = [await open_page(url) for _ in range(count)]
        report.send("open")
        return await asyncio.gather(*(frames(connection) for connection, _ in opened))

    async def frames(connection: Any) -> int:
        number = 0
        while (message := await connection.read_message()) is not None:
            number += b'"type":"frame"' in message[:40].encode() if isinstance(message, str) else 0
        return number

    report.send(asyncio.run(watch()))


def sixty_a_second(arm: Arm, seconds: float) -> str:
    """Post RATE frames a second to PAGES pages for this time, then close; return what is left and what arrived."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    viewer = Viewer(arm, open_browser=False)
    process = context.Process(target=pages, args=(viewer.url, PAGES, theirs))
    process.start()
    ours.recv()
    post(viewer, arm, min(5.0, seconds))  # after which the doctor has looked, too
    tracemalloc.start()
    gc.collect()
    before, resident = tracemalloc.get_traced_memory()[0], resident_bytes()
    busy = time.process_time()
    post(viewer, arm, seconds)
    busy = time.process_time() - busy
    gc.collect()
    grown, more = tracemalloc.get_traced_memory()[0] - before, resident_bytes() - resident
    open_still = len(viewer._server.clients)
    tracemalloc.stop()
    viewer.close()
    counts = ours.recv()
    process.join()
    posted = int(RATE * seconds) + int(RATE * min(5.0, seconds))
    return (
        f"{min(counts)} of {posted} frames at the page that got fewest, {open_still} of {PAGES} sockets open at the "
        f"end, memory {grown / 1e6:+.2f} MB (tracemalloc), {more / 1e6:+.2f} MB (resident; allowed 5 MB), "
        f"{100 * busy / seconds:.0f} % of a core with tracemalloc"
    )


def post(viewer: Viewer, arm: Arm, seconds: float) -> None:
    begin = time.monotonic()
    for k in range(int(RATE * seconds)):
        time.sleep(max(0.0, begin + k / RATE - time.monotonic()))
        viewer.show(swing(arm, k))


def resident_bytes() -> int:
    status = Path("/proc/self/status")
    found = re.search(r"VmRSS:\s+(\d+)", status.read_text()) if status.exists() else None
    return 1024 * int(found[1]) if found else 0


def start(name: str) -> dict[str, float]:
    """s from the command to the printed address, to the page's first byte, and to the whole scene."""
    began = time.perf_counter()
    command = [sys.executable, "-c", "from twistarm.cli import main; main()", "view", name, "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        url = re.search(r"http://\S+", process.stdout.readline())[0]  # type: ignore[index]
        times = {"address": time.perf_counter() - began}
        with urllib.request.urlopen(url) as answer:
            answer.read(1)
        times["first byte"] = time.perf_counter() - began

        async def scene() -> None:
            connection, _ = await open_page(url)
            connection.close()

        asyncio.run(scene())
        times["whole scene"] = time.perf_counter() - began
        in_browser = in_chromium(url, began)
        process.send_signal(signal.SIGINT)
    return {**times, **in_browser}


def large_model(folder: Path) -> Path:
    """A description with some 50 MB of meshes."""
    import trimesh

    ball = trimesh.creation.uv_sphere(radius=0.06, count=[LARGE_SIDES, LARGE_SIDES])
    visual = '<visual><origin xyz="0 0 {z}"/><geometry><mesh filename="{i}.stl"/></geometry></visual>'
    joint = (
        '<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{child}"/><origin xyz="0 0 0.25"/>'
        '<axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>'
    )
    for i in range(LARGE_FILES):
        ball.export(folder / f"{i}.stl")
    links = [
        f'<link name="l{k}">' + "".join(visual.format(i=i, z=0.01 * i) for i in range(k, LARGE_FILES, 6)) + "</link>"
        for k in range(6)
    ]
    joints = [joint.format(i=i, child=i + 1) for i in range(5)]
    path = folder / "large.urdf"
    path.write_text(f'<robot name="large">{"".join(links + joints)}</robot>')
    return path


async def while_drawing(url: str) -> tuple[str, list[float]]:
    """When the whole scene was there, and meanwhile the round trips of a slider [ms]."""
    began, times = time.perf_counter(), []
    whole = asyncio.create_task(open_page(url))
    connection, _ = await open_page(url, whole=False)
    while not whole.done() and time.perf_counter() - began < LARGE_TIME:
        value = 1e-4 * (len(times) + 1)  # another each time: else there is no new frame
        times.append(await round_trip(connection, {"type": "joint", "name": "j0", "value": value}, "frame"))
    sent = (
        f"all sent after {time.perf_counter() - began:.1f} s" if whole.done() else f"not all sent in {LARGE_TIME:g} s"
    )
    whole.cancel()
    return sent, times


def large() -> str:
    with tempfile.TemporaryDirectory() as folder:
        arm = load_arm(large_model(Path(folder)))
        size = sum(file.stat().st_size for file in Path(folder).glob("*.stl")) / 1e6
        began = time.perf_counter()
        with Viewer(arm, open_browser=False) as viewer:
            urllib.request.urlopen(viewer.url).close()
            served = time.perf_counter() - began
            sent, times = asyncio.run(while_drawing(viewer.url))
    return f"{size:.0f} MB: page served after {served:.3f} s, {sent}; a slider meanwhile " + (
        f"{percentiles(times)}, {max(times):.0f} ms at most"
    )


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.viewer", description=__doc__)
    parser.add_argument("--calls", type=int, default=2000, help="frames and round trips of each arm; 2000")
    parser.add_argument("--seconds", type=float, default=60.0, help="of frames to three pages; 60")
    given = parser.parse_args()
    print("the live view")
    for name, value in machine().items():
        print(f"  {name}: {value}")
    arms = []
    for name in ARMS:
        try:
            arms.append(load_arm(name))
        except TwistarmError as error:  # noqa: PERF203
            print(f"  {name}: {error}")
    for arm in arms:
        print(f"a frame of {arm.name}: {frame(arm, given.calls)}")
    for arm in arms:
        with Viewer(arm, open_browser=False) as viewer:
            moved = asyncio.run(round_trips(viewer.url, sliders(arm, given.calls), "frame"))
            solved = asyncio.run(round_trips(viewer.url, targets(arm, given.calls), "target"))
        print(f"slider to frame, {arm.name}: {percentiles(moved)}")
        print(f"target to answer (socket, IK, FK), {arm.name}: {percentiles(solved)} (allowed 1 ms median)")
    print(f"{RATE} frames a second to {PAGES} pages for {given.seconds:g} s: {sixty_a_second(arms[0], given.seconds)}")
    rounds = [start("rover_arm") for _ in range(3)]
    for what in rounds[0]:
        unit = "ms" if "to drawn" in what else "s"
        print(f"view rover_arm, {what}: {statistics.median(each[what] for each in rounds):.2f} {unit}")
    print("  (median of 3; allowed: page live 2 s, a slider or a drag drawn 50 ms)")
    print(f"large model, {large()}")


if __name__ == "__main__":
    main()
