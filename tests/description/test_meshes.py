"""The process that reads meshes: what it may take, what it says, and that it goes when nobody asks any more."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import trimesh

from hostile.mesh_case import lay
from hostile.meshes import CASES, fan, instances
from twistarm import diagnose, load_arm
from twistarm.description.meshes import MeshReader, UnreadableMeshError, loading, mesh_file, process, reader
from twistarm.description.meshes.mesh_file import RefusedError
from twistarm.support.errors import InputError, TwistarmError
from twistarm.viewer import Viewer
from twistarm.viewer.scene.arm_scene import Scene

SLOW = instances(4, 14)
"""A COLLADA file that no time is enough for."""


def box(path: Path) -> Path:
    trimesh.creation.box((0.1, 0.2, 0.3)).export(path)
    return path


def running(mark: Path) -> list[int]:
    """The readers of meshes whose environment names `mark`."""
    numbers = [int(entry.name) for entry in Path("/proc").iterdir() if entry.name.isdigit()]
    return [number for number in numbers if _reads(number, mark)]


def _reads(number: int, mark: Path) -> bool:
    try:
        marked = str(mark).encode() in Path(f"/proc/{number}/environ").read_bytes()
        return marked and b"twistarm.description.meshes.worker" in Path(f"/proc/{number}/cmdline").read_bytes()
    except OSError:
        return False


@pytest.mark.parametrize("ending", ["STL", "obj", "dae", "ply", "glb", "gltf"])
def test_every_format_that_is_read_comes_to_the_same_box(tmp_path: Path, ending: str) -> None:
    made = trimesh.creation.box((0.1, 0.2, 0.3)).export(file_type=ending.lower())
    for name, content in (made if ending == "gltf" else {f"model.{ending}": made}).items():
        (tmp_path / name).write_bytes(content.encode() if isinstance(content, str) else content)
    path = tmp_path / f"model.{ending}"
    with MeshReader() as meshes:
        (part,) = meshes.parts(path)
        assert len(part.faces) == 12
        assert meshes.length(path) == pytest.approx(0.3)


BOX = trimesh.creation.box((0.1, 0.2, 0.3))
BINARY, TEXT = BOX.export(file_type="stl"), BOX.export(file_type="stl_ascii").encode()
HEADED = b"solid of an exporter".ljust(80, b"\0") + BINARY[80:]
AS_A_BOX = {
    "bytes behind the last facet": BINARY + b"\n\0trailing",
    "bytes behind it, and a head as of text": HEADED + b"\n",
    "a text without its end": TEXT[: TEXT.rindex(b"endsolid")],
    "a text in capitals without its end": TEXT[: TEXT.rindex(b"endsolid")].upper(),
    "a text with space before it": b"\n \n" + TEXT,
}


@pytest.mark.parametrize("case", AS_A_BOX)
def test_an_stl_that_others_read_is_read(case: str, tmp_path: Path) -> None:
    (tmp_path / "a.stl").write_bytes(AS_A_BOX[case])
    with MeshReader() as meshes:
        (part,) = meshes.parts(tmp_path / "a.stl")
    assert len(part.faces) == 12
    np.testing.assert_allclose(np.ptp(part.vertices, axis=0), [0.1, 0.2, 0.3], rtol=1e-6)


AS_NOTHING = {
    "nothing": (b"", "it is empty"),
    "a text of nothing": (b"solid a\nendsolid a\n", "it holds no triangles"),
    "half a head": (BINARY[:60], "it is cut short"),
    "half of the facets": (BINARY[: 84 + 6 * 50 + 7], "it is cut short: 12 triangles are announced and 6 are there"),
    "half of a text": (TEXT[: TEXT.rindex(b"vertex")], "it is cut short in the middle of a facet"),
}


@pytest.mark.parametrize("case", AS_NOTHING)
def test_an_stl_that_is_none_is_named_for_what_it_is(case: str, tmp_path: Path) -> None:
    data, reason = AS_NOTHING[case]
    (tmp_path / "a.stl").write_bytes(data)
    with MeshReader() as meshes, pytest.raises(UnreadableMeshError) as caught:
        meshes.parts(tmp_path / "a.stl")
    assert caught.value.reason == reason


GREY = 0.212671 * 0.2 + 0.715160 * 0.4 + 0.072169 * 0.8
TRANSPARENT = '<transparent opaque="{}"><color>0.2 0.4 0.8 0.3</color></transparent>'
OPACITY = {
    "": 1.0,
    "<transparency><float>0.4</float></transparency>": 0.4,
    TRANSPARENT.replace(' opaque="{}"', ""): 0.3,
    TRANSPARENT.format("A_ONE"): 0.3,
    TRANSPARENT.format("A_ZERO"): 0.7,
    TRANSPARENT.format("RGB_ONE"): GREY,
    TRANSPARENT.format("RGB_ZERO"): 1 - GREY,
    TRANSPARENT.format("A_ONE") + "<transparency><float>0.5</float></transparency>": 0.15,
    TRANSPARENT.format("RGB_ZERO") + "<transparency><float>0.5</float></transparency>": 1 - GREY / 2,
}


@pytest.mark.parametrize("transparent", OPACITY)
@pytest.mark.parametrize("alpha", ["1", "0.25"])
def test_collada_s_opacity_is_that_of_its_mode(transparent: str, alpha: str, tmp_path: Path) -> None:
    """COLLADA 1.5, transparent: opaque by alpha or luminance, of one or zero. The alpha of diffuse means nothing."""
    text = BOX.export(file_type="dae").decode()
    diffuse = f"<diffuse><color>0.8 0.4 0.2 {alpha}</color></diffuse>{transparent}"
    text, count = re.subn(r"<(phong|lambert|blinn)>.*?</\1>", rf"<\1>{diffuse}</\1>", text, flags=re.DOTALL)
    assert count == 1
    (tmp_path / "a.dae").write_text(text)
    with MeshReader() as meshes:
        (part,) = meshes.parts(tmp_path / "a.dae")
    np.testing.assert_allclose(part.colour, [0.8, 0.4, 0.2, OPACITY[transparent]], atol=0.5 / 255)


def test_one_process_reads_all_meshes_until_it_breaks_a_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader, "seconds_for", lambda size: 1.0)
    monkeypatch.setattr(reader, "PATIENCE", 1.0)
    (tmp_path / "slow.dae").write_text(SLOW)
    with MeshReader() as meshes:
        meshes.parts(box(tmp_path / "a.stl"))
        first = process.shared.process()
        meshes.parts(box(tmp_path / "b.stl"))
        assert process.shared.process() is first
        with pytest.raises(
            UnreadableMeshError, match=r"slow\.dae: reading it takes more than 1 s; export it with fewer"
        ):
            meshes.parts(tmp_path / "slow.dae")
        assert not first.alive
        assert meshes.parts(tmp_path / "b.stl")
        second = process.shared.process()
    with MeshReader() as meshes:  # the next arm's
        meshes.parts(tmp_path / "a.stl")
        assert process.shared.process() is second


def test_all_meshes_of_an_arm_share_their_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader, "seconds_for", lambda size: 0.5)
    monkeypatch.setattr(reader, "PATIENCE", 1.0)
    monkeypatch.setattr(reader, "ARM_SECONDS", 0.9)
    reasons = []
    with MeshReader() as meshes:
        for k in range(4):
            (tmp_path / f"{k}.dae").write_text(SLOW)
            with pytest.raises(UnreadableMeshError) as caught:
                meshes.length(tmp_path / f"{k}.dae")
            reasons.append(caught.value.reason)
    assert ["the meshes before it" in reason for reason in reasons] == [False, False, True, True]


@pytest.mark.slow
def test_processor_time_and_memory_are_limited_by_the_system(tmp_path: Path) -> None:
    (tmp_path / "slow.dae").write_text(SLOW)
    (tmp_path / "many.stl").write_bytes(fan(1_000_001))
    with MeshReader() as meshes:
        with pytest.raises(UnreadableMeshError, match="holds 1,000,001 triangles; at most 1,000,000 are drawn"):
            meshes.length(tmp_path / "many.stl")
        began = time.monotonic()
        with pytest.raises(UnreadableMeshError, match="takes more than (3 s|1200 MB of memory)"):
            meshes.length(tmp_path / "slow.dae")
        assert time.monotonic() - began < mesh_file.PATIENCE * 3.0


LIMITED = """
import resource, sys
from twistarm.description.meshes import mesh_file, worker
worker._prepare()
worker.limit_time(mesh_file.SECONDS)
assert resource.getrlimit(resource.RLIMIT_CPU)[0] <= mesh_file.SECONDS + 10.0
assert resource.getrlimit(resource.RLIMIT_FSIZE) == resource.getrlimit(resource.RLIMIT_CORE) == (0, 0)
assert sys.platform == "darwin" or resource.getrlimit(resource.RLIMIT_AS)[1] == mesh_file.MEMORY
"""


def test_the_process_is_limited_by_the_system() -> None:
    subprocess.run([sys.executable, "-c", LIMITED], timeout=60, check=True)


@pytest.mark.parametrize(("triangles", "parts"), [(0, 0), (mesh_file.TRIANGLES + 1, 1), (6000, mesh_file.PARTS + 1)])
def test_no_file_has_nothing_or_more_than_can_be_drawn(triangles: int, parts: int) -> None:
    with pytest.raises(RefusedError, match=r"it holds (no triangles|1,000,001 triangles|5,001 parts)"):
        loading._require_few(triangles, parts)


def test_a_module_beside_the_description_is_never_imported(tmp_path: Path) -> None:
    box(tmp_path / "a.stl")
    for name in ("numpy", "trimesh", "json", "collada"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w')\n")
    program = (
        "import sys; sys.path[:] = [f for f in sys.path if f]; import os; from pathlib import Path;"
        "from twistarm.description.meshes.reader import MeshReader;"
        f"os.chdir({str(tmp_path)!r}); sys.path.insert(0, ''); sys.path.insert(0, os.getcwd());"
        "print(len(MeshReader().parts(Path('a.stl'))[0].faces))"
    )
    done = subprocess.run(
        [sys.executable, "-I", "-c", program], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.stdout == "12\n", done.stderr
    assert not (tmp_path / "ran").exists()


def test_where_no_process_can_be_started_it_is_said_once_and_the_arm_lives(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = lay(CASES["stl: a fan of 20,000"], tmp_path)
    mesh = '<visual><geometry><mesh filename="meshes/other.stl"/></geometry></visual>'
    path.write_text(path.read_text().replace('<link name="base"/>', f'<link name="base">{mesh}</link>'))
    box(path.parent / "meshes" / "other.stl")
    monkeypatch.setattr(process.shared, "_process", None)

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(subprocess, "Popen", refuse)
    arm = load_arm(path)
    (note,) = Scene(arm).whole().notes
    assert note.startswith(
        "no mesh is drawn: the process that reads them could not be started here (Operation not perm"
    )
    (said,) = [one for one in diagnose(arm) if one.code == "mesh-not-looked-at"]
    assert "could not be started" in said.what


def test_a_reader_that_is_closed_gives_up_what_it_reads(tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    path = lay(CASES["dae: instances nested 4^14"], tmp_path / "meshes")
    viewer = Viewer(load_arm(path), open_browser=False)
    until(lambda: viewer._server.scene.reader._asked)
    began = time.monotonic()
    viewer.close()
    assert time.monotonic() - began < 0.5
    with pytest.raises(InputError, match="was closed"):
        viewer._server.scene.reader.parts(box(tmp_path / "a.stl"))


def test_all_triangles_can_be_asked_for_while_a_mesh_is_read_for_long(tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    with Viewer(load_arm(lay(CASES["dae: instances nested 4^14"], tmp_path / "meshes")), open_browser=False) as viewer:
        server = viewer._server
        until(lambda: server.scene.reader._asked)
        first, began = server.scene.reader, time.monotonic()
        server.ask(lambda stage: server.receive('{"type": "exact", "on": true, "number": 1}', "a page"))
        assert server.scene.reader is not first
        viewer.close()
        assert time.monotonic() - began < 1.0


@pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="processes are looked for in /proc")
@pytest.mark.parametrize(
    ("command", "how"),
    [
        ("doctor", signal.SIGINT),
        *(
            pytest.param(command, how, marks=pytest.mark.slow)
            for command in ("doctor", "view", "view -o")
            for how in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
            if (command, how) != ("doctor", signal.SIGINT)
        ),
    ],
)
def test_the_first_ctrl_c_ends_all_and_no_reader_outlives_its_parent(
    tmp_path: Path, command: str, how: signal.Signals
) -> None:
    path = lay(CASES["dae: instances nested 4^14"], tmp_path)
    more = {"doctor": [], "view": ["--no-browser"], "view -o": ["-o", str(tmp_path / "page.html")]}[command]
    program = subprocess.Popen(
        [sys.executable, "-m", "twistarm", command.split()[0], str(path), *more],
        env=os.environ | {"MARK": str(tmp_path)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        until(lambda: running(tmp_path) and _busy(running(tmp_path)[0]))
        began = time.monotonic()
        program.send_signal(how)
        _, errors = program.communicate(timeout=10)
        took = time.monotonic() - began
    finally:
        program.kill()
    assert took < 1.5  # 0.5 s on a machine that has nothing else to do
    assert "Traceback" not in errors
    until(lambda: not running(tmp_path), 2.0)


def _busy(number: int) -> bool:
    """Whether it has spent half a second on its mesh."""
    try:
        return int(Path(f"/proc/{number}/stat").read_text().split()[13]) > 60
    except OSError:
        return False


def until(holds: object, seconds: float = 30.0) -> None:
    end = time.monotonic() + seconds
    while not holds():  # type: ignore[operator]
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.mark.parametrize(
    "program", ["import os; os._exit(1)", "import os, sys; os.close(int(sys.argv[2])); import time; time.sleep(60)"]
)
def test_a_process_that_cannot_begin_is_said_and_ended(program: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process, "PROGRAM", program)
    mute, began = process.Process(), time.monotonic()
    with pytest.raises(TwistarmError, match="it did not begin"):
        mute.ask(Path("/a.stl"), 1.0, 1.0)
    assert time.monotonic() - began < 10.0
    assert not mute.alive
