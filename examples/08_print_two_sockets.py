"""Draw a plate with two spherical sockets for `twistarm calibrate`, to be printed: -o plate.stl writes it."""

import argparse

import numpy as np
import trimesh
from numpy.typing import NDArray

Array = NDArray[np.float64]

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--distance", type=float, default=100.0, help="between the centres of the sockets [mm]")
parser.add_argument("--ball", type=float, default=20.0, help="diameter of the ball [mm]")
parser.add_argument("--play", type=float, default=0.1, help="how much wider a socket is than the ball [mm]")
parser.add_argument("--floor", type=float, default=5.0, help="material below the sockets [mm]")
parser.add_argument("--margin", type=float, default=15.0, help="around the sockets, for clamps [mm]")
parser.add_argument("-o", "--output", metavar="FILE", help="the STL file to write, in millimetres")
given = parser.parse_args()
if not all(0 < each < 1000 for each in (given.distance, given.ball, given.floor, given.margin, given.play + 1e-9)):
    parser.error("lengths are in millimetres, between 0 and 1000")
if given.distance < given.ball + given.play + 2.0:
    parser.error(f"--distance must be at least {given.ball + given.play + 2.0:g} mm for this ball")

RINGS, SIDE = 32, 24  # of a socket, from rim to bottom; points on a side of the tile around it
radius = (given.ball + given.play) / 2
thick, edge = radius + given.floor, radius + given.margin


def tile() -> tuple[Array, NDArray[np.int64], Array]:
    """The left half of the top with its socket: vertices, triangles seen from above, and the tile's outline."""
    corners = np.array([[-edge, -edge], [given.distance / 2, -edge], [given.distance / 2, edge], [-edge, edge]])
    share = np.arange(SIDE)[:, None] / SIDE
    outline = np.concatenate([a + share * (b - a) for a, b in zip(corners, np.roll(corners, -1, 0), strict=True)])
    way = outline / np.linalg.norm(outline, axis=1, keepdims=True)
    down = np.linspace(0.0, np.pi / 2, RINGS + 1)[:-1]
    socket = [np.column_stack([radius * np.cos(t) * way, np.full(len(way), -radius * np.sin(t))]) for t in down]
    n, top = len(outline), np.column_stack([outline, np.zeros(len(outline))])
    vertices = np.concatenate([top, *socket, [[0.0, 0.0, -radius]]])
    a, b = np.arange(n), np.roll(np.arange(n), -1)
    rings = [np.vstack([np.column_stack([a, b, b + n]), np.column_stack([a, b + n, a + n])]) + n * k
             for k in range(RINGS)]  # fmt: skip
    bottom = np.column_stack([a + n * RINGS, b + n * RINGS, np.full(n, len(vertices) - 1)])
    return vertices, np.concatenate([*rings, bottom]), outline


def plate() -> trimesh.Trimesh:
    """The plate, its top at z = 0 and the sockets' centres on the x axis."""
    vertices, faces, outline = tile()
    left, right = vertices - [given.distance / 2, 0, 0], vertices * [-1, 1, 1] + [given.distance / 2, 0, 0]
    shifted = outline - [given.distance / 2, 0]
    outer = shifted[(shifted[:, 0] < -1e-9) | (np.abs(shifted[:, 1]) > edge - 1e-9)]
    rim = np.unique(np.round(np.concatenate([outer, outer * [-1, 1]]), 9), axis=0)
    rim = rim[np.argsort(np.arctan2(rim[:, 1], rim[:, 0]))]
    n, start = len(rim), 2 * len(vertices)
    walls = [np.column_stack([rim, np.full(n, z)]) for z in (0.0, -thick)]
    a, b = start + np.arange(n), start + np.roll(np.arange(n), -1)
    sides = [np.column_stack([a, a + n, b]), np.column_stack([b, a + n, b + n])]
    under = np.column_stack([b + n, a + n, np.full(n, start + 2 * n)])
    points = np.concatenate([left, right, *walls, [[0.0, 0.0, -thick]]])
    triangles = np.concatenate([faces, faces[:, ::-1] + len(vertices), *sides, under])
    return trimesh.Trimesh(np.round(points, 9), triangles)


mesh = plate()
assert mesh.is_watertight
assert mesh.is_winding_consistent
length, width, height = mesh.extents
solid = length * width * height - 4 / 3 * np.pi * radius**3
assert abs(mesh.volume / solid - 1.0) < 1e-3, "a box without two half balls"
for side in (-1, 1):  # each socket is the sphere that it should be: |p|² = 2 p·c + r² − |c|²
    p = mesh.vertices[np.abs(mesh.vertices[:, 2] + radius / 2) < 0.4 * radius]  # between rim and bottom
    p = p[p[:, 0] * side > 0]
    centre = np.linalg.lstsq(np.column_stack([2 * p, np.ones(len(p))]), (p**2).sum(axis=1), rcond=None)[0][:3]
    assert np.allclose(centre, [side * given.distance / 2, 0, 0], atol=1e-6)
print(f"plate {length:.1f} × {width:.1f} × {height:.1f} mm, {mesh.volume / 1000:.0f} cm³, {len(mesh.faces)} triangles")
print(f"sockets {2 * radius:.2f} mm wide, {given.distance:g} mm apart: --distance left=right={given.distance / 1000:g}")
if given.output:
    mesh.export(given.output, file_type="stl")
    print(f"written: {given.output}")
