"""The surface of a map: closed, turned outwards, as large as its cubes, and around the tool wherever it is."""

import numpy as np
import pytest

from twistarm import reach_map
from twistarm.viewer.parts.reach import hull


def volume(points, faces):
    """By the divergence theorem."""
    return np.linalg.det(points[faces]).sum() / 6


def winding(points, faces, p):
    """How often the surface goes round points (k, 3), by the solid angles of its triangles.

    A. van Oosterom & J. Strackee, The solid angle of a plane triangle, IEEE Trans. Biomed. Eng. 30(2), 1983.
    """
    a, b, c = np.moveaxis(points[faces] - p[:, None, None], 2, 0)
    la, lb, lc = (np.linalg.norm(each, axis=-1) for each in (a, b, c))
    ab, bc, ca = ((u * v).sum(axis=-1) for u, v in ((a, b), (b, c), (c, a)))
    across = (a * np.cross(b, c)).sum(axis=-1)
    return np.arctan2(across, la * lb * lc + ab * lc + bc * la + ca * lb).sum(axis=-1) / (2 * np.pi)


def ball(radius):
    x = np.arange(-12, 13)
    return (x[:, None, None] ** 2 + x[:, None] ** 2 + x**2 <= radius**2).astype(float)


def test_a_ball_has_its_volume_and_no_edge_is_open():
    points, faces, values = hull(7 * ball(10))
    assert 9.9**3 < volume(points, faces) / (4 / 3 * np.pi) < 10.1**3
    radii = np.linalg.norm(points - 12, axis=1)
    assert 9.3 < radii.min() < radii.max() < 10.7
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    there, count = np.unique(edges, axis=0, return_counts=True)
    back, again = np.unique(edges[:, ::-1], axis=0, return_counts=True)
    assert np.array_equal(there, back)
    assert np.array_equal(count, again)
    assert np.all(values == 7)


def test_a_hollow_has_a_wall_on_its_inside():
    points, faces, _ = hull(ball(10) - ball(5))
    p = np.array([[12.0, 12.0, 12.0], [12.0, 12.0, 19.5], [12.0, 12.0, 24.0]])
    assert winding(points, faces, p) == pytest.approx([0, 1, 0], abs=1e-9)


def test_the_tool_never_leaves_it_by_more_than_a_cube(rover):
    m = reach_map(rover, 0.15, "position", method="fk", samples=500_000)
    points, faces, _ = hull(m.counts)
    points = m.grid.voxel * (points + m.grid.lower)
    p = rover.fk(rover.random_theta(7, 300))[:, :3, 3]
    inside = winding(points, faces, p) > 0.5
    assert inside.mean() > 0.9
    assert (np.linalg.norm(p[~inside, None] - points, axis=2).min(axis=1) < m.grid.voxel).all()
    assert not (winding(points, faces, 5 * np.eye(3)) > 0.5).any()
