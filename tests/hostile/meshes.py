"""Hostile meshes: files that want memory, time or somebody's secrets from whoever looks at an arm."""

from __future__ import annotations

import os
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .gltf import GLTF
from .mesh_case import CORNERS, OUT, Case, text

# OBJ ----------------------------------------------------------------------------------------------------------------

FACES = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nusemtl a\nf 1 2 3\n"


def library(name: str, said: str) -> Case:
    """An OBJ with a material library."""

    def write(folder: Path) -> str:
        outside = folder.parent.parent / "outside"
        (folder / "mesh.obj").write_text(f"mtllib {name}\n{FACES}")
        (folder / "link.mtl").symlink_to(outside / "secret.mtl")
        (folder / "map.mtl").write_text("newmtl a\nKd 1 0 0\nmap_Kd ../../outside/secret.bin\nmap_Kd /dev/zero\n")
        (folder / "wide.mtl").write_text("newmtl a\nKd " + "1 " * 2_000_000 + "\n")
        return "mesh.obj"

    return Case(write, said)


def polygon(corners: int) -> str:
    points = "\n".join(f"v {i % 997 * 1e-4} {i % 991 * 1e-4} 0" for i in range(corners))
    return f"{points}\nf {' '.join(map(str, range(1, corners + 1)))}\n"


def mixed(faces: int) -> str:
    """Triangles and quadrilaterals, which are read one by one."""
    return "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n" + "f 1 2 3\nf 1 2 3 4\n" * (faces // 2)


def fan(count: int) -> bytes:
    """A binary STL of triangles round one point."""
    import numpy as np

    angle = np.linspace(0, 6.283, count + 1)
    rim = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count + 1)])
    made = np.zeros(count, dtype=[("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    made["v"] = np.stack([np.tile([0.0, 0.0, 0.5], (count, 1)), rim[:-1], rim[1:]], axis=1)
    return bytes(80) + struct.pack("<I", count) + made.tobytes()


OBJ = {
    "obj: mtllib /dev/zero": library("/dev/zero", ""),
    "obj: mtllib through a link": library("link.mtl", OUT),
    "obj: mtllib with images outside": library("map.mtl", ""),
    "obj: mtllib with a line of 4 MB": library("wide.mtl", ""),
    "obj: a face of 200,000 corners": text("mesh.obj", lambda: polygon(200_000), ""),
    "obj: 400,000 mixed faces": text("mesh.obj", lambda: mixed(400_000), ""),
    "obj: 20,000 materials": text(
        "mesh.obj", lambda: FACES + "".join(f"usemtl m{i}\nf 1 2 3\n" for i in range(20_000)), "parts|more than"
    ),
    "obj: indices far below": text("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -300 -200 -1\n", "malformed|vertices"),
}


# STL and PLY --------------------------------------------------------------------------------------------------------


def ply(head: str, body: bytes = b"") -> bytes:
    return f"ply\nformat binary_little_endian 1.0\n{head}\nend_header\n".encode() + body


XYZ = "property float x\nproperty float y\nproperty float z"
LIST = "property list uchar int vertex_indices"

STL_AND_PLY = {
    "stl: a count that lies": text(
        "mesh.stl", bytes(80) + struct.pack("<I", 4_294_967_295) + bytes(500), "triangles|malf"
    ),
    "stl: 20,000 solids of a triangle": text(
        "mesh.stl",
        lambda: "solid a\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendsolid a\n" * 20_000,
        "parts|more than",
    ),
    "stl: NaN": text("mesh.stl", bytes(80) + struct.pack("<I", 1) + b"\xff" * 48 + b"\0\0", "no finite"),
    "stl: a fan of 20,000": text("mesh.stl", lambda: fan(20_000), ""),
    "ply: a count of 1e12": text("mesh.ply", ply(f"element vertex 1000000000000\n{XYZ}"), "malformed|memory|triangles"),
    "ply: a list of 1e9": text(
        "mesh.ply",
        ply(
            f"element vertex 3\n{XYZ}\nelement face 1\nproperty list uint int vertex_indices",
            CORNERS + b"\x00\xca\x9a\x3b",
        ),
        "malformed|memory|triangles",
    ),
    "ply: indices beyond": text(
        "mesh.ply",
        ply(f"element vertex 3\n{XYZ}\nelement face 1\n{LIST}", CORNERS + struct.pack("<B3i", 3, 0, 1, 2_000_000)),
        "malformed|vertices",
    ),
}


# COLLADA ------------------------------------------------------------------------------------------------------------


GEOMETRY = """<library_geometries><geometry id="g"><mesh><source id="p">
<float_array id="q" count="9">0 0 0 0.1 0 0 0 0.1 0</float_array><technique_common><accessor source="#q" count="3"
stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor>
</technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{count}"><input semantic="VERTEX" source="#v" offset="0"/><p>{indices}</p></triangles></mesh>
</geometry></library_geometries>"""


def dae(scene: str, *, unit: str = "1", head: str = "", nodes: str = "", indices: str = "0 1 2", count: int = 1) -> str:
    return (
        f'<?xml version="1.0"?>{head}<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
        f'<asset><unit name="u" meter="{unit}"/></asset>{GEOMETRY.format(count=count, indices=indices)}{nodes}'
        f'<library_visual_scenes><visual_scene id="s"><node>{scene}</node></visual_scene></library_visual_scenes>'
        '<scene><instance_visual_scene url="#s"/></scene></COLLADA>'
    )


DRAWN = '<instance_geometry url="#g"/>'


def instances(width: int, depth: int) -> str:
    """A node that holds the one below it `width` times."""
    below = [f'<instance_node url="#n{level}"/>' * width for level in range(depth)]
    nodes = [f'<node id="n{level}">{inside}</node>' for level, inside in enumerate([DRAWN, *below])]
    return dae(f'<instance_node url="#n{depth}"/>', nodes=f"<library_nodes>{''.join(nodes)}</library_nodes>")


LAUGHS = (
    "<!DOCTYPE COLLADA ["
    + '<!ENTITY a "ha">'
    + "".join(f'<!ENTITY {chr(98 + i)} "{f"&{chr(97 + i)};" * 10}">' for i in range(9))
    + "]>"
)

DAE = {
    "dae: instances nested 4^14": text("mesh.dae", instances(4, 14), "more than"),
    "dae: a billion laughs": text("mesh.dae", dae(DRAWN, head=LAUGHS, indices="&j;"), "document type"),
    "dae: UTF-16 with a document type": text(
        "mesh.dae",
        lambda: dae(DRAWN, head="<!DOCTYPE a>").replace('"1.0"', '"1.0" encoding="UTF-16"').encode("utf-16"),
        "document type",
    ),
    "dae: UTF-7, which hides a document type": text(
        "mesh.dae",
        dae(DRAWN, head="+ADwAIQ-DOCTYPE a+AD4-").replace('"1.0"', '"1.0" encoding="UTF-7"'),
        "no XML in UTF-8",
    ),
    "dae: a unit of 1e999": text("mesh.dae", dae(DRAWN, unit="1e999"), "unit"),
    "dae: 100,000 elements deep": text(
        "mesh.dae", lambda: dae("<node>" * 100_000 + "</node>" * 100_000), "more|nested|tri|malf"
    ),
    "dae: a node that holds itself": text(
        "mesh.dae",
        dae(
            '<instance_node url="#a"/>',
            nodes='<library_nodes><node id="a"><instance_node url="#a"/></node></library_nodes>',
        ),
        "nested|malformed|triangles|more than",
    ),
}


# what is no mesh, and archives --------------------------------------------------------------------------------------


def archive(path: Path) -> None:
    """A small archive of a large file of zeros."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as packed, packed.open("3D/3dmodel.model", "w") as file:
        for _ in range(200):
            file.write(bytes(1_000_000))


def special(name: str, make: Callable[[Path], Any], said: str) -> Case:
    def write(folder: Path) -> str:
        make(folder / name)
        return name

    return Case(write, said)


def sparse(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(5_000_000_000)


OTHERS = {
    "archive: 3mf": special("mesh.3mf", archive, "not read here"),
    "other: no ending": text("mesh", CORNERS, "not read here"),
    "other: 5 GB": special("mesh.stl", sparse, "at most 100,000,000 are read"),
    "other: a link to a file of text outside": special(
        "mesh.stl",
        lambda path: path.symlink_to(path.parents[2] / "outside" / "secret.bin"),
        "not read here|no triangles",
    ),
}

NO_FILES = {
    "other: a FIFO": special("mesh.stl", os.mkfifo, ""),
    "other: a link to a device": special("mesh.obj", lambda path: path.symlink_to("/dev/zero"), ""),
    "other: a link loop": special("mesh.dae", lambda path: path.symlink_to(path.name), ""),
    "other: a folder": special("mesh.gltf", Path.mkdir, ""),
}
"""Missing, as the reading of the description has it."""

CASES: dict[str, Case] = {**GLTF, **OBJ, **STL_AND_PLY, **DAE, **OTHERS, **NO_FILES}
