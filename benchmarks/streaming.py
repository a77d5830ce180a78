"""The whole loop at 300 Hz for a minute: commands and joint states by UDP, the servo, simulated joints.

One process runs the loop. A second one is both operator and robot. It sends a twist at 50 Hz, moves simulated joints
with 10 ms latency, and reports them at 200 Hz or more. Before, the loop runs without links for a tenth of the time;
what it misses is due to the machine.
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import socket
import time
from multiprocessing.synchronize import Event

import numpy as np

from twistarm import load_arm
from twistarm.control.servo import ServoOutput
from twistarm.control.stream import (
    Inbox,
    Setpoint,
    SimulatedJoints,
    StreamOptions,
    UdpFeedback,
    UdpSink,
    UdpSource,
    run,
)

from .report import machine

TWIST_EVERY, STATE_EVERY = 0.02, 0.005


def robot_and_operator(
    name: str, setpoints: socket.socket, feedback: tuple[str, int], source: tuple[str, int], over: Event
) -> None:
    arm = load_arm(name)
    joints = SimulatedJoints(arm, arm.ready, latency=0.01)
    setpoints.settimeout(STATE_EVERY)
    began, sent = time.monotonic(), 0
    while not over.is_set():
        try:
            message = json.loads(setpoints.recv(65536))
            theta, rates = np.array(message["theta"]), np.array(message["theta_dot"])
            output = ServoOutput.stale(rates, message["reason"])
            joints.write(Setpoint(message["number"], message["time"], theta, rates, output))
        except TimeoutError:
            pass
        now = time.monotonic()
        state = {"joint_names": arm.joint_names, "theta": joints.read(now).theta.tolist()}
        setpoints.sendto(json.dumps(state).encode(), feedback)
        if now - began >= sent * TWIST_EVERY:
            sent += 1
            twist = {"twist": [0, 0, 0.05 * math.sin(now - began), 0, 0, 0], "frame": "base", "number": sent}
            setpoints.sendto(json.dumps(twist).encode(), source)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.streaming", description=__doc__)
    parser.add_argument("--arm", default="rover_arm")
    parser.add_argument("--rate", type=float, default=300.0, help="cycles per second")
    parser.add_argument("--duration", type=float, default=60.0, help="seconds")
    given = parser.parse_args()
    arm, options, spawn = load_arm(given.arm), StreamOptions(rate=given.rate), multiprocessing.get_context("spawn")
    joints = SimulatedJoints(arm, arm.ready)
    alone, over = run(arm, Inbox(), joints, joints, options, duration=given.duration / 10), spawn.Event()
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as robot,
        UdpFeedback(arm) as feedback,
        UdpSource(arm) as source,
    ):
        robot.bind(("127.0.0.1", 0))
        ends = robot, feedback.address, source.address, over
        other = spawn.Process(target=robot_and_operator, args=(given.arm, *ends))
        other.start()
        try:
            with UdpSink(arm, *robot.getsockname()) as sink:
                busy = time.process_time()
                report = run(arm, source, sink, feedback, options, duration=given.duration)
                busy = time.process_time() - busy
        finally:
            over.set()
            other.join(10.0)
    print(f"the loop of {arm.name} at {given.rate:g} Hz, without links and with UDP in and out")
    for name, value in machine().items():
        print(f"  {name}: {value}")
    print(alone.explain(), report.explain(), sep="\n\n")
    share, each = busy / report.duration, busy / report.cycles
    print(f"processor time: {100 * share:.0f} % of a core, {1e6 * each:.0f} µs per cycle")


if __name__ == "__main__":
    main()
