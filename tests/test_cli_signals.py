"""What ends `view` and `servo`: signals, as whoever sends them expects it."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signals")

PROGRAM = """
import signal, sys
from twistarm.cli.signals import ended_like_ctrl_c
signal.signal(signal.SIGHUP, {hangup})
with ended_like_ctrl_c():
    try:
        signal.raise_signal(signal.{sent})
        print("goes on")
    finally:
        print("at rest", flush=True)
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
    program = PROGRAM.format(sent=sent, hangup=hangup)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert (done.stdout, done.returncode) == (said, code)
