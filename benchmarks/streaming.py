"""The whole loop at 300 Hz for a minute: commands and joint states by UDP, the servo, simulated joints.

One process runs the loop. A second one is both operator and robot. It sends a twist at 50 Hz, moves simulated joints
with 10 ms latency, and reports them at 200 Hz. Before and after, the bare timer runs for a tenth of the time; what it
misses is due to the machine.
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
    Metronome,
    MonotonicClock,
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
    setpoints.setblocking(False)
    began, sent = time.monotonic(), 0
    while not over.is_set():
        now = time.monotonic()
        while (message := received(setpoints)) is not None:
            joints.write(message)
        state = {"joint_names": arm.joint_names, "theta": joints.read(now).theta.tolist()}
        setpoints.sendto(json.dumps(state).encode(), feedback)
        if now - began >= sent * TWIST_EVERY:
            sent += 1
            speed = 0.05 * math.sin(now - began)
            twist = {"twist": [0.0, 0.0, speed, 0.0, 0.0, 0.0], "frame": "base", "number": sent}
            setpoints.sendto(json.dumps(twist).encode(), source)
        time.sleep(STATE_EVERY)


def received(setpoints: socket.socket) -> Setpoint | None:
    try:
        message = json.loads(setpoints.recv(65536))
    except BlockingIOError:
        return None
    theta, theta_dot = np.array(message["theta"]), np.array(message["theta_dot"])
    return Setpoint(
        message["number"], message["time"], theta, theta_dot, ServoOutput.stale(theta_dot, message["reason"])
    )


def bare_timer(rate: float, seconds: float) -> str:
    """Cycles of the loop's own timer that do nothing: how late they begin."""
    clock, metronome, lateness = MonotonicClock(), Metronome(1.0 / rate), []
    end, cycles, missed = clock.now() + seconds, 0, 0
    metronome.tick(clock.now())
    while clock.now() < end:
        clock.sleep_until(metronome.next)
        now, due = clock.now(), metronome.next
        lateness.append(now - due)
        cycles, missed = cycles + 1, missed + max(0, metronome.tick(now) - 1)
    late = [f"{1e3 * each:.3f} ms" for each in np.percentile(lateness, [50, 99, 100])]
    return f"{cycles} cycles, {missed} missed, late by {late[0]} (median), {late[1]} (99 %), {late[2]} (most)"


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.streaming", description=__doc__)
    parser.add_argument("--arm", default="rover_arm")
    parser.add_argument("--rate", type=float, default=300.0, help="cycles per second")
    parser.add_argument("--duration", type=float, default=60.0, help="seconds")
    given = parser.parse_args()
    arm = load_arm(given.arm)
    before = bare_timer(given.rate, given.duration / 10)
    over = multiprocessing.get_context("spawn").Event()
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as robot,
        UdpFeedback(arm) as feedback,
        UdpSource(arm) as source,
    ):
        robot.bind(("127.0.0.1", 0))
        other = multiprocessing.get_context("spawn").Process(
            target=robot_and_operator, args=(given.arm, robot, feedback.address, source.address, over)
        )
        other.start()
        try:
            with UdpSink(arm, *robot.getsockname()) as sink:
                busy = time.process_time()
                report = run(arm, source, sink, feedback, StreamOptions(rate=given.rate), duration=given.duration)
                busy = time.process_time() - busy
        finally:
            over.set()
            other.join(10.0)
    print(f"the loop of {arm.name} with UDP in and out, at {given.rate:g} Hz for {given.duration:g} s")
    for name, value in machine().items():
        print(f"  {name}: {value}")
    print(report.explain())
    print(f"bare timer before: {before}")
    print(f"bare timer after:  {bare_timer(given.rate, given.duration / 10)}")
    print(
        f"processor time: {100 * busy / report.duration:.0f} % of a core, {1e6 * busy / report.cycles:.0f} µs per cycle"
    )


if __name__ == "__main__":
    main()
