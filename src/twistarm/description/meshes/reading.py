"""`read_mesh` reads the file of a mesh by its format, and keeps the meshes read last. COLLADA is read by pycollada."""

from __future__ import annotations

import io
import os
import re
import threading
from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from ...support.checks import Array
from ...support.errors import TwistarmError, one_line
from ...support.files import KINDS, LOOKED_AT, is_file, kind_of, read_bounded, stamp
from ...support.interrupts import interruptible
from ...support.wheels import Wheel, load
from ..document import decoded
from ..packages import home_of, is_too_wide
from .mesh import REMEDY, Colour, Mesh, Piece, RefusedError, UnreadableMeshError

# Endings of materials and buffers, by format. Images are not drawn, so they are not opened.
ENDINGS = {"obj": ".mtl", "gltf": ".bin", "glb": ".bin"}
Stamps = dict[Path, tuple[int, ...] | None]  # Files, also missing ones, with their `stamp` when they were read.


class Resolver:
    """Reads at most `left` bytes for trimesh, in the package of the mesh at `path`, or in its folder without one.

    It adds each file to `files`. `refused` holds the first refusal, because some readers go on without the file.
    """

    file_name = "mesh"

    def __init__(self, kind: str, path: Path, left: int, files: Stamps) -> None:
        self._ending, self._place, self._left = ENDINGS.get(kind), Path(os.path.realpath(path)), left
        self._files = files
        self.refused: RefusedError | None = None

    def get(self, name: Any) -> bytes:
        """The bytes of a file. FileNotFoundError if there is none, RefusedError if it must not be read."""
        what = f"it refers to {one_line(str(name), 80)!r}"
        if not isinstance(name, str) or Path(name).suffix.lower() != self._ending:
            raise FileNotFoundError(f"{what}, which is not opened")
        try:
            spelling = name.strip().replace("\\", "/")
            places = [Path(os.path.realpath(self._place.parent / written)) for written in (spelling, unquote(spelling))]
            place, root = next(filter(is_file, places), places[0]), home_of(self._place)
            if is_too_wide(root) or not place.is_relative_to(root):
                raise RefusedError(f"{what}, a file outside its package")
            self._files[place] = stamp(place)
            data = read_bounded(place, self._left)
        except FileNotFoundError:
            raise FileNotFoundError(f"{what}, which is not there") from None
        except (RefusedError, OSError, ValueError) as error:
            why = f"{what}, which cannot be read: {getattr(error, 'strerror', error)}"
            self.refused = self.refused or (error if isinstance(error, RefusedError) else RefusedError(why))
            raise self.refused from None
        self._left -= len(data)
        return as_utf8(data) if self._ending == ".mtl" else data

    __getitem__ = get

    def keys(self) -> list[str]:
        """No names, so trimesh searches nothing."""
        return []

    def namespaced(self, name: str) -> Resolver:
        """The same resolver, so that all names start in this folder."""
        return self


def as_utf8(data: bytes) -> bytes:
    """Text in Latin-1 as UTF-8: trimesh would look for a library that guesses."""
    try:
        data.decode()
    except UnicodeDecodeError:
        return data.decode("latin-1").encode()
    return data


# Bytes of a binary STL before the count of facets, before the first facet, and of one facet.
COUNT, HEAD, FACET = 80, 84, 50
MOST_MISSING = 1000  # A file that announces so many times its facets is not a binary STL.

_VERTEX = re.compile(rb"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)", re.I)


def stl_corners(data: bytes) -> Array:
    """The triangles (F, 3, 3). As in assimp, bytes may follow the last facet, and a text may lack its end."""
    promised = int.from_bytes(data[COUNT:HEAD], "little") if len(data) >= HEAD else -1
    is_solid = data[:LOOKED_AT].lstrip().lower().startswith(b"solid") and b"\0" not in data[:HEAD]
    if is_solid and len(data) != HEAD + FACET * promised:
        vertices = _VERTEX.findall(data)
        if len(vertices) % 3:
            raise RefusedError("it is cut short in the middle of a facet")
        return np.array(vertices, dtype=np.bytes_).astype(np.float64).reshape(-1, 3, 3)
    present = (len(data) - HEAD) // FACET
    if promised > MOST_MISSING * present > 0:
        raise RefusedError("it is no STL")  # the bytes of another kind of file would be a count too
    if promised > present or promised < 0:
        what = f": {promised:,} triangles are announced and {present:,} are there" if promised >= 0 else ""
        raise RefusedError(f"it is cut short{what}")
    return np.ndarray((promised, 3, 3), "<f4", data, HEAD + 12, (FACET, 12, 4))


# Bytes of a mesh file, and of all that it refers to. The largest of some hundred arms has 5 MB.
LARGEST_FILE = 100_000_000
# Plain formats that exporters write. Archives unpack to any size, so they are not read. CAD formats are not either.
FORMATS = ("stl", "obj", "dae", "ply", "glb", "gltf")
# Extensions of glTF whose buffers are packed.
COMPRESSED = (b"KHR_draco_mesh_compression", b"EXT_meshopt_compression", b"KHR_meshopt_compression")
MOST_KEPT = 2_000_000  # Triangles of all meshes that are kept: 140 MB.

# 4.6 is the first with load_scene, which takes an opened file and asks our resolver for what that refers to.
_TRIMESH = Wheel("trimesh", "trimesh", has="load_scene", oldest="4.6")

SAMPLE = 3_000  # Vertices of a mesh among which its outermost points are sought.

_LOCK = threading.RLock()
_kept: OrderedDict[Path, tuple[Mesh, Stamps]] = OrderedDict()


def read_mesh(path: Path) -> Mesh:
    """The triangles of the mesh file at `path`. An unchanged file is read once for drawing and for collisions.

    Raises UnreadableMeshError for a file that is no mesh of these `FORMATS`, or larger than `LARGEST_FILE`.
    """
    with _LOCK:
        mesh, files = _kept.pop(path, (None, {}))
        if mesh is None or any(stamp(file) != before for file, before in files.items()):
            files = {path: stamp(path)}
            mesh = _read(path, files)
        _kept[path] = mesh, files
        while len(_kept) > 1 and sum(kept.triangles for kept, _ in _kept.values()) > MOST_KEPT:
            _kept.popitem(last=False)
        return mesh


def extreme_points(path: Path) -> Array:
    """The outermost points (N, 3) of an STL in some 100 directions, without another library.

    They are among `SAMPLE` vertices, evenly spread over the file, in a hundredth of the time for all of them.
    Raises UnreadableMeshError for another format, and as `read_mesh`.
    """
    with _named(path):
        if path.suffix.lower() != ".stl":
            raise RefusedError("its outermost points are read from STL only")
        corners = stl_corners(read_bounded(path, LARGEST_FILE))
        points = corners[:: 1 + 3 * len(corners) // SAMPLE].reshape(-1, 3).astype(np.float64)
        if not len(points) or not np.isfinite(points).all():
            raise RefusedError("it has no points, or some that are no finite numbers")
    # Along the axes, between two or three of them, and between those: 49 directions, each for both of its ends.
    grid = np.array(list(np.ndindex(5, 5, 5)), dtype=np.float64) - 2.0
    along = grid[np.abs(grid).max(axis=1) == 2.0][:49] @ points.T
    return points[np.unique([along.argmax(axis=1), along.argmin(axis=1)])]


def _read(path: Path, files: Stamps) -> Mesh:
    """The mesh. The files that it refers to are added to `files`."""
    kind = path.suffix.lower().removeprefix(".")
    with _named(path):
        if kind not in FORMATS:
            raise RefusedError(f"{f'.{kind} files are' if kind else 'a file without an ending is'} not read here")
        data = read_bounded(path, LARGEST_FILE)
        if not data.strip():
            raise RefusedError("it is empty")
    with _named(path, data):
        if kind == "stl":
            return Mesh([Piece(stl_corners(data).astype(np.float64), None)])
        return Mesh(collada_pieces(data) if kind == "dae" else _by_trimesh(kind, data, path, files))


# Meshes by their first bytes: a file may have the name of another format.
MESHES = {
    rb"ply\s": ("a PLY", "let its name end with .ply"),
    rb"glTF": ("a GLB", "let its name end with .glb"),
    rb"(\s|#.*\n)*(mtllib|usemtl|[ogsv]|v[nt])\s+\S": ("an OBJ", "let its name end with .obj"),
    rb"(?s)\s*(<\?xml.*?\?>)?\s*<COLLADA\b": ("a COLLADA", "let its name end with .dae"),
    rb"(?i)\s*solid\b(?=.*\s*facet\b)": ("an STL", "let its name end with .stl"),
    rb"ISO-10303-21": ("a STEP file", REMEDY),
}

_COMMA = re.compile(rb"[\s>]([-+]?\d+,\d+(?:e[-+]?\d+)?)[\s<]", re.I)


@contextmanager
def _named(path: Path, data: bytes = b"") -> Iterator[None]:
    """Raise any error of a reader of the `data` as UnreadableMeshError."""
    remedy = REMEDY
    try:
        yield
        return
    except TwistarmError as error:
        reason, remedy = str(error), "install it"
    except RefusedError as error:
        reason = str(error)
    except OSError as error:
        reason = error.strerror or str(error)
    except (RecursionError, MemoryError) as error:
        reason = "it is nested too deeply" if isinstance(error, RecursionError) else "it does not fit into memory"
    except Exception as error:  # a reader raises whatever a file makes it stumble over, and quotes what it likes
        reason = f"its contents are malformed ({type(error).__name__})"
        if b"\0" not in data[:LOOKED_AT] and (comma := _COMMA.search(data)):
            reason, remedy = f"it has decimal commas ({comma[1].decode()})", "export it with decimal points"
    other, remedy_of = kind_of(data, KINDS | MESHES) or ("", "")
    if other and not remedy_of.endswith(path.suffix.lower()):  # else it is what its name says, and broken
        reason, remedy = f"it is {other}", remedy_of
    raise UnreadableMeshError(path, one_line(reason, 300), remedy)


def _by_trimesh(kind: str, data: bytes, path: Path, files: Stamps) -> list[Piece]:
    """The pieces of an OBJ, PLY or glTF. Materials and buffers in other files come from the mesh's package."""
    trimesh = load(_TRIMESH)
    if kind in ("gltf", "glb") and any(word in data for word in COMPRESSED):
        raise RefusedError("it is compressed by Draco or meshopt, which is not read here")
    if kind == "obj":
        data = as_utf8(data)
    resolver: Any = Resolver(kind, path, LARGEST_FILE - len(data), files)
    with interruptible():  # trimesh catches a Ctrl-C here and there, and goes on
        # `shaded` welds what trimesh would merge.
        scene = trimesh.load_scene(io.BytesIO(data), file_type=kind, resolver=resolver, process=False)
        if resolver.refused:
            raise resolver.refused
        instances = [
            (scene.geometry[name], g) for g, name in (scene.graph[node] for node in scene.graph.nodes_geometry)
        ]
        return [Piece(_corners(mesh, g), _colour(mesh)) for mesh, g in instances if isinstance(mesh, trimesh.Trimesh)]


def _corners(mesh: Any, g: Array) -> Array:
    """The triangles (F, 3, 3) of `mesh` at the pose `g`. A mirroring pose reverses their order of corners."""
    vertices, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces)
    if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise RefusedError("its triangles name vertices that it does not have")
    if not np.array_equal(g, np.eye(4)):
        with np.errstate(all="ignore"):  # `Mesh` refuses what is not finite
            vertices = vertices @ g[:3, :3].T + g[:3, 3]
            faces = faces[:, ::-1] if np.linalg.det(g[:3, :3]) < 0 else faces
    corners: Array = vertices[faces]
    return corners


def _colour(mesh: Any) -> Colour | None:
    if mesh.visual.kind is None:
        return None
    paint = mesh.visual.material if mesh.visual.kind == "texture" else mesh.visual
    if paint.main_color is None:  # of several materials, none of which has one
        return None
    red, green, blue, alpha = np.clip(np.ravel(paint.main_color)[:4] / 255.0, 0.0, 1.0).tolist()
    return red, green, blue, alpha


# Weights of red, green and blue by ITU-R BT.709. COLLADA 1.5 takes them for the opacity of a colour.
LUMINANCE = (0.212671, 0.715160, 0.072169)

_DECLARATION = re.compile(r"\s*<\?xml[^>]*\?>")

_PYCOLLADA = Wheel("collada", "pycollada", has="Collada", oldest="0.8")


def collada_pieces(data: bytes) -> list[Piece]:
    """A piece for each set of triangles or polygons. The up axis is ignored, as in RViz."""
    text = _DECLARATION.sub("", decoded(data), count=1)  # so that its parser reads what is examined here
    if not text.lstrip().startswith("<") or "PK\5\6" in text:  # pycollada would unpack an archive
        raise RefusedError("it is no XML")
    if "<!DOCTYPE" in text:
        raise RefusedError("it has a document type, which is not allowed in any file")
    collada = load(_PYCOLLADA)
    document = collada.Collada(io.BytesIO(text.encode()), ignore=[collada.DaeError])
    metres = document.assetInfo.unitmeter
    metres = 1.0 if metres is None else float(metres)
    if not (np.isfinite(metres) and metres > 0):
        raise RefusedError(f"its unit is {metres:g} m")
    shapes = [] if document.scene is None else document.scene.objects("geometry")
    return [piece for shape in shapes for piece in _pieces(collada, shape, metres)]


def _pieces(collada: Any, shape: Any, metres: float) -> list[Piece]:
    """The pieces of one geometry where a node places it."""
    g = np.asarray(shape.matrix, dtype=np.float64)
    made = []
    for primitive in shape.original.primitives:
        if isinstance(primitive, collada.polylist.Polylist):
            primitive = primitive.triangleset()
        if not isinstance(primitive, collada.triangleset.TriangleSet) or primitive.vertex is None:
            continue  # lines
        vertices = np.asarray(primitive.vertex, dtype=np.float64) @ g[:3, :3].T + g[:3, 3]
        corners = metres * vertices[primitive.vertex_index]
        node = shape.materialnodebysymbol.get(primitive.material)
        colour = _of_vertices(primitive) if node is None else _of_effect(node.target.effect)
        made.append(Piece(corners[:, ::-1] if np.linalg.det(g[:3, :3]) < 0 else corners, colour))
    return made


def _of_effect(effect: Any) -> Colour:
    """The diffuse colour with the opacity of the effect. White in place of a texture."""
    if not isinstance(effect.diffuse, tuple):
        return 1.0, 1.0, 1.0, 1.0
    red, green, blue = np.clip(effect.diffuse[:3], 0.0, 1.0).tolist()
    return red, green, blue, _opacity(effect.xmlnode)


def _opacity(effect: Any) -> float:
    """The share of light that is held back, by the mode of `transparent`. The alpha of `diffuse` has no effect."""
    share = float(effect.findtext(".//{*}transparency/{*}float") or 1.0)
    mode, transparent = "A_ONE", effect.find(".//{*}transparent")
    if transparent is not None:
        mode, colour = transparent.get("opaque", mode), transparent.findtext("{*}color")
        if colour is None:  # a texture, which is not drawn
            return 1.0
        *light, alpha = ([float(x) for x in colour.split()] + [1.0] * 4)[:4]
        share *= float(np.dot(LUMINANCE, light)) if mode.startswith("RGB") else alpha
    return min(max(0.0, 1.0 - share if mode.endswith("ZERO") else share), 1.0)


def _of_vertices(primitive: Any) -> Colour | None:
    """The colour of most corners, where each vertex has one."""
    sources = primitive.sources.get("COLOR")
    if not sources or not len(primitive.index):
        return None
    colours: Array = np.asarray(sources[0][4].data)[primitive.index[:, :, sources[0][0]]]
    values, counts = np.unique(colours.reshape(-1, colours.shape[-1]), axis=0, return_counts=True)
    red, green, blue, alpha = np.clip([*values[counts.argmax()], 1.0][:4], 0.0, 1.0).tolist()
    return red, green, blue, alpha
