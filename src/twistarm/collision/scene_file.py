"""Scene files: twistarm's scene.toml, MoveIt's planning scene as YAML, and MoveIt's .scene text."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..description.companions.toml_entries import parse_toml, toml_key, toml_text
from ..description.document import read_text
from ..description.yaml_reading import parse_yaml
from ..support.checks import Array, as_flag, as_number, as_vector, require_mapping, require_names
from ..support.errors import InputError, TwistarmError, closest, listed
from ..support.files import read_bounded
from ..theory.rotations import from_quaternion_wxyz, from_rpy, from_xyzw, to_rpy

MOST_BYTES = 4_000_000
"""The largest planning scene."""

MOST_NODES = 200_000
"""The most values in one."""

SIZES = {"box": ("size",), "sphere": ("radius",), "cylinder": ("radius", "length"), "capsule": ("radius", "length")}
PLACE = ("name", "xyz", "rpy", "quaternion_wxyz", "on", "touching")
TOP = ("arm", "degrees", "ground", "margin", "allow", "allow_only", *SIZES, "plane", "mesh")


@dataclass(frozen=True, eq=False)
class Entry:
    """An obstacle of a file: its kind, its size [m] or mesh file with scale, its pose (4, 4) on the link `on`.

    Otherwise the pose is in `frame`: None for the base, "" for the root.
    """

    name: str
    kind: str
    size: tuple[float, ...]
    pose: Array
    mesh: Path | None = None
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
    content = parse_toml(path, "a scene.toml")
    with _at(path, "at the top"):
        _only(content, TOP)
        angle = np.pi / 180.0 if as_flag(content.get("degrees", False), "degrees") else 1.0
        margin = content.get("margin")
        allowed = tuple(_pair(pair) for pair in content.get("allow", ()))
        arm = content.get("arm", "")
        if not isinstance(arm, str):
            raise InputError(f"arm must be the name of an arm; got {arm!r}")
        only = as_flag(content.get("allow_only", False), "allow_only")
    entries = [Entry("ground", "plane", (), np.eye(4))] if as_flag(content.get("ground", False), "ground") else []
    for kind in (*SIZES, "plane", "mesh"):
        tables = content.get(kind, [])
        for i, table in enumerate(tables if isinstance(tables, list) else [tables]):
            with _at(path, f"{kind} {i + 1}"):
                entries.append(_entry(kind, table, angle, path.parent))
    return SceneFile(arm, tuple(entries), allowed, margin, only)


def _entry(kind: str, value: Any, angle: float, folder: Path) -> Entry:
    own = SIZES.get(kind, ("file", "scale") if kind == "mesh" else ())
    table = require_mapping(value, kind, '{ name = "table" }')
    _only(table, (*PLACE, *own))
    missing = [name for name in ("name", *own) if name not in table and name != "scale"]
    if missing:
        raise InputError(f"it needs {listed(missing)}")
    mesh = folder / table["file"] if kind == "mesh" else None
    if kind == "mesh":
        scale = table.get("scale", 1.0)
        size = tuple(as_vector(scale, "scale") if isinstance(scale, list) else [as_number(scale, "scale")] * 3)
    elif kind == "box":
        size = tuple(as_vector(table["size"], "size"))
    else:
        size = tuple(as_number(table[name], name) for name in own)
    touching = require_names(table.get("touching", ()), "touching")
    if touching and "on" not in table:
        raise InputError("touching names links that touch a carried object; give on, too")
    return Entry(table["name"], kind, size, _pose(table, angle), mesh, table.get("on", ""), touching=touching)


def _pose(table: Mapping[str, Any], angle: float) -> Array:
    g = np.eye(4)
    g[:3, 3] = as_vector(table.get("xyz", (0.0, 0.0, 0.0)), "xyz")
    if "rpy" in table and "quaternion_wxyz" in table:
        raise InputError("give rpy or quaternion_wxyz, not both")
    if "rpy" in table:
        rpy = angle * as_vector(table["rpy"], "rpy")
        if np.abs(rpy).max() > 2.0 * np.pi:
            raise InputError(f"rpy must be within a turn; got {table['rpy']!r}; for degrees set degrees = true")
        g[:3, :3] = from_rpy(rpy)
    elif "quaternion_wxyz" in table:
        g[:3, :3] = from_quaternion_wxyz(as_vector(table["quaternion_wxyz"], "quaternion_wxyz", 4))
    return g


def _pair(value: Any) -> tuple[str, str]:
    if not (isinstance(value, list) and len(value) == 2 and all(isinstance(name, str) for name in value)):
        raise InputError(f'allow must be a list of pairs such as ["forearm", "table"]; got {value!r}')
    return value[0], value[1]


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
            lines += [f"file = {toml_text(Path(os.path.relpath(entry.mesh, folder)).as_posix())}"]
            lines += [f"scale = {_rounded(entry.size)}"]
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


def _planning_scene(path: Path) -> SceneFile:
    content = parse_yaml(read_text(path, MOST_BYTES), path, MOST_NODES)
    with _at(path, "at the top"):
        scene = content.get("planning_scene", content)
        free = list((scene.get("world") or {}).get("collision_objects") or ())
        held = list((scene.get("robot_state") or {}).get("attached_collision_objects") or ())
        if not {"world", "robot_state", "allowed_collision_matrix"} & set(scene):
            raise InputError("it has no world, robot_state or allowed_collision_matrix: is it a planning scene?")
        matrix = scene.get("allowed_collision_matrix") or {}
        pairs = _matrix_pairs(matrix)
    entries: list[Entry] = []
    for i, item in enumerate(free):
        with _at(path, f"collision object {i + 1}"):
            entries += _objects(item)
    for i, item in enumerate(held):
        with _at(path, f"attached object {i + 1}"):
            link, touching = item["link_name"], tuple(item.get("touch_links") or ())
            entries += [replace(entry, on=link, frame=None, touching=touching) for entry in _objects(item["object"])]
    return SceneFile("", tuple(entries), pairs, matrix=bool(matrix))


def _objects(item: Mapping[str, Any]) -> Iterator[Entry]:
    """The primitives of a moveit_msgs/CollisionObject."""
    for other in ("meshes", "planes"):
        if item.get(other):
            raise InputError(f"{item.get('id')!r} has {other}: write them into a scene.toml, a mesh as its file")
    whole = _message_pose(item["pose"]) if item.get("pose") else np.eye(4)
    frame = str((item.get("header") or {}).get("frame_id", ""))
    shapes, poses = item.get("primitives") or (), item.get("primitive_poses") or ()
    alone = len(shapes) == 1 and not poses and item.get("pose")  # its pose is that of the object
    if not shapes or not (alone or len(poses) == len(shapes)):
        raise InputError(f"{item['id']!r} has {len(shapes)} primitives with {len(poses)} poses; give each its pose")
    for k, shape in enumerate(shapes):
        kind, size = _solid(shape["type"], [float(x) for x in shape["dimensions"]])
        pose = whole if alone else whole @ _message_pose(poses[k])
        yield Entry(_numbered(str(item["id"]), k, len(shapes)), kind, size, pose, frame=frame)


SOLIDS = {1: "box", 2: "sphere", 3: "cylinder"}
"""shape_msgs/SolidPrimitive."""


def _solid(kind: Any, numbers: list[float]) -> tuple[str, tuple[float, ...]]:
    """Kind and size of a primitive as MoveIt has it: the height of a cylinder comes first."""
    name = SOLIDS.get(kind, kind)
    if name not in SOLIDS.values():
        raise InputError(f"a primitive of type {kind!r}; known are {listed(SOLIDS.values())}")
    return name, tuple(reversed(numbers)) if name == "cylinder" else tuple(numbers)


def _message_pose(pose: Mapping[str, Any]) -> Array:
    """geometry_msgs/Pose, its parts as lists or as x, y, z, w."""
    g = np.eye(4)
    position, turn = pose.get("position", [0.0, 0.0, 0.0]), pose.get("orientation", [0.0, 0.0, 0.0, 1.0])
    g[:3, 3] = as_vector([position[axis] for axis in "xyz"] if isinstance(position, dict) else position, "position")
    g[:3, :3] = from_xyzw(as_vector([turn[a] for a in "xyzw"] if isinstance(turn, dict) else turn, "orientation", 4))
    return g


def _matrix_pairs(matrix: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    """The pairs that an allowed collision matrix exempts."""
    names = matrix.get("entry_names") or ()
    rows = [row["enabled"] if isinstance(row, dict) else row for row in matrix.get("entry_values") or ()]
    if {len(rows), *map(len, rows)} - {len(names)}:
        raise InputError(f"allowed_collision_matrix has {len(names)} names, but not as many rows and columns")
    return tuple((names[i], names[j]) for i, row in enumerate(rows) for j in range(i) if row[j])


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
        kind, size = next(lines).strip(), _numbers(lines)
        if kind not in ("box", "sphere", "cylinder"):
            raise InputError(f"{name!r} has a {kind}: write it to a file and name it in a scene.toml")
        g = np.eye(4)
        g[:3, 3], g[:3, :3] = _numbers(lines), from_xyzw(_numbers(lines))
        next(lines)  # the colour
        entries.append(Entry(_numbered(name, k, count), kind, tuple(size), whole @ g, frame=""))
    if posed:  # subframes: a name, a position and a rotation each
        for _ in range(3 * int(_numbers(lines)[0])):
            next(lines)
    return entries


def _numbers(lines: Iterator[str]) -> list[float]:
    return [float(word) for word in next(lines).split()]


def _numbered(name: str, k: int, count: int) -> str:
    return name if count == 1 else f"{name} {k + 1}"


# -- both --------------------------------------------------------------------------------------------------------


@contextmanager
def _at(path: Path, place: str) -> Iterator[None]:
    """Name the file and the place in errors."""
    try:
        yield
    except TwistarmError as error:
        raise InputError(f"{path}, {place}: {error}") from error
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, StopIteration, RuntimeError) as error:
        raise InputError(f"{path}, {place}: an entry is missing or of the wrong kind ({error})") from error


def _only(table: Mapping[str, Any], allowed: tuple[str, ...]) -> None:
    for key in table:
        if key not in allowed:
            raise InputError(f"unknown entry {key!r}{closest(key, allowed)}; allowed: {listed(allowed, 20)}")
