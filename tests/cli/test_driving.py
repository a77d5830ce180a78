"""`twistarm servo` and `follow`: on simulated joints and by UDP; what they refuse; how they end."""

from __future__ import annotations

import json
import os
import pty
import signal
import socket
import subprocess
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from test_cli import PROGRAM, Capture, error_of, printed
from twistarm import load_arm, load_trajectory, plan_joint, save_trajectory
from twistarm.cli.application import run
from twistarm.control.stream import Cycle
from twistarm.control.stream import run as stream
from twistarm.support.interrupts import ended_like_ctrl_c
from twistarm.viewer import Viewer


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


class Robot:
    """A robot of one's own on UDP: it tells where it is at 100 Hz, and goes where it is told."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(0.01)
        self.address = f"127.0.0.1:{self.socket.getsockname()[1]}"
        self.port = free_port()
        self.options = ("--udp", self.address, "--listen", f"127.0.0.1:{self.port}")
        self.heard: list[dict[str, Any]] = []
        self._state = {"joint_names": ["joint_1", "joint_2"], "theta": [0.3, 0.8]}
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._live, daemon=True)
        self._thread.start()

    def _live(self) -> None:
        while not self._end.is_set():
            self.socket.sendto(json.dumps(self._state).encode(), ("127.0.0.1", self.port))
            try:
                self.heard.append(json.loads(self.socket.recv(65536)))
            except (TimeoutError, ConnectionRefusedError):
                continue
            self._state = {key: self.heard[-1][key] for key in self._state}

    def wait(self) -> None:
        """Until it was told where to go."""
        end = time.monotonic() + 20.0
        while not self.heard and time.monotonic() < end:
            time.sleep(0.01)

    def close(self) -> None:
        self._end.set()
        self._thread.join()
        self.socket.close()


def report_of(capsys: Capture, *arguments: str, code: int = 0) -> tuple[Any, str]:
    """The JSON report of a command without a browser, and what it said on stderr."""
    assert run([*arguments, "--no-browser", "--json"]) == code
    out, err = capsys.readouterr()
    return json.loads(out), err


def test_it_runs_in_the_view_and_reports_as_json(capsys: Capture) -> None:
    report, err = report_of(capsys, "servo", "rover_arm", "--duration", "0.5")
    assert (report["arm"], report["ending"], report["ok"], report["rate"]) == ("rover_arm", "DURATION", True, 100.0)
    assert 25 <= report["cycles"] + report["missed"] <= 51
    assert report["statuses"] == {"STALE": report["cycles"]}  # nobody commands
    assert report["uncommanded"] == pytest.approx(report["cycles"] / 100)
    assert "http://127.0.0.1:" in err


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
        assert run(["servo", "scara", "--no-browser", "--duration", "30", "--json"], sent) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["ending"], report["at_rest"], sent) == ("INTERRUPTED", True, [number])
    assert signal.getsignal(number) is usual


def test_a_robot_by_udp_starts_where_it_is_and_ends_at_rest(capsys: Capture) -> None:
    robot, commands = Robot(), free_port()
    stick = threading.Thread(target=jog_for_a_second, args=(robot, commands))
    stick.start()
    commanded = ("--commands", f"127.0.0.1:{commands}", "--duration", "1.8")
    report, _ = report_of(capsys, "servo", "rr_planar", *robot.options, *commanded)
    stick.join()
    robot.close()
    assert report["ending"] == "DURATION"
    assert robot.heard[0]["joint_names"] == ["joint_1", "joint_2"]
    np.testing.assert_allclose(robot.heard[0]["theta"], [0.3, 0.8], atol=0.01)
    thetas = np.array([sent["theta"] for sent in robot.heard])
    assert np.ptp(thetas[:, 0]) < 1e-9
    assert 0.2 < thetas[-1, 1] - 0.8 < 0.7  # 0.4 rad/s for a second and a timeout
    assert robot.heard[-1]["theta_dot"] == [0.0, 0.0]


def jog_for_a_second(robot: Robot, port: int) -> None:
    """A stick on UDP that turns joint_2 by 0.4 rad/s, from the robot's first setpoint on."""
    robot.wait()
    end = time.monotonic() + 1.0
    with socket.socket(type=socket.SOCK_DGRAM) as stick:
        while time.monotonic() < end:
            stick.sendto(json.dumps({"jog": {"joint_2": 0.4}}).encode(), ("127.0.0.1", port))
            time.sleep(0.03)


def test_options_reach_the_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    given: dict[str, Any] = {}

    def noted(arm: Any, source: Any, sink: Any, feedback: Any, shared: Any, **options: Any) -> Any:
        given.update(options, source=source, shared=shared)
        return stream(arm, source, sink, feedback, shared, **{**options, "duration": 0.05})

    monkeypatch.setattr("twistarm.cli.commands.driving.stream.run", noted)
    options = "--velocity-mode --command-timeout 0.5 --feedback-timeout 300 ms --tolerance 0.1 rad --margin 0.02 "
    options += "--on-unreachable stop"
    udp = ("--udp", "127.0.0.1:9", "--listen", "127.0.0.1:0")
    assert run(["servo", "rr_planar", *options.split(), *udp, "--no-browser"]) == 1  # no robot is there
    assert (given["shared"].command_timeout, given["shared"].feedback_timeout) == (0.5, pytest.approx(0.3))
    assert given["shared"].tolerance.tolist() == pytest.approx([0.1, 0.1])
    assert given["shared"].velocity_mode
    settings = given["shared"].settings()
    assert (settings.position_margin, settings.on_unreachable) == (0.02, "stop")
    assert given["source"].timeout == 0.5  # the page's commands hold as long


# -- follow ------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    arm = load_arm("rr_planar")
    motion = plan_joint(arm, [[0.3, 0.8], [0.6, 0.4]], limits={"velocity": 1.0, "acceleration": 4.0})
    motion = replace(motion, labels=((0.1, "close gripper"),))
    return save_trajectory(motion, tmp_path_factory.mktemp("follow") / "motion.json")


def test_simulated_joints_follow_it_to_its_end(capsys: Capture, file: Path, tmp_path: Path) -> None:
    recording = tmp_path / "run.mcap"
    report, err = report_of(capsys, "follow", "rr_planar", str(file), "--record", str(recording))
    np.testing.assert_allclose(load_trajectory(load_arm("rr_planar"), recording).waypoints[-1], [0.6, 0.4], atol=1e-6)
    assert report["written"] == [str(recording)]
    assert (report["completed"], report["ending"], report["at"]) == (True, "ARRIVED", report["duration"])
    assert set(report["largest_error"]) == set(report["largest_lag"]) == {"joint_1", "joint_2"}
    assert report["loop"]["at_rest"]
    assert "s: close gripper" in err
    assert "run.mcap" in error_of(capsys, "follow", "rr_planar", str(file), "--no-browser", "--record", str(recording))


def test_an_arm_elsewhere_is_told_in_degrees_and_moved_on_request(capsys: Capture, file: Path) -> None:
    typed = ["follow", "rr_planar", str(file), "--no-browser", "--theta", "20 40"]
    out = printed(capsys, *typed, code=1)
    assert all(word in out for word in ("joint_1 2.8113°", "joint_2 5.8366°", "--approach"))
    assert "the motion is done" in printed(capsys, *typed, "--approach")


def take_terminal(terminal: int) -> None:
    """In the child: the terminal is its own, and it stands in its foreground."""
    import fcntl
    import termios

    fcntl.ioctl(terminal, termios.TIOCSCTTY, 0)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such terminals")
def test_space_pauses_and_resumes_and_q_stops(file: Path) -> None:
    ours, theirs = pty.openpty()
    command = [str(PROGRAM), "follow", "rr_planar", str(file), "--no-browser", "--speed", "0.2", "--json"]
    with subprocess.Popen(
        command, stdin=theirs, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=lambda: take_terminal(theirs),
    ) as process:  # fmt: skip
        try:
            assert process.stderr is not None
            for line in process.stderr:
                if line.startswith("space pauses"):
                    break
            for pause, key in ((0.8, b" "), (1.0, b" "), (0.5, b"q")):
                time.sleep(pause)
                os.write(ours, key)
            out, _ = process.communicate(timeout=30)
        finally:
            process.kill()
    report = json.loads(out)
    assert (process.returncode, report["ending"], report["completed"]) == (1, "STOPPED", False)
    assert 0.2 < report["loop"]["uncommanded"] < 2.0
    assert 0.0 < report["at"] < report["duration"]
    for end in (ours, theirs):
        os.close(end)


def test_ctrl_c_ends_it_at_rest(capsys: Capture, file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("twistarm.cli.commands.driving.obey", lambda *_: os.kill(os.getpid(), signal.SIGINT))
    report, _ = report_of(capsys, "follow", "rr_planar", str(file), code=1)
    assert (report["ending"], report["loop"]["at_rest"]) == ("INTERRUPTED", True)
