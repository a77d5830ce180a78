"""What ends the program: signals, as whoever sends them expects it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signals")


def ran(program: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)


PROGRAM = """
import signal, sys
from twistarm.support.interrupts import end_by, ended_like_ctrl_c
signal.signal(signal.SIGHUP, {hangup})
with ended_like_ctrl_c() as sent:
    try:
        signal.raise_signal(signal.{sent})
        print("goes on")
    except KeyboardInterrupt:
        pass
    finally:
        print("at rest", flush=True)
end_by(sent)
"""


@pytest.mark.parametrize(
    ("sent", "hangup", "said", "code"),
    [
        ("SIGTERM", "signal.SIG_DFL", "at rest\n", -signal.SIGTERM),
        ("SIGHUP", "signal.SIG_DFL", "at rest\n", -signal.SIGHUP),
        ("SIGHUP", "signal.SIG_IGN", "goes on\nat rest\n", 0),  # under nohup
    ],
)
def test_a_signal_ends_the_program_unless_it_is_ignored(sent: str, hangup: str, said: str, code: int) -> None:
    done = ran(PROGRAM.format(sent=sent, hangup=hangup))
    assert (done.stdout, done.returncode) == (said, code)


SENT_AT_AN_IMPORT = """
import os, signal, sys

class Sender:
    def find_spec(name, path=None, target=None):
        if name == "{module}":
            os.kill(os.getpid(), signal.{sent})

sys.meta_path.insert(0, Sender)
sys.argv = ["twistarm", "info", "rr_planar"]
from twistarm.cli import main
main()
"""


@pytest.mark.parametrize(
    ("module", "sent"),
    [("numpy", "SIGINT"), ("pinocchio", "SIGTERM"), pytest.param("typer", "SIGINT", marks=pytest.mark.slow)],
)
def test_a_signal_ends_it_without_a_word_from_its_first_line_on(module: str, sent: str) -> None:
    """While it is loaded and while it loads an arm."""
    done = ran(SENT_AT_AN_IMPORT.format(module=module, sent=sent))
    assert (done.stdout, done.stderr, done.returncode) == ("", "", -getattr(signal, sent))


SENT_WHILE_IT_DRAWS = """
import os, signal, sys
from twistarm.cli import application
from twistarm.cli.commands import checking
checking.crosscheck = lambda *_, **__: os.kill(os.getpid(), signal.{sent})
sys.argv = ["twistarm", "check", "rr_planar"]
application.program()
"""


@pytest.mark.usefixtures("hangups")
@pytest.mark.parametrize("sent", ["SIGINT", "SIGHUP"])
def test_the_cursor_comes_back_whatever_ends_it(sent: str, tmp_path: Path) -> None:
    ours, terminal = os.openpty()
    program = SENT_WHILE_IT_DRAWS.format(sent=sent)
    env = {**os.environ, "TERM": "xterm-256color"}
    with subprocess.Popen(
        [sys.executable, "-c", program], cwd=tmp_path, env=env, stdout=terminal, stderr=terminal
    ) as it:
        os.close(terminal)
        drawn = b""
        with suppress(OSError):  # the other side is closed
            while part := os.read(ours, 4096):
                drawn += part
    os.close(ours)
    assert it.returncode == -getattr(signal, sent)
    assert b"\x1b[?25l" in drawn, "it was hidden"
    assert drawn.rpartition(b"\x1b[?25l")[2].count(b"\x1b[?25h") == 1
    assert b"Traceback" not in drawn


STREAM = """
import os, signal
from twistarm import load_arm
from twistarm.control.servo import JogCommand
from twistarm.control.stream import Inbox, SimulatedJoints, run

arm = load_arm("rr_planar")
joints, inbox, rates = SimulatedJoints(arm, arm.ready), Inbox(), []
class Sink:
    def write(self, setpoint):
        rates.append(setpoint.theta_dot.copy())
        joints.write(setpoint)

def on_cycle(cycle):
    inbox.put("me", JogCommand([0.3, 0.0]), cycle.time)
    if len(rates) == 30:
        os.kill(os.getpid(), signal.{sent})

before = signal.getsignal(signal.{sent})
{prepare}
report = run(arm, inbox, Sink(), joints, duration=5.0, on_cycle=on_cycle, {options})
print(report.ending.name, report.reason, report.at_rest, abs(rates[29][0]) > 0.1, rates[-1].tolist())
print(signal.getsignal(signal.{sent}) is before, flush=True)
signal.raise_signal(signal.{sent})
"""


def test_a_stream_ends_at_rest_by_a_signal_which_then_has_its_usual_effect() -> None:
    done = ran(STREAM.format(sent="SIGTERM", prepare="", options=""))
    assert (done.stdout, done.stderr) == ("INTERRUPTED SIGTERM True True [0.0, 0.0]\nTrue\n", "")
    assert done.returncode == -signal.SIGTERM


def test_a_programs_own_handler_is_left_alone() -> None:
    prepare = "over = []; signal.signal(signal.SIGTERM, lambda *_: over.append(1))"
    done = ran(STREAM.format(sent="SIGTERM", prepare=prepare, options="until=lambda: bool(over)"))
    assert done.stdout.startswith("DONE  True True [0.0, 0.0]\nFalse\n")
    assert done.returncode == 0
