"""`twistarm servo`: the loop in the view, on simulated joints and by UDP, and what it says when it cannot."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from test_cli import PROGRAM, Capture, printed
from twistarm.cli.application import run
from twistarm.control.stream import Cycle
from twistarm.control.stream import run as stream
from twistarm.control.stream.links.serial_link import checksum
from twistarm.support.interrupts import ended_like_ctrl_c
from twistarm.viewer import Viewer

FREE = """<robot name="free"><link name="base"/><link name="arm"/><link name="hand"/>
  <joint name="turn" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint>
  <joint name="reach" type="prismatic"><parent link="arm"/><child link="hand"/><origin xyz="0.5 0 0"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.3" effort="1" velocity="0"/></joint>
</robot>"""
"""An arm that says how far it goes and not how fast."""


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

    def leave(self) -> None:
        """Close as soon as it was told where to go."""
        end = time.monotonic() + 20.0
        while not self.heard and time.monotonic() < end:
            time.sleep(0.02)
        self.close()

    def close(self) -> None:
        self._end.set()
        self._thread.join()
        self.socket.close()


def test_it_runs_in_the_view_and_reports_as_json(capsys: Capture) -> None:
    assert run(["servo", "rover_arm", "--duration", "0.5", "--no-browser", "--json"]) == 0
    out, err = capsys.readouterr()
    report = json.loads(out)
    assert (report["arm"], report["ending"], report["ok"], report["rate"]) == ("rover_arm", "DURATION", True, 100.0)
    assert 25 <= report["cycles"] + report["missed"] <= 51
    assert report["statuses"] == {"STALE": report["cycles"]}  # nobody commands
    assert report["uncommanded"] == pytest.approx(report["cycles"] / 100)
    assert re.fullmatch(r"rover_arm at http://127\.0\.0\.1:\d+/\S+/  \(Ctrl-C ends it\)\n", err)


def test_it_avoids_what_a_scene_file_holds_and_refuses_that_of_another_arm(tmp_path: Path, capsys: Capture) -> None:
    file = tmp_path / "scene.toml"
    file.write_text('arm = "scara"\nmargin = 0.01\n[[sphere]]\nname = "ball"\nradius = 0.1\nxyz = [2.0, 0.0, 0.0]\n')
    options = ["--avoid", str(file), "--duration", "0.2", "--no-browser"]
    assert "at rest" in printed(capsys, "servo", "scara", *options)
    assert run(["servo", "rover_arm", *options]) != 0
    assert "is for the arm 'scara'" in " ".join(capsys.readouterr().err.split())


def test_limits_that_nobody_gave_are_said_and_the_report_is_told(tmp_path: Path, capsys: Capture) -> None:
    path = tmp_path / "free.urdf"
    path.write_text(FREE)
    arguments = ["servo", str(path), "--tip", "hand", "--duration", "0.2", "--no-browser", "--velocity", "0.1"]
    out = printed(capsys, *arguments)
    assert out.splitlines()[0] == (
        "no limits given, used instead: acceleration 3 rad/s² for turn; acceleration 1 m/s² for reach "
        "(--velocity, --acceleration)"
    )
    for part in ("the time was over", "at 100 Hz", "median", "STALE", "at rest"):
        assert part in out
    assert printed(capsys, *arguments, "--acceleration", "2", "--rate", "50").startswith("free at http")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals for one child")
def test_ctrl_c_ends_the_program_cleanly() -> None:
    command = [str(PROGRAM), "servo", "scara", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            process.stdout.readline()  # it serves its page
            time.sleep(0.3)
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=30)
        finally:
            process.kill()
    assert (process.returncode, err) == (0, "")
    assert "it was interrupted" in out
    assert "at rest" in out


@pytest.mark.skipif(sys.platform == "win32", reason="Windows kills by force")
@pytest.mark.usefixtures("hangups")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_kill_and_a_closed_terminal_end_it_as_ctrl_c_does(
    capsys: Capture, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    number = getattr(signal, name)
    usual = signal.getsignal(number)

    def stop(viewer: Viewer, cycle: Cycle) -> None:
        assert signal.getsignal(number) is not usual  # else this would end the tests
        os.kill(os.getpid(), number)

    monkeypatch.setattr(Viewer, "show_servo", stop)
    with ended_like_ctrl_c() as sent:
        assert run(["servo", "scara", "--no-browser", "--duration", "30"], sent) == 0
    out, err = capsys.readouterr()
    assert (err, sent) == ("", [number])
    assert f"it was interrupted: {number.name}" in " ".join(out.split())
    assert "at rest" in out
    assert signal.getsignal(number) is usual


def test_a_robot_by_udp_starts_where_it_is_and_ends_at_rest(capsys: Capture) -> None:
    listen, commands = free_port(), free_port()
    joints = ["joint_1", "joint_2"]
    robot = Robot(listen, joints, [0.3, 0.8])
    stick = threading.Thread(target=jog_for_a_second, args=(robot, commands))
    stick.start()
    arguments = ("--udp", robot.address, "--listen", f"127.0.0.1:{listen}", "--commands", f"127.0.0.1:{commands}")
    code = run(["servo", "rr_planar", *arguments, "--duration", "1.8", "--no-browser"])
    stick.join()
    robot.close()
    out, err = capsys.readouterr()
    assert (code, err) == (0, "")
    assert "the time was over" in out
    assert robot.heard[0]["joint_names"] == joints
    np.testing.assert_allclose(robot.heard[0]["theta"], [0.3, 0.8], atol=0.01)
    thetas = np.array([each["theta"] for each in robot.heard])
    assert np.ptp(thetas[:, 0]) < 1e-9
    assert 0.2 < thetas[-1, 1] - 0.8 < 0.7  # 0.4 rad/s for a second and a timeout
    assert robot.heard[-1]["theta_dot"] == [0.0, 0.0]


def test_a_robot_on_a_serial_port(capsys: Capture) -> None:
    ours, theirs = os.openpty()
    robot = threading.Thread(target=tell_for_a_second, args=(ours,))
    robot.start()
    code = run(["servo", "rr_planar", "--serial", f"{os.ttyname(theirs)}:115200", "--duration", "0.6", "--no-browser"])
    robot.join()
    lines = os.read(ours, 65536).splitlines()
    for end in (ours, theirs):
        os.close(end)
    assert (code, capsys.readouterr().err) == (0, "")
    assert lines[-1].split(b"*")[0].endswith(b",0.000000,0.000000,E5")


def tell_for_a_second(end: int) -> None:
    """A robot that stands at (0.3, 0.8), said at 100 Hz."""
    for number in range(100):
        body = b"%d,0.3,0.8" % number
        os.write(end, body + b"*%02X\n" % checksum(body))
        time.sleep(0.01)


def jog_for_a_second(robot: Robot, port: int) -> None:
    """A stick on UDP that turns joint_2 by 0.4 rad/s, from the robot's first setpoint on."""
    end = time.monotonic() + 20
    while not robot.heard and time.monotonic() < end:
        time.sleep(0.01)
    end = time.monotonic() + 1.0
    with socket.socket(type=socket.SOCK_DGRAM) as stick:
        while time.monotonic() < end:
            stick.sendto(json.dumps({"jog": {"joint_2": 0.4}}).encode(), ("127.0.0.1", port))
            time.sleep(0.03)


def test_a_robot_that_says_nothing_is_never_moved(capsys: Capture) -> None:
    with socket.socket(type=socket.SOCK_DGRAM) as mute:
        mute.bind(("127.0.0.1", 0))
        mute.settimeout(0.1)
        udp = f"127.0.0.1:{mute.getsockname()[1]}"
        arguments = ["--duration", "0.5", "--no-browser", "--udp", udp, "--listen", "127.0.0.1:0"]
        assert run(["servo", "scara", *arguments]) == 1
        out, err = capsys.readouterr()
        assert err == ""
        assert "never moved" in out
        assert "at last because: no joint state has arrived" in out
        with pytest.raises(TimeoutError):
            mute.recv(1)


@pytest.mark.parametrize("typed", [["--rate", "5"], ["--duration", "-1"], ["--velocity", "-1"], ["--tolerance", "0"]])
def test_what_cannot_be_is_refused_before_anything_is_opened(typed: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def opened(*arguments: Any, **options: Any) -> None:
        raise AssertionError("opened")

    monkeypatch.setattr("twistarm.cli.commands.driving.Viewer", opened)
    for name in ("UdpSink", "UdpFeedback", "SimulatedJoints"):
        monkeypatch.setattr(f"twistarm.cli.robot.{name}", opened)
    assert run(["servo", "scara", "--no-browser", *typed]) == 2


def test_options_reach_the_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    given: dict[str, Any] = {}

    def noted(arm: Any, source: Any, sink: Any, feedback: Any, **options: Any) -> Any:
        given.update(options, source=source)
        return stream(arm, source, sink, feedback, **{**options, "duration": 0.05})

    monkeypatch.setattr("twistarm.cli.commands.driving.run", noted)
    options = "--velocity-mode --command-timeout 0.5 --feedback-timeout 300 ms --tolerance 0.1 rad --margin 0.02 "
    options += "--on-unreachable stop"
    udp = ("--udp", "127.0.0.1:9", "--listen", "127.0.0.1:0")
    assert run(["servo", "rr_planar", *options.split(), *udp, "--no-browser"]) == 1  # no robot is there
    assert (given["command_timeout"], given["feedback_timeout"]) == (0.5, pytest.approx(0.3))
    assert given["tolerance"].tolist() == pytest.approx([0.1, 0.1])
    assert given["velocity_mode"]
    assert (given["settings"]().position_margin, given["settings"]().on_unreachable) == (0.02, "stop")
    assert given["source"].timeout == 0.5  # the page's commands hold as long


def test_a_robot_that_went_is_not_said_to_be_at_rest(capsys: Capture) -> None:
    listen = free_port()
    robot = Robot(listen, ["joint_1", "joint_2"], [0.3, 0.8])
    leave = threading.Thread(target=robot.leave)
    leave.start()
    arguments = ("--udp", robot.address, "--listen", f"127.0.0.1:{listen}", "--duration", "1.2", "--no-browser")
    assert run(["servo", "rr_planar", *arguments]) == 1
    leave.join()
    out = " ".join(capsys.readouterr().out.split())
    assert "commanded to rest; the last setpoint did not get through" in out
    assert f"nobody listens at {robot.address} (" in out
    assert "at last because: the last joint state is" in out
