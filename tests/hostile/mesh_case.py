"""A hostile mesh, and the arm around it."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

CANARY = b"471108151234567890124711"
"""Of a secret that lies outside of the arm's package: text, and as the bytes of a mesh two points near each other."""

CORNERS = struct.pack("<9f", 0, 0, 0, 0.1, 0, 0, 0, 0.1, 0)
"""Three points."""


OUT, MALFORMED = "a file outside its package", "its contents are malformed"
"""Why a mesh is not drawn, in the words of its note."""


@dataclass(frozen=True)
class Case:
    """`write` puts a mesh into the folder `arm/meshes`, beside which lies `outside`, and names it; `said`: what of the
    reason, empty where it is drawn.
    """

    write: Callable[[Path], str]
    said: str = ""


def lay(case: Case, folder: Path) -> Path:
    """A description of an arm whose upper link is the mesh, in a package; and a secret beside the package."""
    meshes, outside = folder / "arm" / "meshes", folder / "outside"
    meshes.mkdir(parents=True)
    outside.mkdir()
    (folder / "arm" / "package.xml").write_text("<package><name>arm</name></package>")
    (outside / "secret.bin").write_bytes(CANARY * 60)
    (outside / "secret.mtl").write_bytes(b"newmtl a\nKd 1 0 0\n# " + CANARY)
    name = case.write(meshes)
    mesh = f'<visual><geometry><mesh filename="meshes/{name}"/></geometry></visual>'
    path = folder / "arm" / "arm.urdf"
    path.write_text(
        f'<robot name="r"><link name="base"/><link name="upper">{mesh}</link><link name="tip"/>'
        '<joint name="a" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/></joint>'
        '<joint name="b" type="continuous"><parent link="upper"/><child link="tip"/><origin xyz="0 0 0.3"/>'
        '<axis xyz="0 1 0"/></joint></robot>'
    )
    return path


def text(name: str, content: str | bytes | Callable[[], str | bytes], said: str = "") -> Case:
    """One file."""

    def write(folder: Path) -> str:
        made = content() if callable(content) else content
        (folder / name).write_bytes(made.encode() if isinstance(made, str) else made)
        return name

    return Case(write, said)
