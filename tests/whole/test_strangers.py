"""Files from strangers: what would run code, read outside or wait for ever is refused in one line, or read right."""

from __future__ import annotations

import json
import os
import signal
import struct
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple
from xml.sax.saxutils import quoteattr

import pytest

from twistarm import Arm, diagnose, load_arm
from twistarm.arm.baking import text_of
from twistarm.checking.difference import golden_text
from twistarm.cli.application import run
from twistarm.support.errors import DescriptionError
from urdf_text import two_joints, write
from xacro_text import ARM, MANIFEST, XMLNS, as_xacro, lay

TOKEN = "canary-4711"  # Of the secrets beside the package.
SECONDS = 60  # A reader that takes longer waits for ever.

_seen: deque[str] = deque(maxlen=10_000)
STARTS = ("os.system", "subprocess.Popen", "os.exec", "os.posix_spawn", "os.fork", "socket.connect")


def _note(event: str, details: tuple[object, ...]) -> None:
    if event == "open" and isinstance(details[0], (str, bytes)):
        _seen.append(os.path.realpath(os.fsdecode(details[0])))
    elif event in STARTS:
        _seen.append(event)


sys.addaudithook(_note)


def seen_outside(folder: Path) -> list[str]:
    """Commands run and files opened beside the package, but for the name of another one."""
    places = (str(folder.resolve() / "outside"), "/dev/", "/etc/passwd", *STARTS)
    return [one for one in _seen if one.startswith(places) and not one.endswith("package.xml")]


@pytest.fixture(autouse=True)
def patience() -> Iterator[None]:
    def late(*_: object) -> None:
        raise TimeoutError("it waits for ever")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(SECONDS)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


Make = Callable[[Path], object]


class Nasty(NamedTuple):
    """The code that it is answered with, the files of `pkg`, the first of which is loaded, and how more is made."""

    code: str
    files: dict[str, str]
    make: Make = lambda folder: None


def xacro(code: str, inside: str, make: Make = lambda folder: None) -> Nasty:
    return Nasty(code, {"arm.xacro": as_xacro(inside)}, make)


def expression(text: str, code: str = "xacro-expression-refused") -> Nasty:
    """Through an argument, so that braces and parentheses are not xacro's."""
    return xacro(code, f'<xacro:arg name="evil" default={quoteattr(text)}/><link name="${{$(arg evil)}}"/>')


def include(name: str, code: str = "file-outside-packages", make: Make = lambda folder: None) -> Nasty:
    return xacro(code, f'<xacro:include filename="{name}"/>', make)


def mesh(name: str, code: str, make: Make) -> Nasty:
    shape = f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
    return Nasty(code, {"arm.urdf": ARM.replace('<link name="upper"/>', f'<link name="upper">{shape}</link>')}, make)


def text(name: str, content: str | bytes) -> Make:
    return lambda folder: (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)


def linked(name: str, target: str) -> Make:
    return lambda folder: (folder / name).symlink_to(target)


def sized(name: str, size: int) -> Make:
    return lambda folder: ((folder / name).touch(), os.truncate(folder / name, size))


ENTITY = '<!DOCTYPE robot [<!ENTITY s SYSTEM "file://@SECRET">]>'
GLTF = {"asset": {"version": "2.0"}, "buffers": [{"uri": "%2e%2e/outside/secret.bin", "byteLength": 36}]}
FACES = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n"

NASTY = {
    "an attribute of a class": expression("(lambda: ().__class__.__bases__[0].__subclasses__())()"),
    "the frame of a generator": expression("(i for i in [1]).gi_frame.f_back.f_globals"),
    "an attribute in a format": expression("'{0.__class__.__mro__}'.format(1)"),
    "the globals of a function": expression("xacro.load_yaml.__globals__['os'].system('touch @MARKER')"),
    "a builtin": expression("open('@SECRET').read()", "xacro-failed"),
    "a class made by type": expression("python.type(python.type(1))('X', (list,), dict())"),
    "a change of a namespace": expression("[0 for math['pi'] in [3]]"),
    "a document of a block": xacro("xacro-failed", '<xacro:property name="b"><a/></xacro:property>${b.ownerDocument}'),
    "code in a command": xacro("xacro-expression-refused", '<a b="$(eval x.__class__)"/>'),
    "an absolute include": include("@SECRET"),
    "a way up": include("$(find pkg)/../outside/secret.xacro"),
    "an optional way up": xacro(
        "file-outside-packages", '<xacro:include filename="../outside/secret.xacro" optional="true"/>'
    ),
    "a link to a file": include("link.xacro", make=linked("link.xacro", "../outside/secret.xacro")),
    "wildcards in a linked folder": include("linked/*.xacro", make=linked("linked", "../outside")),
    "a URI": include("file://@SECRET", "xacro-failed"),
    "a pipe": include("pipe", "file-unreadable", make=lambda folder: os.mkfifo(folder / "pipe")),
    "YAML outside": xacro("file-outside-packages", "<a b=\"${xacro.load_yaml('@SECRET')}\"/>"),
    "an object in YAML": xacro(
        "xacro-failed",
        "<a b=\"${xacro.load_yaml('a.yaml')}\"/>",
        text("a.yaml", "a: !!python/object/apply:os.system ['touch @MARKER']"),
    ),
    "an external entity": Nasty(
        "xml-malformed", {"arm.urdf": ARM.replace("<robot", f"{ENTITY}<robot").replace("tiny", "&s;")}
    ),
    "a mesh that is a pipe": mesh("a.stl", "mesh-missing", lambda folder: os.mkfifo(folder / "a.stl")),
    "a mesh that is a link": mesh("a.stl", "mesh-missing", linked("a.stl", "../outside/secret.bin")),
    "a buffer outside": mesh("a.gltf", "mesh-unreadable", text("a.gltf", json.dumps(GLTF))),
    "a material outside": mesh(
        "a.obj", "mesh-unreadable", text("a.obj", "mtllib ../outside/secret.mtl\n" + FACES)
    ),
    "an entity in COLLADA": mesh("a.dae", "mesh-unreadable", text("a.dae", ENTITY.encode("utf-16"))),
    "a count that lies": mesh(
        "a.stl", "mesh-unreadable", text("a.stl", bytes(80) + struct.pack("<I", 4_294_967_295) + bytes(500))
    ),
}  # fmt: skip


def laid(case: Nasty, folder: Path) -> Path:
    """The description in a package, and secrets in another package beside it."""
    outside = folder / "outside"
    secrets = dict.fromkeys(("secret.yaml", "secret.bin", "secret.mtl"), f"key: {TOKEN}\n")
    lay(outside, {**secrets, "secret.xacro": f'<robot {XMLNS}><link name="{TOKEN}"/></robot>'})
    lay(folder / "pkg", {"package.xml": MANIFEST("pkg")})
    for name, text in case.files.items():
        text = text.replace("@SECRET", f"{outside}/secret.xacro").replace("@MARKER", f"{outside}/command_ran")
        lay(folder / "pkg", {name: text})
    case.make(folder / "pkg")
    return folder / "pkg" / next(iter(case.files))


@pytest.mark.parametrize("name", NASTY)
def test_nothing_runs_and_nothing_outside_is_read(name: str, tmp_path: Path) -> None:
    path = laid(NASTY[name], tmp_path)
    _seen.clear()
    try:
        found, told = [one.code for one in diagnose(load_arm(path, tip="tool0"))], ""
    except DescriptionError as error:
        found, told = [one.code for one in error.findings], str(error)
    assert seen_outside(tmp_path) == []
    assert NASTY[name].code in found
    assert TOKEN not in told
    assert "\n" not in told
    assert not (tmp_path / "outside/command_ran").exists()


def test_the_canary_sings(tmp_path: Path) -> None:
    """The test above can fail: xacro by itself reads the secret."""
    import xacro as program

    path = laid(NASTY["an absolute include"], tmp_path)
    _seen.clear()
    assert TOKEN in program.process_file(str(path), verbosity=0).toxml()
    assert seen_outside(tmp_path)


@pytest.mark.parametrize("named", ["~/ros_ws/src", "../../../ros_ws/src"])
def test_an_arm_file_opens_no_package_far_from_it_but_its_meshes(
    named: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever wrote the archive knows where packages usually stand. A mesh is drawn, and cannot be quoted."""
    monkeypatch.setenv("HOME", str(tmp_path))
    secret = tmp_path / "ros_ws/src/secret"
    lay(secret, {"package.xml": MANIFEST("secret"), "urdf/key.xacro": "<robot/>", "meshes/cube.stl": "solid"})
    shape = '<visual><geometry><mesh filename="package://secret/meshes/cube.stl"/></geometry></visual>'
    text = as_xacro("").replace('<link name="upper"/>', f'<link name="upper">{shape}</link>')
    path = tmp_path / "Downloads/evil/arm/arm.toml"
    lay(path.parent, {"arm.toml": f'source = "arm.xacro"\npackage_dirs = ["{named}"]', "arm.xacro": text})
    description = load_arm(path).description
    assert description is not None
    assert description.links["upper"].visuals[0].mesh == secret / "meshes/cube.stl"
    key = '<xacro:include filename="$(find secret)/urdf/key.xacro"/>'
    lay(path.parent, {"arm.xacro": text.replace("<link", f"{key}<link", 1)})
    with pytest.raises(DescriptionError) as caught:
        load_arm(path)
    assert [one.code for one in caught.value.findings] == ["package-needed-not-found"]
    assert load_arm(path, package_dirs=[tmp_path / "ros_ws/src"]).n == 2  # whoever names it himself opens it


def test_a_module_beside_the_description_is_never_imported(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text(FACES)
    for name in ("trimesh", "collada", "xacro", "networkx", "lxml"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w')\n")
    program = (
        "import os, sys; from pathlib import Path; from twistarm.description.meshes import read_mesh;"
        f"os.chdir({str(tmp_path)!r}); sys.path.insert(0, ''); print(read_mesh(Path('a.obj')).triangles)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=100, check=False)
    assert done.stdout == "1\n", done.stderr
    assert not (tmp_path / "ran").exists()


@pytest.mark.slow
def test_ctrl_c_ends_what_takes_long(tmp_path: Path) -> None:
    path = laid(expression("9**9**9"), tmp_path)
    program = subprocess.Popen(
        [sys.executable, "-m", "twistarm.cli", "doctor", str(path)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        time.sleep(8.0)
        assert program.poll() is None
        program.send_signal(signal.SIGINT)
        _, errors = program.communicate(timeout=20)
    finally:
        program.kill()
    assert "Traceback" not in errors


SRDF = '<robot name="tiny"><group name="arm"><chain base_link="base_link" tip_link="tool0"/></group></robot>'
LOG = "left,right,x,y,z\n" + "".join(f"{10 * k},{7 * k * k},0.1,0.2,1.0\n" for k in range(5))
RECORDING = "time [s],a.position [rad],b.position [rad]\n0,0.1,0\n1,0.1,0\n"
MOTORS = 'source = "arm.urdf"\n[actuators.left]\nratio = { a = 0.1 }\n[actuators.right]\nratio = { b = 0.1 }\n'

READERS: dict[str, str | Callable[[Arm], str]] = {
    "info in.urdf": two_joints(),
    "info in.xacro": two_joints(),
    "info in.toml": MOTORS,
    "fk in.json": text_of,
    "check arm.urdf --samples 5 --against in.json": golden_text,
    "fk arm.urdf --configurations in.csv": "a,b\n" + "0.1,0.2\n" * 3,
    "ik arm.urdf --targets in.csv": "x,y,z\n0.1,0.2,0.3\n",
    "view arm.urdf --play in.csv -o out.html": RECORDING,
    "wiring motors.toml in.csv": LOG,
    "info arm.urdf --srdf in.srdf": SRDF,
    "info arm.urdf --limits in.yaml": "joint_limits: {a: {max_velocity: 0.1}}\n",
}
"""A command for each reader, and what an honest file holds."""

NO_FILES: dict[str, Callable[[Path], object]] = {
    "a FIFO": os.mkfifo,
    "a device": lambda path: path.symlink_to("/dev/zero"),
    "a folder": lambda path: path.mkdir(),
    "a link to itself": lambda path: path.symlink_to(path.name),
    "700 MB": lambda path: sized(path.name, 700_000_000)(path.parent),
}
TEXTS: dict[str, Callable[[str], str | bytes]] = {
    "no UTF-8": lambda good: b"\xff\xc0\x80" * 1000,
    "brackets": lambda good: b"[" * 1_000_000,
    "5,000 digits": lambda good: good.replace("0.1", "1" + "0" * 4999).replace('"1"', f'"{"1" * 5000}"'),
    "no number": lambda good: good.replace("0.1", "NaN").replace('"1"', '"NaN"'),
    "a name twice": lambda good: good + good.partition("\n")[2],
}
QUICK = ("a FIFO", "a link to itself", "no UTF-8", "5,000 digits", "a name twice")


@pytest.mark.parametrize("command", READERS)
@pytest.mark.parametrize(
    "nasty", [case if case in QUICK else pytest.param(case, marks=pytest.mark.slow) for case in (*NO_FILES, *TEXTS)]
)
def test_every_reader_refuses_in_one_line_or_is_right(
    command: str, nasty: str, here: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    arm, good = load_arm(write(here, two_joints())), READERS[command]
    write(here, MOTORS, "motors.toml")
    (name,) = (word for word in command.split() if word.startswith("in."))
    if nasty in NO_FILES:
        NO_FILES[nasty](here / name)
    else:
        text(name, TEXTS[nasty](good(arm) if callable(good) else good))(here)
    code, said = run(command.split()), capfd.readouterr().err
    assert code == 2 or (code in (0, 1) and nasty in TEXTS)
    assert "Traceback" not in said
    assert "fault of twistarm" not in said
    if code == 2:
        (line,) = [line for line in said.splitlines() if not line.startswith(("note: ", "warning: "))]
        assert line.startswith("error: ")
        assert name in line
        assert len(line) < 2000
