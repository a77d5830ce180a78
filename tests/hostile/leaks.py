"""An arm in a folder whose path must not get about, with everything wrong that is told about with a path."""

from __future__ import annotations

import base64
import re
import zlib
from contextlib import suppress
from pathlib import Path

from urdf_text import joint
from xacro_text import XMLNS

CANARY = "canarytown"
"""The user, and every folder on the way to the arm."""

LINKS = ("base_link", "upper", "tool0")

MESHES = {
    "base_link": ("file://@HERE/meshes/absent.stl", "$(find arm)/meshes/absent.stl", "@HERE/meshes/broken.obj"),
    "upper": ("$(find nowhere)/meshes/a.stl", "package://nowhere/b.stl", "file://$(find arm)/meshes/broken.stl"),
    "tool0": ("../elsewhere/c.dae", "@HERE/pipe.stl", "$(cwd)/meshes/d.ply"),
}


def lay_arm(folder: Path) -> Path:
    """The xacro of an arm, and what it is to stumble over."""
    here = folder / CANARY / f"with {CANARY} space" / "arm"
    (here / "meshes").mkdir(parents=True)
    (here / "package.xml").write_text("<package><name>arm</name></package>")
    for name in ("broken.stl", "broken.obj", "broken.dae"):
        (here / "meshes" / name).write_text("no mesh")
    (here / "link.stl").symlink_to(here / "meshes" / "broken.stl")
    (here / "arm.srdf").write_text("<robot name='arm'><group/></robot>")
    (here.parent / "copy" / "urdf").mkdir(parents=True)
    drawn = {
        link: "".join(f'<visual><geometry><mesh filename="{mesh}"/></geometry></visual>' for mesh in meshes)
        for link, meshes in MESHES.items()
    }
    text = (
        f'<robot name="arm" {XMLNS}>'
        '<gazebo a="$(find nowhere)/x" b="$(find copy)/y" c="$(cwd)"/>'
        '<gazebo a="${xacro.abs_filename(\'e\')}" b="$(optenv HOME)"/>'
        + "".join(f'<link name="{link}">{drawn[link]}</link>' for link in LINKS)
        + joint("a", "base_link", "upper", inside='<axis xyz="0 0 2"/>')
        + joint("b", "upper", "tool0", inside='<axis xyz="0 1 0"/>')
        + "</robot>"
    )
    path = here / "arm.xacro"
    path.write_text(text.replace("@HERE", str(here)))
    return path


def inside(data: bytes) -> bytes:
    """What was written, and what lies in it by base64 and deflate."""
    encoded = re.findall(rb"[A-Za-z0-9+/]{40,}", data)
    parts = [data, *(base64.b64decode(text[: len(text) // 4 * 4]) for text in encoded)]
    for part in list(parts):
        for start in re.finditer(rb"\x78[\x01\x5e\x9c\xda]", part):
            with suppress(zlib.error):
                parts.append(zlib.decompressobj().decompress(part[start.start() :]))
    return b"\n".join(parts)
