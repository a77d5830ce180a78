"""Hostile glTF and GLB files."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .mesh_case import CORNERS, MALFORMED, OUT, Case, text


def tree(buffers: list[dict[str, Any]], accessor: dict[str, Any] | None = None, **more: Any) -> dict[str, Any]:
    """A glTF of one triangle whose corners are the first 36 bytes of the first buffer."""
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"} | (accessor or {})],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": buffers,
        **more,
    }


def data(content: bytes = CORNERS) -> dict[str, Any]:
    uri = "data:application/octet-stream;base64," + base64.b64encode(content).decode()
    return {"uri": uri, "byteLength": len(content)}


def gltf(made: dict[str, Any] | Callable[[], dict[str, Any]], said: str = "") -> Case:
    return text("mesh.gltf", lambda: json.dumps(made() if callable(made) else made), said)


def buffer_at(uri: str, said: str) -> Case:
    """A buffer in another file."""

    def write(folder: Path) -> str:
        outside = folder.parent.parent / "outside"
        (folder / "mesh.gltf").write_text(json.dumps(tree([{"uri": uri, "byteLength": 36}])))
        (folder / "link.bin").symlink_to(outside / "secret.bin")
        (folder / "loop.bin").symlink_to("loop.bin")
        (folder / "own one.bin").write_bytes(CORNERS)
        (folder / "zero.bin").symlink_to("/dev/zero")
        with (folder / "huge.bin").open("wb") as file:
            file.truncate(200_000_000)
        return "mesh.gltf"

    return Case(write, said)


def glb(head: Any, chunk: bytes = b"", *, length: int | None = None, says: int | None = None) -> bytes:
    """A GLB whose lengths may lie."""
    line = head if isinstance(head, bytes) else json.dumps(head).encode()
    line += b" " * (-len(line) % 4)
    body = struct.pack("<II", len(line) if says is None else says, 0x4E4F534A) + line
    if chunk:
        body += struct.pack("<II", len(chunk), 0x004E4942) + chunk
    return struct.pack("<III", 0x46546C67, 2, 12 + len(body) if length is None else length) + body


def doubling(depth: int) -> dict[str, Any]:
    """Nodes that share their children, twice at every level."""
    nodes: list[dict[str, Any]] = [{"children": [i + 1, i + 1]} for i in range(depth)]
    return tree([data()], nodes=[*nodes, {"mesh": 0}])


PNG = base64.b64encode(
    b"\x89PNG\r\n\x1a\n" + struct.pack(">I4s2I5B", 13, b"IHDR", 60000, 60000, 8, 6, 0, 0, 0)
).decode()

PAINTED = tree(
    [data()],
    images=[{"uri": "data:image/png;base64," + PNG}, {"uri": "../../outside/secret.bin"}, {"uri": "/dev/zero"}],
    textures=[{"source": 0}, {"source": 1}, {"source": 2}],
    materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}} for i in range(3)],
    meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "material": i} for i in range(3)]}],
)


DRACO, POSITION = "KHR_draco_mesh_compression", {"POSITION": 0}

GLTF = {
    "gltf: uri ../outside": buffer_at("../../outside/secret.bin", OUT),
    "gltf: uri /etc/passwd": buffer_at("/etc/passwd", "which is not opened"),
    "gltf: uri percent-encoded": buffer_at("%2e%2e/%2e%2e/outside/secret.bin", OUT),
    "gltf: uri through a link to a file": buffer_at("link.bin", OUT),
    "gltf: uri to a link loop": buffer_at("loop.bin", "cannot be read"),
    "gltf: uri to a device": buffer_at("zero.bin", OUT),
    "gltf: uri to 200 MB": buffer_at("huge.bin", "at most 100,000,000 are read"),
    "gltf: uri of its own": buffer_at("own%20one.bin", ""),
    "gltf: data that is no base64": gltf(tree([{"uri": "data:;base64,%%%"}]), "malformed"),
    "gltf: a count of 1e9": gltf(tree([data()], {"count": 10**9}), MALFORMED),
    "gltf: sparse, of 1e9": gltf(
        tree([data()], {"bufferView": None, "count": 10**9, "sparse": {"count": 10**9}}), "malformed|memory|s$"
    ),
    "gltf: a cycle of nodes": gltf(
        tree([data()], nodes=[{"children": [1]}, {"children": [0], "mesh": 0}]), "|malformed"
    ),
    "gltf: children doubled 25 times": gltf(lambda: doubling(25), ""),
    "gltf: JSON 100,000 lists deep": text("mesh.gltf", "[" * 100_000, "no JSON|nested"),
    "gltf: images of 14 GB, outside and endless": gltf(PAINTED, ""),
    "gltf: Draco": gltf(
        tree(
            [data()],
            extensionsUsed=[DRACO],
            extensionsRequired=[DRACO],
            meshes=[{"primitives": [{"attributes": POSITION, "extensions": {DRACO: {"attributes": POSITION}}}]}],
        ),
        "compressed by Draco",
    ),
    "gltf: 6,000 parts": gltf(
        lambda: tree([data()], meshes=[{"primitives": [{"attributes": {"POSITION": 0}}] * 6_000}]), "parts|more than"
    ),
    "glb: a chunk that is longer than the file": text("mesh.glb", glb(tree([]), says=4_000_000_000), MALFORMED),
    "glb: a length of 4 GB": text("mesh.glb", glb(tree([{"byteLength": 36}]), CORNERS, length=4_294_967_295), ""),
}
