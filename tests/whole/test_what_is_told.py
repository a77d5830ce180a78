"""Names from files are text wherever they are shown, and nothing tells where on the machine the arm lies."""

from __future__ import annotations

import base64
import json
import re
import zlib
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from html import escape
from itertools import pairwise
from pathlib import Path

import pytest

from twistarm import InputError, load_arm
from twistarm.arm.baking import text_of
from twistarm.cli.application import run
from twistarm.cli.output import print_json
from twistarm.support.errors import printable
from urdf_text import joint, robot, two_joints, write
from xacro_text import MANIFEST, XMLNS, lay

FAKE = "FAKE"  # What a name would make a line of its own begin with.

NAMES = {
    "clears the screen": "a\x1b[2Jb",
    "a colour by C1": "a\x9b31mb",
    "another direction": "a\u202eb",
    "a line": f"a\n{FAKE}: all engines agree",
    "a next line": f"a\x85{FAKE}",
    "a link": "[link=https://example.invalid]a[/link]",
    "markup that ends nothing": "a[/]b",
    "a backslash": "a\\",
    "half a character": "a\ud800b",
    "a long name": "n" * 3000,
}
QUICK = ("a colour by C1", "a line", "a link")


def in_urdf(name: str) -> None:
    """As the robot, the tip and a joint."""
    shown = escape(name).replace("\n", "&#10;")
    parts = joint("a", "base_link", "upper"), joint(shown, "upper", shown)
    write(Path(), robot(*parts, links=("base_link", "upper", shown), name=shown))


def in_baked(name: str) -> None:
    arm, links = load_arm(write(Path(), two_joints())), {"base": name, "tip": name, "tip_link": name}
    states = {"named_states": {name: arm.ready}, "description": None}
    write(Path(), text_of(replace(arm, name=name, joint_names=("a", name), source=name, **links, **states)), "arm.json")


CARRIERS: dict[Callable[[str], None], tuple[str, ...]] = {
    in_urdf: (
        "info arm.urdf", "info arm.urdf --json", "fk arm.urdf", "jacobian arm.urdf", "ik arm.urdf --xyz 0.1 0.2 0.3",
        "plan arm.urdf --to 10 20", "check arm.urdf --samples 5", "doctor arm.urdf", "doctor arm.urdf --json",
        "bake arm.urdf -o out.json --force",
    ),
    in_baked: ("info arm.json", "info arm.json --json", "ik arm.json --xyz 1 2 3"),
}  # fmt: skip
"""What writes a name into the folder, and the commands that print it."""


@pytest.mark.parametrize("carrier", CARRIERS)
@pytest.mark.parametrize("what", [pytest.param(w, marks=() if w in QUICK else pytest.mark.slow) for w in NAMES])
def test_every_name_is_shown(
    carrier: Callable[[str], None], what: str, capsys: pytest.CaptureFixture[str], here: Path
) -> None:
    name = NAMES[what]
    if carrier is in_urdf and re.search("[\0-\x08\x0e-\x1f\ud800]", name):
        pytest.skip("no XML can hold it")
    carrier(name)
    for command in CARRIERS[carrier]:
        capsys.readouterr()
        code, said = run(command.split()), "".join(capsys.readouterr())
        assert code in (0, 1, 2)
        assert "fault of twistarm" not in said
        assert [c for c in said if not (c.isprintable() or c in "\n\xa0")] == []
        assert not any(line.strip(" │").startswith(FAKE) for line in said.splitlines())
        assert command != "info arm.urdf" or len(name) > 100 or printable(name) in said


def test_json_shows_what_a_terminal_would_obey_as_json_escapes_it(capsys: pytest.CaptureFixture[str]) -> None:
    name = "a\x1b[31m\x9b31m\u202e\ud800ξ"
    print_json({"name": name})
    shown = capsys.readouterr().out
    assert shown == '{\n  "name": "a\\u001b[31m\\u009b31m\\u202e\\ud800ξ"\n}\n'
    assert json.loads(shown) == {"name": name}


# -- places ------------------------------------------------------------------------------------------------------------

CANARY = "canarytown"  # The user, and every folder on the way to the arm.

MESHES = (
    "file://@HERE/absent.stl", "$(find arm)/absent.stl", "@HERE/broken.obj", "$(find nowhere)/a.stl",
    "package://nowhere/b.stl", "file://$(find arm)/broken.stl", "../elsewhere/c.dae", "$(cwd)/d.ply",
)  # fmt: skip

COMMANDS = (
    "view ARM -o OUT/page.html",
    "plan ARM --to 0.1 0.2 --velocity 1 --acceleration 1 -o OUT/motion.csv -o OUT/motion.json",
    "freeze ARM -o OUT/golden.json",
    "bake ARM -o OUT/arm.json -o OUT/arm.hpp",
    "doctor ARM --fix -o OUT/repaired.urdf",
    "init ARM -o BESIDE/arm.toml",
    "ik ARM --targets OUT/targets.csv -o OUT/answers.csv",
    "info ARM --json",
    "doctor ARM --json",
    "check ARM --json",
)


@pytest.fixture
def arm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The xacro of an arm, with everything wrong that is told about with a path."""
    here = tmp_path.resolve() / CANARY / f"with {CANARY} space" / "arm"
    shapes = "".join(f'<visual><geometry><mesh filename="{mesh}"/></geometry></visual>' for mesh in MESHES)
    parts = joint("a", "base_link", "upper", inside='<axis xyz="0 0 2"/>'), joint("b", "upper", "tool0")
    text = robot(*parts, name="arm").replace('<link name="upper"/>', f'<link name="upper">{shapes}</link>')
    ours = '<gazebo a="$(find nowhere)/x" b="$(find copy)/y" c="$(cwd)"/>'
    ours += '<gazebo a="${xacro.abs_filename(\'e\')}" b="$(optenv HOME)"/>'
    text = text.replace('<robot name="arm">', f'<robot name="arm" {XMLNS}>{ours}').replace("@HERE", str(here))
    broken = {f"broken.{ending}": "no mesh" for ending in ("stl", "obj")}
    lay(here, {"package.xml": MANIFEST("arm"), "arm.xacro": text, **broken, "../copy/urdf/x": ""})
    lay(here, {"arm.srdf": "<robot name='arm'><group/></robot>"})
    lay(tmp_path / "out", {"targets.csv": "x,y,z\n0.1,0.1,1.0\n9,9,9\n"})
    for name, value in {"HOME": str(here.parent), **dict.fromkeys(("USER", "LOGNAME", "HOSTNAME"), CANARY)}.items():
        monkeypatch.setenv(name, value)
    return here / "arm.xacro"


def inside(data: bytes) -> bytes:
    """What was written, and what lies in it by base64, packed or not."""
    parts = [data]
    for text in re.findall(rb"[A-Za-z0-9+/]{40,}", data):
        parts.append(base64.b64decode(text[: len(text) // 4 * 4]))
        with suppress(zlib.error):
            parts.append(zlib.decompressobj(wbits=47).decompress(parts[-1]))  # gzip or zlib
    return b"\n".join(parts).lower()


@pytest.mark.parametrize("command", COMMANDS)
def test_what_is_written_tells_no_place(command: str, arm: Path, here: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """From another folder, with the arm's whole path typed."""
    words = [word.replace("OUT", "out").replace("BESIDE", str(arm.parent)) for word in command.split()]
    code = run([str(arm) if word == "ARM" else word for word in words])
    told = capfd.readouterr()
    assert code in (0, 1), told.err
    written = [Path(word).read_bytes() for before, word in pairwise(words) if before == "-o"]
    for data in written or [told.out.encode()]:
        assert data
        at = inside(data).find(CANARY.encode())
        assert at < 0, inside(data)[max(0, at - 200) : at + 100]


def test_the_page_that_is_served_tells_no_place(arm: Path) -> None:
    pytest.importorskip("meshcat")
    from twistarm.viewer.messages import failure
    from twistarm.viewer.parts.arm_data import doctor_findings

    loaded = load_arm(arm)
    assert any(CANARY in one.what for one in loaded.findings), "on the terminal a whole path helps"
    assert all(CANARY not in str(one) for one in doctor_findings(loaded)["findings"])
    assert CANARY not in str(failure(InputError(f"cannot write {arm}")))
