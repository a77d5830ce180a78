"""Files from strangers: one of each kind that wants to run code, to read a file outside, or to wait for ever."""

from __future__ import annotations

import json
import os
import signal
import struct
import subprocess
import sys
import time
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.sax.saxutils import quoteattr

import pytest

from twistarm import diagnose, load_arm
from twistarm.support.errors import DescriptionError
from xacro_text import ARM, MANIFEST, XMLNS, as_xacro, lay

TOKEN = "canary-4711"  # Of the secrets beside the package.

_events: list[str] = []
_watched: list[str] = []


def _note(event: str, details: tuple[object, ...]) -> None:
    if not _watched:
        return
    if event == "open" and isinstance(details[0], (str, bytes)):
        real = os.path.realpath(os.fsdecode(details[0]))
        if real.startswith((_watched[0], "/dev/", "/etc/passwd")) and not real.endswith("package.xml"):  # for its name
            _events.append(f"open {real}")
    elif event in ("os.system", "subprocess.Popen", "os.exec", "os.posix_spawn", "os.fork", "socket.connect"):
        _events.append(event)


sys.addaudithook(_note)


@pytest.fixture
def watched(tmp_path: Path) -> Iterator[list[str]]:
    """Files opened outside and commands run."""
    _events.clear()
    _watched.append(str(tmp_path.resolve() / "outside"))
    try:
        yield _events
    finally:
        _watched.clear()


@dataclass(frozen=True)
class Nasty:
    """The code that it is answered with, the files of `pkg`, the first of which is loaded, and how more is made."""

    code: str
    files: dict[str, str] = field(default_factory=dict)
    make: Callable[[Path], object] = field(default=lambda folder: None)


def xacro(code: str, inside: str, make: Callable[[Path], object] = lambda folder: None, **files: str) -> Nasty:
    return Nasty(code, {"arm.xacro": as_xacro(inside), **{f"{name}.xacro": text for name, text in files.items()}}, make)


def expression(text: str, code: str = "xacro-expression-refused") -> Nasty:
    """Through an argument, so that braces and parentheses are not xacro's."""
    return xacro(code, f'<xacro:arg name="evil" default={quoteattr(text)}/><link name="${{$(arg evil)}}"/>')


def include(name: str, code: str = "file-outside-packages", make: Callable[[Path], object] = lambda f: None) -> Nasty:
    return xacro(code, f'<xacro:include filename="{name}"/>', make)


def mesh(name: str, code: str, make: Callable[[Path], object]) -> Nasty:
    shape = f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
    return Nasty(code, {"arm.urdf": ARM.replace('<link name="upper"/>', f'<link name="upper">{shape}</link>')}, make)


def text(name: str, content: str | bytes) -> Callable[[Path], object]:
    return lambda folder: (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)


def linked(name: str, target: str) -> Callable[[Path], object]:
    return lambda folder: (folder / name).symlink_to(target)


def linked_package(folder: Path) -> None:
    """A folder that seems to be a package of the reader's."""
    hidden = lay(folder.parent / "outside/ws/hidden", {"package.xml": MANIFEST("hidden"), "key.yaml": f"key: {TOKEN}"})
    (folder / "found").mkdir()
    for name in ("package.xml", "key.yaml"):
        (folder / "found" / name).symlink_to(hidden / name)


def archive(folder: Path) -> None:
    with zipfile.ZipFile(folder / "a.3mf", "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("3D/3dmodel.model", bytes(10_000_000))


def giant(folder: Path) -> None:
    with (folder / "giant.xacro").open("wb") as file:
        file.truncate(50_000_000)


ENTITY = '<!DOCTYPE robot [<!ENTITY s SYSTEM "file://@SECRET">]>'
GLTF = {
    "asset": {"version": "2.0"},
    "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "buffers": [{"uri": "%2e%2e/outside/secret.bin", "byteLength": 36}],
}
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
    "a URI": include("file://@SECRET"),
    "a device": include("/dev/zero"),
    "a pipe": include("pipe", "file-unreadable", make=lambda folder: os.mkfifo(folder / "pipe")),
    "a giant": include("giant.xacro", "file-unreadable", make=giant),
    "itself": include("arm.xacro", "xacro-failed"),
    "YAML outside": xacro("file-outside-packages", "<a b=\"${xacro.load_yaml('@SECRET')}\"/>"),
    "an object in YAML": xacro(
        "xacro-failed",
        "<a b=\"${xacro.load_yaml('a.yaml')}\"/>",
        text("a.yaml", "a: !!python/object/apply:os.system ['touch @MARKER']"),
    ),
    "an external entity": Nasty(
        "xml-malformed", {"arm.urdf": ARM.replace("<robot", f"{ENTITY}<robot").replace("tiny", "&s;")}
    ),
    "a package by a linked manifest": xacro(
        "file-outside-packages", "<a b=\"${xacro.load_yaml('$(find hidden)/key.yaml')}\"/>", linked_package
    ),
    "a mesh that is a pipe": mesh("a.stl", "mesh-missing", lambda folder: os.mkfifo(folder / "a.stl")),
    "a mesh that is a link": mesh("a.stl", "mesh-missing", linked("a.stl", "../outside/secret.bin")),
    "a buffer outside": mesh("a.gltf", "mesh-unreadable", text("a.gltf", json.dumps(GLTF))),
    "a material outside": mesh(
        "a.obj", "mesh-unreadable", text("a.obj", "mtllib ../outside/secret.mtl\n" + FACES)
    ),
    "an entity in COLLADA": mesh("a.dae", "mesh-unreadable", text("a.dae", ENTITY.encode("utf-16"))),
    "an archive": mesh("a.3mf", "mesh-unreadable", archive),
    "a count that lies": mesh(
        "a.stl", "mesh-unreadable", text("a.stl", bytes(80) + struct.pack("<I", 4_294_967_295) + bytes(500))
    ),
}  # fmt: skip


def laid(case: Nasty, folder: Path) -> Path:
    """The description in a package, and secrets in another package beside it."""
    places = {"@SECRET": str(folder / "outside/secret.xacro"), "@MARKER": str(folder / "outside/command_ran")}

    def filled(content: str) -> str:
        for name, place in places.items():
            content = content.replace(name, place)
        return content

    secrets = dict.fromkeys(("secret.yaml", "secret.bin", "secret.mtl"), f"key: {TOKEN}\n")
    robot = f'<robot {XMLNS}><link name="{TOKEN}"/></robot>'
    lay(folder / "outside", {**secrets, "secret.xacro": robot})
    lay(folder / "pkg", {"package.xml": MANIFEST("pkg")})
    path = lay(folder / "pkg", {name: filled(content) for name, content in case.files.items()}) / next(iter(case.files))
    case.make(folder / "pkg")
    return path


@pytest.mark.parametrize("name", NASTY)
def test_nothing_runs_and_nothing_outside_is_read(name: str, tmp_path: Path, watched: list[str]) -> None:
    case = NASTY[name]
    path = laid(case, tmp_path)
    watched.clear()
    try:
        found, told = [one.code for one in diagnose(load_arm(path, tip="tool0"))], ""
    except DescriptionError as error:
        found, told = [one.code for one in error.findings], str(error)
    assert watched == []
    assert case.code in found
    assert TOKEN not in told
    assert "\n" not in told
    assert not (tmp_path / "outside/command_ran").exists()


def test_the_canary_sings(tmp_path: Path, watched: list[str]) -> None:
    """The test above can fail: xacro by itself reads the secret."""
    import xacro as program

    path = laid(NASTY["an absolute include"], tmp_path)
    watched.clear()
    assert TOKEN in program.process_file(str(path), verbosity=0).toxml()
    assert watched


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
