"""Scene files: twistarm's scene.toml, MoveIt's planning scene as YAML, and MoveIt's .scene text."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from ..arm.bodies import Triangles, along
from ..description.companions.toml_entries import parse_toml, toml_key, toml_text
from ..description.document import read_text
from ..description.yaml_reading import parse_yaml
from ..support.checks import Array, Given, as_floats, as_vector
from ..support.errors import InputError, listed
from ..support.fields import Check, anything, fields, flag, inside, list_of, number, table_of, text, vector, word
from ..support.files import read_bounded
from ..theory.rotations import from_quaternion_wxyz, from_rpy, from_xyzw, to_rpy

MOST_BYTES = 4_000_000
"""The largest planning scene."""

SIZES: dict[str, dict[str, Check]] = {
    "box": {"size": vector},
    "sphere": {"radius": number},
    "cylinder": {"radius": number, "length": number},
    "capsule": {"radius": number, "length": number},
    "plane": {},
}
"""The entries that give each solid its size [m]."""

FILE: dict[str, Check] = {"file": word}


def _scale(value: Any, name: str) -> Array:
    return vector(value, name) if isinstance(value, list) else np.full(3, number(value, name))


def _margin(value: Any, name: str) -> Any:
    return table_of(number)(value, name) if isinstance(value, dict) else number(value, name)


def _array(value: Any, name: str) -> Array:
    return as_floats(value, name)


PLACE: dict[str, Check] = {
    "xyz": vector,
    "rpy": vector,
    "quaternion_wxyz": partial(vector, size=4),
    "on": text,
    "touching": list_of(text),
}
TOP: dict[str, Check] = {
    "arm": text,
    "degrees": flag,
    "ground": flag,
    "margin": _margin,
    "allow": list_of(list_of(text, 2, 2)),
    "allow_only": flag,
    **dict.fromkeys((*SIZES, "mesh"), anything),
}
"""The entries of a scene.toml and of the place of an object in it."""


@dataclass(frozen=True, eq=False)
class Entry:
    """An obstacle of a file: its kind, its size [m] or mesh with scale, its pose (4, 4) on the link `on`.

    Otherwise the pose is in `frame`: None for the base, "" for the root.
    """

    name: str
    kind: str
    size: tuple[float, ...]
    pose: Array
    mesh: Path | Triangles | None = None
    on: str = ""
    frame: str | None = None
    touching: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class SceneFile:
    """The content of a scene file: the arm's name if given, obstacles, pairs that need no check, and the margin [m].

    `matrix` tells that `allowed` are all pairs of the robot that need no check.
    """

    arm: str
    entries: tuple[Entry, ...]
    allowed: tuple[tuple[str, str], ...] = ()
    margin: float | Mapping[str, float] | None = None
    matrix: bool = False


def read_scene(path: Path) -> SceneFile:
    """Read a scene.toml, a planning scene (.yaml, .yml) or a .scene file.

    Raises InputError, with file and entry, for what cannot be used, and DescriptionError for an unreadable file.
    """
    kind = path.suffix.lower()
    readers: dict[str, Callable[[Path], SceneFile]] = {
        ".toml": _toml, ".yaml": _planning_scene, ".yml": _planning_scene, ".scene": _scene_text,
    }  # fmt: skip
    if kind not in readers:
        raise InputError(f"{path} is no scene file: its name must end with {listed(readers)}")
    return readers[kind](path)


# -- scene.toml --------------------------------------------------------------------------------------------------


def _toml(path: Path) -> SceneFile:
    with inside(path):
        content = fields(parse_toml(path, "a scene.toml"), "", {}, TOP)
    angle = np.pi / 180.0 if content.get("degrees") else 1.0
    entries = [Entry("ground", "plane", (), np.eye(4))] if content.get("ground") else []
    for kind in (*SIZES, "mesh"):
        tables = content.get(kind, [])
        for i, table in enumerate(tables if isinstance(tables, list) else [tables]):
            with inside(path, f"{kind} {i + 1}"):
                entries.append(_entry(kind, table, angle, path.parent))
    allowed = tuple((first, second) for first, second in content.get("allow", ()))
    matrix = content.get("allow_only", False)
    return SceneFile(content.get("arm", ""), tuple(entries), allowed, content.get("margin"), matrix)


def _entry(kind: str, value: Any, angle: float, folder: Path) -> Entry:
    own = FILE if kind == "mesh" else SIZES[kind]
    if kind == "mesh" and isinstance(value, Mapping) and "vertices" in value:
        own = {"vertices": _array, "triangles": _array}
    optional = {**PLACE, "scale": _scale} if kind == "mesh" else PLACE
    table = fields(value, "", {"name": word, **own}, optional)
    mesh: Path | Triangles | None = None
    if kind == "mesh":
        mesh = folder / table["file"] if "file" in table else _triangles(table["vertices"], table["triangles"])
        size = tuple(table.get("scale", np.ones(3)).tolist())
    else:
        size = tuple(np.concatenate([np.atleast_1d(table[name]) for name in own]).tolist()) if own else ()
    touching = tuple(table.get("touching", ()))
    if touching and "on" not in table:
        raise InputError("touching names links that touch a carried object; give on, too")
    return Entry(table["name"], kind, size, _pose(table, angle), mesh, table.get("on", ""), touching=touching)


def _pose(table: Mapping[str, Any], angle: float) -> Array:
    g = np.eye(4)
    g[:3, 3] = table.get("xyz", 0.0)
    if "rpy" in table and "quaternion_wxyz" in table:
        raise InputError("give rpy or quaternion_wxyz, not both")
    if "rpy" in table:
        turn = angle * table["rpy"]
        if np.abs(turn).max() > 2.0 * np.pi:
            raise InputError(f"rpy turns by {np.abs(turn).max():g} rad; for degrees write degrees = true at the top")
        g[:3, :3] = from_rpy(turn)
    elif "quaternion_wxyz" in table:
        g[:3, :3] = from_quaternion_wxyz(table["quaternion_wxyz"])
    return g


def scene_text(content: SceneFile, folder: Path) -> str:
    """The content as a scene.toml that will be in `folder`, lengths and angles with nine decimals."""
    margin = content.margin
    lines = [f"arm = {toml_text(content.arm)}"] if content.arm else []
    if isinstance(margin, Mapping):
        lines.append(f"margin = {{ {', '.join(f'{toml_key(name)} = {m!r}' for name, m in margin.items())} }}")
    elif margin:
        lines.append(f"margin = {margin!r}")
    lines.append("degrees = true")
    if content.matrix:
        lines.append("allow_only = true")
    if content.allowed:
        lines += ["allow = [", *(f"    {_listed(pair)}," for pair in content.allowed), "]"]
    for entry in content.entries:
        lines += ["", f"[[{entry.kind}]]", f"name = {toml_text(entry.name)}"]
        if entry.mesh is not None:
            if isinstance(entry.mesh, Triangles):
                lines.append(f"vertices = [{', '.join(map(_rounded, entry.mesh.points))}]")
                lines.append(f"triangles = {entry.mesh.faces.tolist()}")
            else:
                lines.append(f"file = {toml_text(Path(os.path.relpath(entry.mesh, folder)).as_posix())}")
            lines.append(f"scale = {_rounded(entry.size)}")
        elif entry.kind == "box":
            lines.append(f"size = {_rounded(entry.size)}")
        else:
            own = SIZES.get(entry.kind, ())
            lines += [f"{name} = {number!r}" for name, number in zip(own, entry.size, strict=True)]
        lines += [f"xyz = {_rounded(entry.pose[:3, 3])}", f"rpy = {_rounded(np.degrees(to_rpy(entry.pose[:3, :3])))}"]
        if entry.on:
            lines += [f"on = {toml_text(entry.on)}", f"touching = {_listed(entry.touching)}"]
    return "\n".join([*lines, ""])


def _rounded(numbers: Iterable[float]) -> str:
    return f"[{', '.join(repr(round(float(number), 9) + 0.0) for number in numbers)}]"


def _listed(names: Iterable[str]) -> str:
    return f"[{', '.join(map(toml_text, names))}]"


# -- MoveIt ------------------------------------------------------------------------------------------------------


@contextmanager
def _at(path: Path, place: str) -> Iterator[None]:
    """Name the file and the place, also for messages of MoveIt that lack a field or have another kind of value."""
    with inside(path, place):
        try:
            yield
        except (KeyError, TypeError, IndexError, AttributeError, StopIteration, RuntimeError, UnicodeError) as error:
            raise InputError(f"an entry is missing or of the wrong kind ({error})") from error


def _planning_scene(path: Path) -> SceneFile:
    content = parse_yaml(read_text(path, MOST_BYTES), path)
    with _at(path, "at the top"):
        scene = content.get("planning_scene", content)
        free = list((scene.get("world") or {}).get("collision_objects") or ())
        held = list((scene.get("robot_state") or {}).get("attached_collision_objects") or ())
        if not {"world", "robot_state", "allowed_collision_matrix"} & set(scene):
            raise InputError("it has no world, robot_state or allowed_collision_matrix: is it a planning scene?")
        matrix = scene.get("allowed_collision_matrix") or {}
        octomap = (scene.get("world") or {}).get("octomap") or {}
        if (octomap.get("octomap") or octomap).get("data"):
            raise InputError("it has an octomap, which is not read: write its occupied parts as boxes")
    entries: list[Entry] = []
    parts: dict[str, list[str]] = {}
    for i, item in enumerate(free):
        with _at(path, f"collision object {i + 1}"):
            found = list(_objects(item))
            parts[str(item["id"])] = [entry.name for entry in found]
            entries += found
    for i, item in enumerate(held):
        with _at(path, f"attached object {i + 1}"):
            link, touching = item["link_name"], tuple(item.get("touch_links") or ())
            found = list(_objects(item["object"]))
            if any(entry.frame not in ("", link) for entry in found):
                raise InputError(f"its frame_id is {found[0].frame!r}: give its pose in the frame of its link {link!r}")
            parts[str(item["object"]["id"])] = [entry.name for entry in found]
            entries += [replace(entry, on=link, frame=None, touching=touching) for entry in found]
    with _at(path, "allowed_collision_matrix"):
        pairs = tuple(_matrix_pairs(matrix, parts))
    return SceneFile("", tuple(entries), pairs, matrix=bool(matrix))


def _objects(item: Mapping[str, Any]) -> Iterator[Entry]:
    """The shapes of a moveit_msgs/CollisionObject, their poses in that of the object."""
    whole = _message_pose(item.get("pose") or {})
    frame = str((item.get("header") or {}).get("frame_id", "")).removeprefix("/")
    shapes: list[tuple[Shape, Array]] = []
    for one, many, read in (
        ("primitive", "primitives", _solid),
        ("mesh", "meshes", _mesh),
        ("plane", "planes", _plane),
    ):
        given, poses = item.get(many) or (), item.get(f"{one}_poses") or ()
        if len(poses) > len(given):
            raise InputError(f"it has {len(poses)} {one}_poses for {len(given)} {many}")
        for k, value in enumerate(given):
            shapes.append((read(value), whole @ _message_pose(poses[k] if k < len(poses) else {})))
    if not shapes:
        raise InputError(f"{item['id']!r} has no primitives, meshes or planes")
    for k, ((kind, size, mesh, own), pose) in enumerate(shapes):
        yield Entry(_numbered(str(item["id"]), k, len(shapes)), kind, size, pose @ own, mesh, frame=frame)


Shape = tuple[str, tuple[float, ...], Triangles | None, Array]
"""Kind, size, triangles and the pose (4, 4) in the shape's own frame."""

SOLIDS = {1: "box", 2: "sphere", 3: "cylinder"}
"""shape_msgs/SolidPrimitive."""


def _solid(value: Mapping[str, Any]) -> Shape:
    """A shape_msgs/SolidPrimitive: the height of a cylinder comes first."""
    kind, numbers = value["type"], tuple(float(x) for x in value["dimensions"])
    name = SOLIDS.get(kind, kind)
    if name not in SOLIDS.values():
        raise InputError(f"a primitive of type {kind!r}; known are {listed(SOLIDS.values())}")
    return name, numbers[::-1] if name == "cylinder" else numbers, None, np.eye(4)


def _mesh(value: Mapping[str, Any]) -> Shape:
    """A shape_msgs/Mesh, its points and triangles as lists or with their names."""
    faces = [face["vertex_indices"] if isinstance(face, dict) else face for face in value["triangles"]]
    points = [_named(point, "xyz") for point in value["vertices"]]
    return "mesh", (1.0, 1.0, 1.0), _triangles(points, faces), np.eye(4)


def _plane(value: Any) -> Shape:
    """A shape_msgs/Plane (a, b, c, d): the half-space ax + by + cz + d ≤ 0."""
    *normal, d = as_vector(value["coef"] if isinstance(value, dict) else value, "coef", 4)
    n = np.array(normal)
    if not n.any():
        raise InputError("a plane needs a normal: the first three numbers of coef are zero")
    g = along(n)
    g[:3, 3] = -d * n / (n @ n)
    return "plane", (), None, g


def _triangles(vertices: Given, faces: Given) -> Triangles:
    points, indices = as_floats(vertices, "vertices"), as_floats(faces, "triangles")
    if points.ndim != 2 or points.shape[1] != 3 or indices.ndim != 2 or indices.shape[1] != 3:
        raise InputError(f"vertices must be (N, 3) and triangles (F, 3); got {points.shape} and {indices.shape}")
    if not np.isin(indices, np.arange(len(points))).all():
        raise InputError(f"triangles must count vertices from 0 to {len(points) - 1}")
    return Triangles(points, indices.astype(np.int64))


def _named(value: Any, names: str) -> Any:
    return [value[name] for name in names] if isinstance(value, dict) else value


def _message_pose(pose: Mapping[str, Any]) -> Array:
    """geometry_msgs/Pose, its parts as lists or as x, y, z, w."""
    g = np.eye(4)
    g[:3, 3] = as_vector(_named(pose.get("position", [0.0, 0.0, 0.0]), "xyz"), "position")
    turn = as_vector(_named(pose.get("orientation", [0.0, 0.0, 0.0, 1.0]), "xyzw"), "orientation", 4)
    g[:3, :3] = from_xyzw(turn) if turn.any() else np.eye(3)  # an empty message has zeros
    return g


def _matrix_pairs(matrix: Mapping[str, Any], parts: Mapping[str, list[str]]) -> Iterator[tuple[str, str]]:
    """The pairs that an allowed collision matrix exempts, objects by their parts."""
    names = [parts.get(name, [name]) for name in matrix.get("entry_names") or ()]
    rows = [row["enabled"] if isinstance(row, dict) else row for row in matrix.get("entry_values") or ()]
    if {len(rows), *map(len, rows)} - {len(names)}:
        raise InputError(f"allowed_collision_matrix has {len(names)} names, but not as many rows and columns")
    for i, row in enumerate(rows):
        for j in range(i):
            if row[j] and ["<octomap>"] not in (names[i], names[j]):
                yield from product(names[i], names[j])


def _scene_text(path: Path) -> SceneFile:
    """MoveIt's text: for each object `* name`, since 2020 its pose, then its shapes."""
    with _at(path, "MoveIt's .scene text"):
        lines = iter(read_bounded(path, MOST_BYTES).decode("utf-8").splitlines()[1:])
        entries: list[Entry] = []
        for line in lines:
            if line.strip() == ".":
                return SceneFile("", tuple(entries))
            if not line.startswith("*"):
                raise InputError(f"expected '* name' of an object; got {line!r}")
            entries += _text_object(line[1:].strip(), lines)
        raise InputError("it does not end with a line '.': is it cut short?")


def _text_object(name: str, lines: Iterator[str]) -> list[Entry]:
    first, whole = _numbers(lines), np.eye(4)
    posed = len(first) == 3
    if posed:
        whole[:3, 3], whole[:3, :3] = first, from_xyzw(_numbers(lines))
        first = _numbers(lines)
    entries, count = [], int(first[0])
    for k in range(count):
        kind, size, mesh, own = _text_shape(next(lines).strip(), lines)
        g = np.eye(4)
        g[:3, 3], g[:3, :3] = _numbers(lines), from_xyzw(_numbers(lines))
        next(lines)  # the colour
        entries.append(Entry(_numbered(name, k, count), kind, size, whole @ g @ own, mesh, frame=""))
    if posed:  # subframes: a name, a position and a rotation each
        for _ in range(3 * int(_numbers(lines)[0])):
            next(lines)
    return entries


def _text_shape(kind: str, lines: Iterator[str]) -> Shape:
    size = _numbers(lines)
    if kind == "plane":
        return _plane(size)
    if kind == "mesh":  # how many points and triangles it has, then these
        points, faces = ([_numbers(lines) for _ in range(int(count))] for count in size)
        return kind, (1.0, 1.0, 1.0), _triangles(points, faces), np.eye(4)
    if kind not in SOLIDS.values():
        raise InputError(f"a {kind!r}; known are {listed((*SOLIDS.values(), 'mesh', 'plane'))}")
    return kind, tuple(size), None, np.eye(4)


def _numbers(lines: Iterator[str]) -> list[float]:
    return [float(word) for word in next(lines).split()]


def _numbered(name: str, k: int, count: int) -> str:
    return name if count == 1 else f"{name} {k + 1}"
