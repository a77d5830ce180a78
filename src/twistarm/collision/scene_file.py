"""Scene files: twistarm's scene.toml, MoveIt's planning scene as YAML, and MoveIt's .scene text."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, product, zip_longest
from pathlib import Path
from typing import Any

import numpy as np

from ..arm.bodies import Triangles, along
from ..description.companions.data_files import parse_toml, parse_yaml, toml_key, toml_text
from ..description.document import read_text
from ..support.checks import Array, Given, as_flag, as_floats, as_number, as_vector, pose_of
from ..support.errors import InputError, TwistarmError, listed, quote
from ..support.fields import Check, anything, fields, inside, list_of, table_of, text, vector, word
from ..support.files import read_bounded
from ..theory.rotations import from_quaternion_wxyz, from_rpy, from_xyzw, to_rpy
from .cloud_files import octomap_points, write_points

MOST_BYTES = 4_000_000
"""The largest planning scene."""

SIZES: dict[str, dict[str, Check]] = {
    "box": {"size": vector},
    "sphere": {"radius": as_number},
    "cylinder": {"radius": as_number, "length": as_number},
    "capsule": {"radius": as_number, "length": as_number},
    "plane": {},
}
"""The entries that give each solid its size [m]."""

FILES: dict[str, dict[str, Check]] = {"mesh": {"file": word}, "points": {"file": word, "voxel": as_number}}
"""The entries of what is in a file."""


PLACE: dict[str, Check] = {
    "xyz": vector,
    "rpy": vector,
    "quaternion_wxyz": partial(vector, size=4),
    "on": text,
    "touching": list_of(text),
}
TOP: dict[str, Check] = {
    "arm": text,
    "degrees": as_flag,
    "ground": as_flag,
    "margin": lambda value, name: (table_of(as_number) if isinstance(value, dict) else as_number)(value, name),
    "allow": list_of(list_of(text, 2, 2)),
    "allow_only": as_flag,
    **dict.fromkeys((*SIZES, *FILES), anything),
}
"""The entries of a scene.toml and of the place of an object in it."""


@dataclass(frozen=True, eq=False)
class Entry:
    """An obstacle of a file: its kind, its size [m] or mesh with scale, and its pose (4, 4).

    `mesh` is also the file of a cloud, or its points (N, 3).

    The pose is on the link `on` if given. Otherwise it is in `frame`: None for the base, "" for the root.
    """

    name: str
    kind: str
    size: tuple[float, ...]
    pose: Array
    mesh: Path | Triangles | Array | None = None
    on: str = ""
    frame: str | None = None
    touching: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class SceneFile:
    """The content of a scene file: the arm's name if given, obstacles, allowed pairs and the margin [m].

    matrix: whether `allowed` are all pairs of the robot that need no check, in place of those of the SRDF. foreign:
    whether names that the robot lacks are left out, as MoveIt does. absent: these names. unread: entries of the file
    that are not used. state: the values of joints [rad, m], which are not used either.
    """

    arm: str
    entries: tuple[Entry, ...]
    allowed: tuple[tuple[str, str], ...] = ()
    margin: float | Mapping[str, float] | None = None
    matrix: bool = False
    foreign: bool = False
    absent: tuple[str, ...] = ()
    unread: tuple[str, ...] = ()
    state: tuple[tuple[str, float], ...] = ()


def read_scene(path: Path, links: Iterable[str] = ()) -> SceneFile:
    """Read a scene.toml, a planning scene (.yaml, .yml) or a .scene file for a robot with `links`.

    Raises InputError, with file and entry, for what cannot be used, and DescriptionError for an unreadable file.
    """
    kind = path.suffix.lower()
    moveit = partial(_planning_scene, links=tuple(links))
    readers: dict[str, Callable[[Path], SceneFile]] = {
        ".toml": _toml, ".yaml": moveit, ".yml": moveit, ".scene": _scene_text,
    }  # fmt: skip
    if kind not in readers:
        raise InputError(f"{path} is no scene file: its name must end with {listed(readers)}")
    return readers[kind](path)


# -- scene.toml --------------------------------------------------------------------------------------------------


def _toml(path: Path) -> SceneFile:
    read = parse_toml(path, "a scene.toml")
    with inside(path):
        content = fields(read, "", {}, TOP)
    angle = np.pi / 180.0 if content.get("degrees") else 1.0
    entries = [Entry("ground", "plane", (), np.eye(4))] if content.get("ground") else []
    for kind in (*SIZES, *FILES):
        tables = content.get(kind, [])
        for i, table in enumerate(tables if isinstance(tables, list) else [tables]):
            with inside(path, f"{kind} {i + 1}"):
                entries.append(_entry(kind, table, angle, path.parent))
    allowed = tuple((first, second) for first, second in content.get("allow", ()))
    matrix = content.get("allow_only", False)
    return SceneFile(content.get("arm", ""), tuple(entries), allowed, content.get("margin"), matrix)


def _entry(kind: str, value: Any, angle: float, folder: Path) -> Entry:
    own = FILES.get(kind) or SIZES[kind]
    if kind == "mesh" and isinstance(value, Mapping) and "vertices" in value:
        own = {"vertices": as_floats, "triangles": as_floats}
    scale: Check = lambda value, name: vector(value if isinstance(value, list) else [value] * 3, name)  # noqa: E731
    table = fields(value, "", {"name": word, **own}, {**PLACE, "scale": scale} if kind == "mesh" else PLACE)
    mesh: Path | Triangles | None = None
    if kind == "points":
        mesh, size = folder / table["file"], (table["voxel"],)
    elif kind == "mesh":
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


def with_points_in_files(content: SceneFile, scene: Path) -> SceneFile:
    """The content of a file `scene`. The points of its clouds are written into files beside it."""
    entries = [
        replace(entry, mesh=write_points(entry.mesh, scene, entry.name))
        if isinstance(entry.mesh, np.ndarray)
        else entry
        for entry in content.entries
        if not isinstance(entry.mesh, np.ndarray) or len(entry.mesh)  # no file has a cloud without points
    ]
    return replace(content, entries=tuple(entries))


def scene_text(content: SceneFile, folder: Path) -> str:
    """The content as a scene.toml that will be in `folder`, lengths and angles with nine decimals."""
    head = {
        "arm": content.arm, "margin": content.margin, "degrees": True, "allow_only": content.matrix,
        "allow": content.allowed,
    }  # fmt: skip
    lines = [f"{name} = {_toml_value(value)}" for name, value in head.items() if value]
    for entry in content.entries:
        own: dict[str, Any] = {"name": entry.name}
        if isinstance(entry.mesh, Triangles):
            own |= {"vertices": entry.mesh.points, "triangles": entry.mesh.faces}
        elif isinstance(entry.mesh, Path):
            own["file"] = Path(os.path.relpath(entry.mesh, folder)).as_posix()
        if entry.kind in ("mesh", "box"):
            own["scale" if entry.kind == "mesh" else "size"] = entry.size
        elif entry.kind == "points":
            own["voxel"] = entry.size[0]
        else:
            own |= zip(SIZES[entry.kind], entry.size, strict=True)
        own |= {"xyz": entry.pose[:3, 3], "rpy": np.degrees(to_rpy(entry.pose[:3, :3]))}
        if entry.on:
            own |= {"on": entry.on, "touching": entry.touching}
        lines += ["", f"[[{entry.kind}]]", *(f"{name} = {_toml_value(value)}" for name, value in own.items())]
    return "\n".join([*lines, ""])


def _toml_value(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{toml_key(name)} = {_toml_value(entry)}' for name, entry in value.items())} }}"
    if isinstance(value, (tuple, np.ndarray)):
        return f"[{', '.join(map(_toml_value, value))}]"
    if isinstance(value, str):
        return toml_text(value)
    if isinstance(value, (bool, np.integer)):
        return str(value).lower()
    return repr(round(float(value), 9) + 0.0)


# -- MoveIt ------------------------------------------------------------------------------------------------------


@contextmanager
def _at(path: Path, place: str) -> Iterator[None]:
    """Name the file and the place in errors. A message of MoveIt may lack a field or have a value of another kind."""
    with inside(path, place):
        try:
            yield
        except TwistarmError:
            raise
        except (KeyError, TypeError, IndexError, AttributeError, StopIteration, RuntimeError, ValueError) as error:
            raise InputError(f"an entry is missing or of the wrong kind ({error})") from error


# The entries of MoveIt's messages. Those that are not among them, or have no meaning here, are told.
ENTRIES = {
    "planning scene": "name robot_state robot_model_name fixed_frame_transforms allowed_collision_matrix "
    "object_colors world is_diff",
    "world": "collision_objects octomap",
    "robot_state": "joint_state multi_dof_joint_state attached_collision_objects is_diff",
    "allowed_collision_matrix": "entry_names entry_values default_entry_names default_entry_values",
    "attached object": "link_name object touch_links detach_posture weight",
    "object": "header pose id type primitives primitive_poses meshes mesh_poses planes plane_poses "
    "subframe_names subframe_poses operation",
}
PLAIN = {"padding": 0, "scale": 1}  # What MoveIt writes for links whose shapes it leaves as they are.


def _unread(kind: str, message: Mapping[str, Any]) -> Iterator[str]:
    """What a message says that is not used here: other entries than `ENTRIES`, and other values than `PLAIN`."""
    for name in (name for name in message if name not in ENTRIES[kind].split()):
        word = name.removeprefix("link_")
        if word not in PLAIN:
            yield f"{name} of the {kind}"
        else:
            changed = [link["link_name"] for link in message[name] or () if link[word] != PLAIN[word]]
            yield from (f"{name} of {link}" for link in changed)


def _planning_scene(path: Path, links: Iterable[str]) -> SceneFile:
    """A moveit_msgs/PlanningScene."""
    content = parse_yaml(read_text(path, MOST_BYTES), path)
    with _at(path, "at the top"):
        scene = content.get("planning_scene", content)
        if not {"world", "robot_state", "allowed_collision_matrix"} & set(scene):
            raise InputError("it has no world, robot_state or allowed_collision_matrix: is it a planning scene?")
        world, state, matrix = (scene.get(name) or {} for name in ("world", "robot_state", "allowed_collision_matrix"))
        unread = [*_unread("planning scene", scene), *_unread("world", world), *_unread("robot_state", state)]
        unread += _unread("allowed_collision_matrix", matrix)
        unread += ["is_diff, as if this were the whole scene"] if scene.get("is_diff") else []
        joints = state.get("joint_state") or {}
        values = tuple(zip(joints.get("name") or (), map(float, joints.get("position") or ()), strict=False))
        free = [
            ({"object": item}, f"collision object {i + 1}")
            for i, item in enumerate(world.get("collision_objects") or ())
        ]
        held = [
            ({"link_name": None, **item}, f"attached object {i + 1}")
            for i, item in enumerate(state.get("attached_collision_objects") or ())
        ]
    objects = [(place, item) for given in (free, held) for item, place in _left(path, given)]
    with _at(path, "octomap"):
        entries = _octomap(world.get("octomap") or {})
    parts = {entry.name: [entry.name] for entry in entries}
    for place, item in objects:
        with _at(path, place):
            found, name = list(_objects(item["object"])), str(item["object"]["id"])
            unread += [*_unread("attached object", item), *_unread("object", item["object"])]
            if not found:  # MoveIt goes on without it, too
                unread.append(f"{name}, which has no shapes")
            if "link_name" in item:
                link, touching = text(item["link_name"], "link_name"), tuple(item.get("touch_links") or ())
                if any(entry.frame not in ("", link) for entry in found):
                    raise InputError(f"frame_id is {found[0].frame!r}: give its pose in the frame of its link {link!r}")
                found = [replace(entry, on=link, frame=None, touching=touching) for entry in found]
            parts[name] = [*parts.get(name, ()), *(entry.name for entry in found)]
            entries += found
    with _at(path, "allowed_collision_matrix"):
        pairs = tuple(_matrix_pairs(matrix, parts, links))
    named = bool(matrix.get("entry_names"))  # a matrix without names leaves the robot's own pairs
    return SceneFile("", tuple(entries), pairs, matrix=named, foreign=True, unread=tuple(unread), state=values)


OCTOMAP = "<octomap>"
"""The name of the octomap in MoveIt's allowed collision matrix."""


def _octomap(given: Mapping[str, Any]) -> list[Entry]:
    """The occupied voxels of an octomap_msgs/OctomapWithPose, if it has some."""
    octomap = given.get("octomap") or {}
    if not octomap.get("data"):
        return []
    points, voxel = octomap_points(octomap)
    frame = str((given.get("header") or {}).get("frame_id", "")).removeprefix("/")
    pose = _message_pose(given.get("origin") or {})
    return [Entry(OCTOMAP, "points", (voxel,), pose, points, frame=frame)] if len(points) else []


OPERATIONS = "ADD", "REMOVE", "APPEND", "MOVE"
"""moveit_msgs/CollisionObject.operation by its number."""


def _left(path: Path, objects: list[tuple[Any, str]]) -> Iterator[tuple[Any, str]]:
    """The objects that are left once each operation is done in its turn, as MoveIt does. An empty id removes all."""
    left: dict[str, tuple[Any, str]] = {}
    for item, place in objects:
        with _at(path, place):
            name, given = str(item["object"].get("id", "")), item["object"].get("operation", 0)
            text_of = str(given).removeprefix("CollisionObject.")
            number = ord(given[:1] or "\0") if isinstance(given, (str, bytes)) and len(given) < 2 else given
            done = OPERATIONS[number] if number in (0, 1, 2, 3) else text_of.strip().upper()
            if done == "REMOVE":
                left = {other: placed for other, placed in left.items() if name and other != name}
            elif done == "ADD" or (done == "APPEND" and name not in left):
                left[name] = item, place
            else:
                what = f"operation {quote(given)} of {name!r} is not read; write the object whole, with operation ADD"
                raise InputError(what)
    yield from left.values()


SOLIDS = {1: "box", 2: "sphere", 3: "cylinder"}
"""shape_msgs/SolidPrimitive."""

LISTS = {"primitive": "primitives", "mesh": "meshes", "plane": "planes"}
"""The lists of a moveit_msgs/CollisionObject."""


def _objects(item: Mapping[str, Any]) -> Iterator[Entry]:
    """The shapes of a moveit_msgs/CollisionObject, their poses in that of the object."""
    whole, name = _message_pose(item.get("pose") or {}), str(item["id"])
    frame = str((item.get("header") or {}).get("frame_id", "")).removeprefix("/")
    shapes: list[tuple[str, Any, Any]] = []
    for kind, many in LISTS.items():
        given, poses = list(item.get(many) or ()), list(item.get(f"{kind}_poses") or ())
        if len(poses) > len(given):
            raise InputError(f"it has {len(poses)} {kind}_poses for {len(given)} {many}")
        placed: Iterator[tuple[Any, Any]] = zip_longest(given, poses, fillvalue={})
        shapes += [(kind, *pair) for pair in placed]
    for k, (kind, value, pose) in enumerate(shapes):
        size: tuple[float, ...] = ()
        mesh, own = None, np.eye(4)
        if kind == "primitive":
            kind = SOLIDS.get(value["type"], value["type"])
            if kind not in SOLIDS.values():
                raise InputError(f"a primitive of type {kind!r}; known are {listed(SOLIDS.values())}")
            size = tuple(float(x) for x in value["dimensions"])[:: -1 if kind == "cylinder" else 1]  # its height first
        elif kind == "mesh":
            faces = [face["vertex_indices"] if isinstance(face, dict) else face for face in value["triangles"]]
            size, mesh = (1.0, 1.0, 1.0), _triangles([_named(point, "xyz") for point in value["vertices"]], faces)
        else:  # (a, b, c, d): the half-space ax + by + cz + d ≤ 0
            *n, d = as_vector(value["coef"] if isinstance(value, dict) else value, "coef", 4)
            if not any(n):
                raise InputError("a plane needs a normal: the first three numbers of coef are zero")
            own = along(np.array(n))
            own[:3, 3] = -d * np.array(n) / (np.array(n) @ n)
        called = name if len(shapes) == 1 else f"{name} {k + 1}"
        yield Entry(called, kind, size, whole @ _message_pose(pose) @ own, mesh, frame=frame)


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
    p = as_vector(_named(pose.get("position", [0.0, 0.0, 0.0]), "xyz"), "position")
    turn = as_vector(_named(pose.get("orientation", [0.0, 0.0, 0.0, 1.0]), "xyzw"), "orientation", 4)
    return pose_of(from_xyzw(turn) if turn.any() else np.eye(3), p)  # an empty message has zeros


def _matrix_pairs(
    matrix: Mapping[str, Any], parts: Mapping[str, list[str]], links: Iterable[str]
) -> Iterator[tuple[str, str]]:
    """The pairs that an allowed collision matrix exempts, objects by their parts.

    A pair that the matrix lacks has the default of its name. If both names have one, both must be true.
    """
    names = list(matrix.get("entry_names") or ())
    rows = [row["enabled"] if isinstance(row, dict) else row for row in matrix.get("entry_values") or ()]
    if {len(rows), *map(len, rows)} - {len(names)}:
        raise InputError(f"allowed_collision_matrix has {len(names)} names, but not as many rows and columns")
    default_of, default = (list(matrix.get(f"default_entry_{part}") or ()) for part in ("names", "values"))
    if len(default_of) != len(default):
        raise InputError(f"allowed_collision_matrix has {len(default_of)} default names for {len(default)} values")
    defaults = dict(zip(default_of, default, strict=True))
    row_of = {name: i for i, name in enumerate(names)}
    absent = {OCTOMAP} - parts.keys()
    every = dict.fromkeys(name for name in (*names, *links, *parts, *defaults) if name not in absent)
    for first, second in combinations(every, 2):
        if first in row_of and second in row_of:
            allowed = rows[row_of[first]][row_of[second]]
        else:
            given = [defaults[name] for name in (first, second) if name in defaults]
            allowed = bool(given) and all(given)
        if allowed:
            yield from product(parts.get(first, [first]), parts.get(second, [second]))


def _scene_text(path: Path) -> SceneFile:
    """MoveIt's text: for each object `* name`, since 2020 its pose, then its shapes."""
    with _at(path, "MoveIt's .scene text"):
        lines = iter(read_bounded(path, MOST_BYTES).decode("utf-8").splitlines()[1:])
        entries: list[Entry] = []
        unread: list[str] = []
        for line in lines:
            if line.strip() == ".":
                return SceneFile("", tuple(entries), unread=tuple(unread))
            if not line.startswith("*"):
                raise InputError(f"expected '* name' of an object; got {line!r}")
            found = list(_objects(_text_object(name := line[1:].strip(), lines)))
            entries += found
            unread += [] if found else [f"{name}, which has no shapes"]
        raise InputError("it does not end with a line '.': is it cut short?")


def _text_object(name: str, lines: Iterator[str]) -> dict[str, Any]:
    """An object of the text as its moveit_msgs/CollisionObject."""

    def numbers() -> list[float]:
        return [float(word) for word in next(lines).split()]

    item: dict[str, Any] = {"id": name}
    first = numbers()
    posed = len(first) == 3
    if posed:
        item["pose"] = {"position": first, "orientation": numbers()}
        first = numbers()
    for _ in range(int(first[0])):
        kind, size = next(lines).strip(), numbers()
        value: Any = size
        if kind == "mesh":  # how many points and triangles it has, then these
            points, faces = ([numbers() for _ in range(int(count))] for count in size)
            value = {"vertices": points, "triangles": faces}
        elif kind != "plane":
            value = {"type": kind, "dimensions": size[:: -1 if kind == "cylinder" else 1]}
            kind = "primitive"
        item.setdefault(LISTS[kind], []).append(value)
        item.setdefault(f"{kind}_poses", []).append({"position": numbers(), "orientation": numbers()})
        next(lines)  # the colour
    if posed:  # subframes: a name, a position and a rotation each
        for _ in range(3 * int(numbers()[0])):
            next(lines)
    return item
