"""Nothing that twistarm writes or serves tells where on the machine the arm lies, nor whose machine it is."""

from __future__ import annotations

import base64
import re
import zlib
from contextlib import suppress
from pathlib import Path

import pytest

from twistarm import InputError, load_arm
from twistarm.cli.application import run
from urdf_text import joint
from xacro_text import MANIFEST, XMLNS, lay

CANARY = "canarytown"  # The user, and every folder on the way to the arm.

MESHES = {
    "base_link": ("file://@HERE/meshes/absent.stl", "$(find arm)/meshes/absent.stl", "@HERE/meshes/broken.obj"),
    "upper": ("$(find nowhere)/meshes/a.stl", "package://nowhere/b.stl", "file://$(find arm)/meshes/broken.stl"),
    "tool0": ("../elsewhere/c.dae", "@HERE/pipe.stl", "$(cwd)/meshes/d.ply"),
}

COMMANDS = {
    "page": "view ARM -o OUT/page.html",
    "motion": "plan ARM --to 0.1 0.2 --velocity 1 --acceleration 1 -o OUT/motion.csv -o OUT/motion.json",
    "golden": "freeze ARM -o OUT/golden.json",
    "baked": "bake ARM -o OUT/arm.json -o OUT/arm.hpp",
    "repaired": "doctor ARM --fix -o OUT/repaired.urdf",
    "draft": "init ARM -o BESIDE/arm.toml",
    "answers": "ik ARM --targets OUT/targets.csv -o OUT/answers.csv",
    "info": "info ARM --json",
    "diagnosis": "doctor ARM --json",
    "check": "check ARM --json",
}


@pytest.fixture
def arm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The xacro of an arm, with everything wrong that is told about with a path."""
    here = tmp_path.resolve() / CANARY / f"with {CANARY} space" / "arm"
    drawn = {
        link: "".join(f'<visual><geometry><mesh filename="{mesh}"/></geometry></visual>' for mesh in meshes)
        for link, meshes in MESHES.items()
    }
    text = (
        f'<robot name="arm" {XMLNS}>'
        '<gazebo a="$(find nowhere)/x" b="$(find copy)/y" c="$(cwd)"/>'
        '<gazebo a="${xacro.abs_filename(\'e\')}" b="$(optenv HOME)"/>'
        + "".join(f'<link name="{link}">{shapes}</link>' for link, shapes in drawn.items())
        + joint("a", "base_link", "upper", inside='<axis xyz="0 0 2"/>')
        + joint("b", "upper", "tool0", inside='<axis xyz="0 1 0"/>')
        + "</robot>"
    )
    broken = {f"meshes/broken.{ending}": "no mesh" for ending in ("stl", "obj", "dae")}
    lay(here, {"package.xml": MANIFEST("arm"), "arm.xacro": text.replace("@HERE", str(here)), **broken})
    lay(here, {"arm.srdf": "<robot name='arm'><group/></robot>", "../copy/urdf/x": ""})
    lay(tmp_path / "out", {"targets.csv": "x,y,z\n0.1,0.1,1.0\n9,9,9\n"})
    monkeypatch.setenv("HOME", str(here.parent))
    for name in ("USER", "LOGNAME", "HOSTNAME"):
        monkeypatch.setenv(name, CANARY)
    return here / "arm.xacro"


def inside(data: bytes) -> bytes:
    """What was written, and what lies in it by base64 and deflate."""
    encoded = re.findall(rb"[A-Za-z0-9+/]{40,}", data)
    parts = [data, *(base64.b64decode(text[: len(text) // 4 * 4]) for text in encoded)]
    for part in list(parts):
        for start in re.finditer(rb"\x78[\x01\x5e\x9c\xda]", part):
            with suppress(zlib.error):
                parts.append(zlib.decompressobj().decompress(part[start.start() :]))
    return b"\n".join(parts)


@pytest.mark.parametrize("case", COMMANDS)
def test_what_is_written_tells_no_place(case: str, arm: Path, here: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """From another folder, with the arm's whole path typed."""
    words = [word.replace("OUT", "out").replace("BESIDE", str(arm.parent)) for word in COMMANDS[case].split()]
    code = run([str(arm) if word == "ARM" else word for word in words])
    told = capfd.readouterr()
    assert code in (0, 1), told.err
    written = [arm.parent / "arm.toml"] if case == "draft" else [here / w for w in words if w.startswith("out/")]
    for data in [path.read_bytes() for path in written] + ([told.out.encode()] if "--json" in words else []):
        assert data
        leak = inside(data).lower()
        at = leak.find(CANARY.encode())
        assert at < 0, leak[max(0, at - 200) : at + 100]


def test_the_page_that_is_served_tells_no_place(arm: Path) -> None:
    pytest.importorskip("meshcat")
    from twistarm.viewer.messages import failure
    from twistarm.viewer.parts.arm_data import doctor_findings

    loaded = load_arm(arm)
    assert any(CANARY in one.what for one in loaded.findings), "on the terminal a whole path helps"
    assert all(CANARY not in str(one) for one in doctor_findings(loaded)["findings"])
    assert CANARY not in str(failure(InputError(f"cannot write {arm}")))
