"""`twistarm servo`: the loop in the view, on simulated joints and by UDP, and what it says when it cannot."""

from __future__ import annotations

import json
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from test_cli import error_of
from twistarm.cli.application import run

Capture = pytest.CaptureFixture[str]

PROGRAM = Path(sys.executable).with_name("twistarm")

FREE = """<robot name="free"><link name="base"/><link name="arm"/><link name="hand"/>
  <joint name="turn" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint>
  <joint name="reach" type="prismatic"><parent link="arm"/><child link="hand"/><origin xyz="0.5 0 0"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.3" effort="1" velocity="0"/></joint>
</robot>"""
"""An arm that says how far it goes and not how fast."""


@contextmanager
def started(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    """The program, once it serves its page; ended at the latest with the block."""
    command = [str(PROGRAM), "servo", *arguments, "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            process.first = process.stdout.readline()  # type: ignore[attr-defined]
            yield process
        finally:
            process.kill()


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


class Robot:
    """A robot of one's own on UDP: it tells where it is at 100 Hz, and goes where it is told."""

    def __init__(self, port: int, joint_names: list[str], theta: list[float]) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(0.01)
        self.address = f"127.0.0.1:{self.socket.getsockname()[1]}"
        self.heard: list[dict[str, Any]] = []
        self._tell = ("127.0.0.1", port)
        self._state = {"joint_names": joint_names, "theta": theta}
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._live, daemon=True)
        self._thread.start()

    def _live(self) -> None:
        while not self._end.is_set():
            self.socket.sendto(json.dumps(self._state).encode(), self._tell)
            try:
                self.heard.append(json.loads(self.socket.recv(65536)))
            except (TimeoutError, ConnectionRefusedError):
                continue
            self._state = {key: self.heard[-1][key] for key in self._state}

    def close(self) -> None:
        self._end.set()
        self._thread.join()
        self.socket.close()


def test_it_runs_in_the_view_and_reports_as_json() -> None:
    done = subprocess.run(
        [PROGRAM, "servo", "rover_arm", "--duration", "1", "--no-browser", "--json"],
        capture_output=True, text=True, timeout=60, check=True,
    )  # fmt: skip
    report = json.loads(done.stdout)
    assert (report["arm"], report["ending"], report["ok"], report["rate"]) == ("rover_arm", "DURATION", True, 100.0)
    assert 50 <= report["cycles"] + report["missed"] <= 101
    assert report["statuses"] == {"STALE": report["cycles"]}  # nobody commands
    assert report["uncommanded"] == pytest.approx(report["cycles"] / 100)
    assert re.fullmatch(r"rover_arm at http://127\.0\.0\.1:\d+/\S+/  \(Ctrl-C ends it\)\n", done.stderr)


def test_limits_that_nobody_gave_are_said_and_the_report_is_a_table(tmp_path: Path, capsys: Capture) -> None:
    path = tmp_path / "free.urdf"
    path.write_text(FREE)
    arguments = ["servo", str(path), "--tip", "hand", "--duration", "0.2", "--no-browser", "--velocity", "0.1"]
    assert run(arguments) == 0
    out = capsys.readouterr().out
    assert out.splitlines()[0] == (
        "no limits given, used instead: acceleration 3 rad/s² for turn; acceleration 1 m/s² for reach "
        "(--velocity, --acceleration)"
    )
    for part in ("free: servo", "the time was over", "at 100 Hz", "median", "STALE", "at rest"):
        assert part in out
    assert run([*arguments, "--acceleration", "2"]) == 0
    assert capsys.readouterr().out.startswith("free at http")
    assert run([*arguments[:-2], "--rate", "50"]) == 0
    first = capsys.readouterr().out.splitlines()[0]
    assert "velocity 1 rad/s for turn; velocity 0.25 m/s for reach; acceleration 3" in first


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals for one child")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_ctrl_c_kill_and_a_closed_terminal_end_it_cleanly(number: signal.Signals) -> None:
    with started("scara") as process:
        time.sleep(0.3)
        process.send_signal(number)
        out, err = process.communicate(timeout=30)
    assert (process.returncode, err) == (0, "")
    assert "it was interrupted" in out
    assert "at rest" in out


def test_a_robot_by_udp_starts_where_it_is_and_ends_at_rest() -> None:
    listen, commands = free_port(), free_port()
    joints = ["joint_1", "joint_2"]
    robot = Robot(listen, joints, [0.3, 0.8])
    arguments = ("--udp", robot.address, "--listen", f"127.0.0.1:{listen}", "--commands", f"127.0.0.1:{commands}")
    with started("rr_planar", *arguments, "--duration", "2") as process, socket.socket(type=socket.SOCK_DGRAM) as stick:
        end = time.monotonic() + 1.0
        while time.monotonic() < end:
            stick.sendto(json.dumps({"jog": {"joint_2": 0.4}}).encode(), ("127.0.0.1", commands))
            time.sleep(0.03)
        out, err = process.communicate(timeout=30)
    robot.close()
    assert (process.returncode, err) == (0, "")
    assert "the time was over" in out
    assert robot.heard[0]["joint_names"] == joints
    np.testing.assert_allclose(robot.heard[0]["theta"], [0.3, 0.8], atol=0.01)
    thetas = np.array([each["theta"] for each in robot.heard])
    assert np.ptp(thetas[:, 0]) < 1e-9
    assert 0.2 < thetas[-1, 1] - 0.8 < 0.7  # 0.4 rad/s for a second and a timeout
    assert robot.heard[-1]["theta_dot"] == [0.0, 0.0]


def test_a_robot_that_says_nothing_is_never_moved() -> None:
    with socket.socket(type=socket.SOCK_DGRAM) as mute:
        mute.bind(("127.0.0.1", 0))
        mute.settimeout(0.1)
        udp = f"127.0.0.1:{mute.getsockname()[1]}"
        done = subprocess.run(
            [PROGRAM, "servo", "scara", "--duration", "0.5", "--no-browser", "--udp", udp, "--listen", "127.0.0.1:0"],
            capture_output=True, text=True, timeout=60, check=False,
        )  # fmt: skip
        assert (done.returncode, done.stderr) == (1, "")
        assert "never moved: no joint state has arrived" in done.stdout
        with pytest.raises(TimeoutError):
            mute.recv(1)


BAD_INPUT: dict[str, tuple[list[str], str]] = {
    "no arm": (["nobody"], "no arm 'nobody'"),
    "a rate of zero": (["scara", "--rate", "0"], "rate must be a positive number; got 0"),
    "a slow rate": (["scara", "--rate", "1"], "rate must be at least 10 Hz"),
    "a rate that is none": (["scara", "--rate", "nan"], "rate must be a positive number; got nan"),
    "no duration": (["scara", "--duration", "-1"], "duration must be a positive number of seconds; got -1"),
    "a negative cap": (["scara", "--velocity", "-1"], "--velocity must be a positive number; got -1"),
    "a pose of nobody": (["scara", "--theta", "nowhere"], "'nowhere' is neither joint values"),
    "half of UDP": (["scara", "--udp", "127.0.0.1:5005"], "--udp HOST:PORT and --listen HOST:PORT go together"),
    "the other half": (["scara", "--listen", "127.0.0.1:5005"], "--udp HOST:PORT and --listen HOST:PORT go together"),
    "no port": (["scara", "--udp", "robot", "--listen", "127.0.0.1:0"], "--udp takes HOST:PORT, as in"),
    "a port too high": (["scara", "--commands", "127.0.0.1:70000"], "--commands takes HOST:PORT, as in"),
    "no such host": (["scara", "--commands", "no.such.host.invalid:5005"], "no host 'no.such.host.invalid'"),
}


@pytest.mark.parametrize("case", BAD_INPUT)
def test_bad_input_is_one_line(capsys: Capture, case: str) -> None:
    arguments, reason = BAD_INPUT[case]
    assert run(["servo", *arguments, "--no-browser"]) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("error: ")
    assert captured.err.count("\n") == 1
    assert reason in captured.err


def test_a_port_in_use_is_one_line(capsys: Capture) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        assert "is in use on 127.0.0.1" in error_of(capsys, "servo", "scara", "--port", port, "--no-browser")
