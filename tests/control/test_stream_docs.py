"""docs/streaming.md: its clients are heard, its messages are understood."""

from __future__ import annotations

import re
import threading
from pathlib import Path
from types import SimpleNamespace

from twistarm.control.stream import Interlock, SimulatedJoints, UdpSource, Verifier, parse_command, run
from twistarm.control.stream.links.messages import heard_word

PAGE = (Path(__file__).parents[2] / "docs" / "streaming.md").read_text("utf-8")
CLIENT, SIGNED = re.findall(r"<!-- another program -->\n```python\n(.*?)```", PAGE, flags=re.S)

GAPS = {
    "[vx, vy, vz, wx, wy, wz]": "[0, 0, 0, 0, 0, 0]",
    '"twist": [...]': '"twist": [0, 0, 0, 0, 0, 0]',
    '"frame": ...': '"frame": "tool"',
    "[x, y, z]": "[0.5, 0, 0.5]",
    "[w, x, y, z]": "[1, 0, 0, 0]",
    '"pose": ...': '"pose": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]',
}


def test_the_client_moves_the_arm(rover):
    with UdpSource(rover) as source:
        program = compile(CLIENT.replace("9870", str(source.address[1])), "docs/streaming.md", "exec")
        joints = SimulatedJoints(rover, rover.ready)
        client = threading.Thread(target=lambda: exec(program, {}))
        client.start()
        run(rover, source, joints, joints, duration=0.6)
        client.join()
    assert rover.fk(joints.theta)[2, 3] > rover.fk(rover.ready)[2, 3] + 0.005


def test_what_another_program_signs_is_taken():
    names = {}
    exec(compile(SIGNED, "docs/streaming.md", "exec"), names)
    key = names["key"]
    verifier = Verifier(key)
    assert verifier.verified(names["signed"](b"{}")) == b"{}"


def test_every_command_of_the_table_is_one(rover):
    table = PAGE[PAGE.index("Commands, to") : PAGE.index("Each may have")]
    messages = re.findall(r"^\| `(\{.*?\})` \|", table, flags=re.M)
    words = [message for message in messages if "interlock" in message]
    assert (len(messages), len(words)) == (11, 4)
    for message in messages:
        for gap, filled in GAPS.items():
            message = message.replace(gap, filled)
        if message not in words:
            parse_command(rover, message)
        else:
            assert heard_word(SimpleNamespace(interlock=Interlock()), message.encode(), True)
