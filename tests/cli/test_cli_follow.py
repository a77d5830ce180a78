"""`twistarm follow`: a file on simulated joints and on a robot of its own, keys, and what is refused."""

from __future__ import annotations

import json
import os
import pty
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from test_cli import PROGRAM, Capture, error_of, printed
from test_cli_servo import Robot, free_port
from twistarm import load_arm, load_trajectory, plan_joint
from twistarm.cli.application import run


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    arm = load_arm("rr_planar")
    motion = plan_joint(arm, [[0.3, 0.8], [0.6, 0.4]], kind="quintic", limits={"velocity": 1.0, "acceleration": 4.0})
    motion = replace(motion, labels=((0.1, "close gripper"),))
    return motion.to_json(tmp_path_factory.mktemp("follow") / "motion.json")


def follow(file: Path, *options: str) -> list[str]:
    return ["follow", "rr_planar", str(file), "--no-browser", *options]


def test_simulated_joints_follow_it_to_its_end(capsys: Capture, file: Path, tmp_path: Path) -> None:
    recording = tmp_path / "run.mcap"
    assert run(follow(file, "--json", "--record", str(recording))) == 0
    arm = load_arm("rr_planar")
    np.testing.assert_allclose(load_trajectory(arm, recording).waypoints[-1], [0.6, 0.4], atol=1e-6)
    out, err = capsys.readouterr()
    answer = json.loads(out)
    assert answer["written"] == [str(recording)]
    assert (answer["completed"], answer["ending"], answer["at"]) == (True, "ARRIVED", answer["duration"])
    assert set(answer["largest_error"]) == set(answer["largest_lag"]) == {"joint_1", "joint_2"}
    assert answer["loop"]["at_rest"]
    assert "rr_planar at http://" in err
    assert "s: close gripper" in err
    assert "run.mcap exists; --force replaces it" in error_of(capsys, *follow(file, "--record", str(recording)))


def test_an_arm_elsewhere_is_told_in_degrees_and_moved_on_request(capsys: Capture, file: Path) -> None:
    typed = follow(file, "--theta", "20 40")
    out = " ".join(printed(capsys, *typed, code=1).split())
    assert "the arm is not where the motion begins: joint_1 2.8113°, joint_2 5.8366° away; --approach moves it" in out
    assert "the motion is done" in printed(capsys, *typed, "--approach")


def test_a_robot_by_udp_is_told_the_motion_from_where_it_is(capsys: Capture, file: Path) -> None:
    listen = free_port()
    robot = Robot(listen, ["joint_1", "joint_2"], [0.3, 0.8])
    code = run(follow(file, "--udp", robot.address, "--listen", f"127.0.0.1:{listen}", "--speed", "0.8"))
    robot.close()
    out, err = capsys.readouterr()
    assert (code, err) == (0, "")
    assert "at 80 % of its speed" in out
    theta = np.array([each["theta"] for each in robot.heard])
    times = np.array([each["time"] for each in robot.heard])
    np.testing.assert_allclose(theta[[0, -1]], [[0.3, 0.8], [0.6, 0.4]], atol=1e-3)
    assert robot.heard[-1]["theta_dot"] == [0.0, 0.0]
    # On the straight way from one to the other, however the computer's load delayed the cycles.
    np.testing.assert_allclose((theta[:, 0] - 0.3) / 0.3, (0.8 - theta[:, 1]) / 0.4, atol=1e-6)
    assert times[-1] - times[0] > 0.5


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such terminals")
def test_space_pauses_and_resumes_and_q_stops(file: Path) -> None:
    ours, theirs = pty.openpty()
    command = [str(PROGRAM), *follow(file, "--speed", "0.2", "--json")]
    with subprocess.Popen(
        command, stdin=theirs, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=lambda: take_terminal(theirs),
    ) as process:  # fmt: skip
        try:
            assert process.stderr is not None
            for line in process.stderr:
                if line.startswith("space pauses"):
                    break
            time.sleep(0.8)
            os.write(ours, b" ")
            time.sleep(1.0)
            os.write(ours, b" ")
            time.sleep(0.5)
            os.write(ours, b"q")
            out, _ = process.communicate(timeout=30)
        finally:
            process.kill()
    answer = json.loads(out)
    assert (process.returncode, answer["ending"], answer["completed"]) == (1, "STOPPED", False)
    assert 0.2 < answer["loop"]["uncommanded"] < 2.0
    assert 0.0 < answer["at"] < answer["duration"]
    for end in (ours, theirs):
        os.close(end)


def take_terminal(terminal: int) -> None:
    """In the child: the terminal is its own, and it stands in its foreground."""
    import fcntl
    import termios

    fcntl.ioctl(terminal, termios.TIOCSCTTY, 0)


def test_ctrl_c_ends_it_at_rest(capsys: Capture, file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("twistarm.cli.commands.driving.obey", lambda *told: os.kill(os.getpid(), signal.SIGINT))
    assert run(follow(file)) == 1
    out, err = capsys.readouterr()
    assert err == ""
    assert "it was interrupted" in out
    assert "at rest" in out


def test_a_motion_that_no_robot_can_follow_is_refused(capsys: Capture, file: Path, tmp_path: Path) -> None:
    message = json.loads(file.read_text())
    message["joint_names"][1] = "joint_two"
    other = tmp_path / "other.json"
    other.write_text(json.dumps(message))
    assert "joint_2" in error_of(capsys, *follow(other))
    message["joint_names"][1] = "joint_2"
    for point in message["points"]:
        for rate in ("velocities", "accelerations"):
            point.pop(rate, None)
    other.write_text(json.dumps(message))
    assert "jumps by" in error_of(capsys, *follow(other))
