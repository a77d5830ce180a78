"""Files of point clouds: PLY, PCD, NPY and plain text, and MoveIt's octomaps."""

from __future__ import annotations

import hashlib
import io
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..support.checks import Array, as_reals
from ..support.csv_lines import csv_rows, known_columns
from ..support.errors import InputError, listed
from ..support.files import kind_of, read_bounded, why_no_file, write_whole

# Bytes of a file of points. 10 million points as float32 have 120 MB.
LARGEST_FILE = 200_000_000
FARTHEST = 200.0  # Points farther from a cloud's origin [m] are in millimetres, or no obstacles.
PLY_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
PLY_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


def read_points(path: Path) -> Array:
    """The points (N, 3) [m] of a .ply, .pcd, .npy, .xyz, .txt or .csv file.

    The file must be in metres. A PCD marks rays without an echo by NaN: these are left out. Raises InputError for what
    cannot be read.
    """
    readers: dict[str, Callable[[bytes], Array]] = {
        ".ply": _ply, ".pcd": _pcd, ".npy": _npy, ".xyz": _text, ".txt": _text, ".csv": _text,
    }  # fmt: skip
    kind = path.suffix.lower()
    if kind not in readers:
        raise InputError(f"{path} is no file of points that is read; its name must end with {listed(readers)}")
    data = b""
    try:
        data = read_bounded(path, LARGEST_FILE)
        return readers[kind](data)
    except OSError as error:
        why = why_no_file(path, error)
    except InputError as error:
        why = str(error)
    except Exception as error:  # NumPy raises many kinds for malformed rows
        why = f"its contents are malformed ({error or type(error).__name__})"
    other = kind_of(data)
    raise InputError(f"{path}: it is {other[0]}; {other[1]}" if other else f"{path}: {why}")


def as_points(points: Any) -> Array:
    """Points (N, 3) from numbers or a file."""
    from_file = isinstance(points, Path)
    array, what = (read_points(points), str(points)) if from_file else (as_reals(points, "points"), "points")
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(f"{what} must be (N, 3); got {array.shape}")
    if not len(array):
        raise InputError(f"{what}: there are no points")
    bad = int((~np.isfinite(array).all(axis=1)).sum())
    if bad:
        raise InputError(f"{what}: {bad:,} of {len(array):,} points are not finite; leave them out")
    if (far := np.abs(array).max()) > FARTHEST:
        raise InputError(
            f"{what}: a point is {far:.4g} m from the origin; at most {FARTHEST:g} m are taken: are these millimetres?"
        )
    return array


def _npy(data: bytes) -> Array:
    array = np.load(io.BytesIO(data), allow_pickle=False)
    if array.ndim != 2 or array.shape[1] < 3 or array.dtype.kind not in "fiu":
        raise InputError(f"the array must be (N, 3) of numbers; got {array.shape} of {array.dtype}")
    return array[:, :3].astype(np.float64)


def _text(data: bytes) -> Array:
    """Rows that begin with x, y, z [m], or that a row of names precedes, with other units in brackets.

    Commas beside semicolons are decimal points.
    """
    text, places, factors = data.decode("utf-8-sig"), [0, 1, 2], [1.0, 1.0, 1.0]
    first = text.partition("\n")[0]
    rows = (text.replace(",", ".").replace(";", " ") if ";" in text else text.replace(",", " ")).splitlines()
    if rows and not re.match(r"\s*([-+.\d]|nan|inf|#|$)", rows[0], re.I):
        heads, rows = next(csv_rows([first], "")).cells, rows[1:]
        columns, _ = known_columns(heads, dict(zip("xyz", "xyz", strict=True)), dict.fromkeys("xyz", "m"), "its header")
        if len(columns) < 3:
            raise InputError(f"it has no x, y and z, with their units as in x [mm] or none; it has {listed(heads)}")
        places, factors = map(list, zip(*(columns[axis] for axis in "xyz"), strict=True))
    rows = [row for row in rows if row.partition("#")[0].strip()]
    return np.loadtxt(rows, usecols=places, ndmin=2) * factors if rows else np.empty((0, 3))


def _ply(data: bytes) -> Array:
    head, _, body = data.partition(b"end_header")
    body = body[2:] if body.startswith(b"\r\n") else body[1:]
    words = [line.split() for line in head.decode("ascii").splitlines()]
    if not words or words[0] != ["ply"] or b"end_header" not in data:
        raise InputError("it has no header of a PLY")
    order = next((word[1] for word in words if word[:1] == ["format"]), "")
    elements = [i for i, word in enumerate(words) if word[:1] == ["element"]]
    if order not in PLY_ORDERS or not elements or words[elements[0]][1] != "vertex":
        raise InputError("its format is unknown, or vertices are not its first element")
    properties = [word for word in words[slice(*[*elements, None][:2])] if word[0] == "property"]
    if any(word[1] == "list" for word in properties):
        raise InputError("its vertices have lists")
    types = [(word[2], PLY_ORDERS[order] + PLY_TYPES[word[1]]) for word in properties]
    return _rows(body, types, int(words[elements[0]][2]), text=order == "ascii")


def _pcd(data: bytes) -> Array:
    found = re.search(rb"^DATA[ \t]+(\w+)[ \t]*\r?\n", data, re.M)
    if found is None:
        raise InputError("it has no header of a PCD")
    head = {line.split()[0]: line.split()[1:] for line in data[: found.start()].decode("ascii").splitlines() if line}
    kind = found[1].decode()
    if kind not in ("ascii", "binary"):
        raise InputError(f"DATA {kind} is not read; convert it: pcl_convert_pcd_ascii_binary IN.pcd OUT.pcd 1")
    letters = {"F": "f", "I": "i", "U": "u"}
    counts = map(int, head.get("COUNT", ["1"] * len(head["FIELDS"])))
    given = zip(head["FIELDS"], head["TYPE"], head["SIZE"], counts, strict=True)
    # A field of several numbers has a column for each. Fields for padding may have one name.
    types = [
        (name if count == 1 else f"{name} {i}", f"<{letters[letter]}{size}")
        for name, letter, size, count in given
        for i in range(count)
    ]
    points = _rows(data[found.end() :], types, int(head["POINTS"][0]), text=kind == "ascii")
    return points[np.isfinite(points).all(axis=1)]


def _rows(body: bytes, types: Sequence[tuple[str, str]], count: int, text: bool) -> Array:
    """The columns x, y, z of `count` rows."""
    names = [name for name, _ in types]
    if not {"x", "y", "z"} <= {*names}:
        raise InputError(f"it has no x, y and z; it has {listed(names)}")
    places = [names.index(axis) for axis in "xyz"]
    if text:
        points = np.loadtxt(io.BytesIO(body), usecols=places, ndmin=2, max_rows=count) if count else np.empty((0, 3))
        present = len(points)
    else:
        row = np.dtype([(f"{i}", kind) for i, (_, kind) in enumerate(types)])
        present = min(count, len(body) // row.itemsize)
        rows = np.frombuffer(body, row, present)
        points = np.column_stack([rows[f"{i}"] for i in places]).astype(np.float64)
    if present < count:
        raise InputError(f"it is cut short: {count:,} points are announced and {present:,} are there")
    return points


def write_points(points: Array, scene: Path, name: str) -> Path:
    """Write the points (N, 3) of the cloud `name` as a .npy file beside a scene's file. Return its path.

    Its name has a digest of the points, so it replaces no file with others.
    """
    buffer = io.BytesIO()
    np.save(buffer, points)
    plain = re.sub(r"[^A-Za-z0-9_-]+", "_", name).strip("_")[:50]
    digest = hashlib.sha256(buffer.getvalue()).hexdigest()[:12]
    return write_whole(scene.with_name(f"{scene.stem}_{plain}_{digest}.npy"), buffer.getvalue())


# -- octomaps ----------------------------------------------------------------------------------------------------

DEPTH = 16  # Levels of every octomap.
MOST_OCCUPIED = 5_000_000
LEAST_VOXEL, LARGEST_VOXEL = 1e-3, 10.0


def octomap_points(message: Mapping[str, Any]) -> tuple[Array, float]:
    """The centres (k, 3) of the occupied voxels of an octomap_msgs/Octomap, and their side [m].

    A large occupied cell counts with all of its voxels. Unknown space counts as free. Source of the format: OctoMap
    1.9, OcTreeBaseImpl::readData and OccupancyOcTreeBase::readBinaryData.
    """
    voxel = float(message["resolution"])
    if not LEAST_VOXEL <= voxel <= LARGEST_VOXEL:
        raise InputError(f"resolution must be {LEAST_VOXEL:g} to {LARGEST_VOXEL:g} m; got {voxel:g}")
    if (name := str(message.get("id", "OcTree"))) not in ("OcTree", "ColorOcTree"):
        raise InputError(f"an octomap of type {name!r} is not read; write an OcTree")
    if name == "ColorOcTree" and not message["binary"]:
        raise InputError("a ColorOcTree is read in its binary form only: publish octomap_binary")
    data = (np.array(message["data"], dtype=np.int64) % 256).astype(np.uint8).tobytes()
    cells = [*_leaves(_binary_nodes(data) if message["binary"] else _full_nodes(data))] if data else []
    sides = [1 << (DEPTH - level) for _, level in cells]
    if (count := sum(side**3 for side in sides)) > MOST_OCCUPIED:
        raise InputError(f"its cells have {count:,} occupied voxels of {voxel:g} m; at most {MOST_OCCUPIED:,} are read")
    corners = [
        np.array(corner) + np.indices((side,) * 3).reshape(3, -1).T
        for (corner, _), side in zip(cells, sides, strict=True)
    ]
    points: Array = np.concatenate(corners) if corners else np.empty((0, 3))
    return (points - (1 << (DEPTH - 1)) + 0.5) * voxel, voxel


Leaf = tuple[tuple[int, int, int], int]
"""The lowest corner of an occupied cell, in voxels, and its level."""


def _child(corner: tuple[int, int, int], level: int, i: int) -> Leaf:
    half = 1 << (DEPTH - level - 1)
    x, y, z = corner
    return (x + half * (i & 1), y + half * (i >> 1 & 1), z + half * (i >> 2 & 1)), level + 1


Node = tuple[bool, int, int]
"""Whether a node is an occupied leaf; eight bits for its occupied children, and for those that are nodes too."""


def _leaves(nodes: Iterable[Node]) -> Iterator[Leaf]:
    """The occupied cells of nodes that come depth first."""
    waiting: list[Leaf] = [((0, 0, 0), 0)]
    for is_leaf, occupied, inner in nodes:
        if not waiting:
            return
        corner, level = waiting.pop()
        if level >= DEPTH and occupied | inner:
            raise InputError("its cells are nested too deeply")
        if is_leaf:
            yield corner, level
        yield from (_child(corner, level, i) for i in range(8) if occupied >> i & 1)
        waiting += [_child(corner, level, i) for i in reversed(range(8)) if inner >> i & 1]
    if waiting:
        raise InputError("its data is cut short")


def _binary_nodes(data: bytes) -> Iterator[Node]:
    """Two bits a child: 1 for free, 2 for occupied, 3 for a node."""
    for row in np.frombuffer(data, "<u2", len(data) // 2).tolist():
        kinds = [row >> 2 * i & 3 for i in range(8)]
        occupied, inner = (sum(1 << i for i, kind in enumerate(kinds) if kind == wanted) for wanted in (2, 3))
        yield False, occupied, inner


def _full_nodes(data: bytes) -> Iterator[Node]:
    """For each node its log-odds as float32, occupied from 0 on, and a bit for each child."""
    rows = np.frombuffer(data, np.dtype([("odds", "<f4"), ("children", "u1")]), len(data) // 5)
    for odds, children in zip(rows["odds"].tolist(), rows["children"].tolist(), strict=True):
        yield not children and odds >= 0.0, 0, children
