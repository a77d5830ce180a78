"""Maps of reach: against geometry by hand and `solve_ik`, with scenes, as files."""

import io
from dataclasses import replace

import numpy as np
import pytest

from catalogue import load
from twistarm import Approach, InputError, ReachMap, Scene, arm_from_screws, joints, load_arm, reach_map, solve_ik
from twistarm.design import mapping
from twistarm.design.mapping import sphere
from twistarm.design.voxel_map import Grid
from urdf_text import joint, robot, write


@pytest.fixture(scope="module")
def planar():
    """Links of 0.4 m and 0.275 m in the plane z = 0, joints without limits."""
    arm = load("rr_planar")
    return arm, reach_map(arm, 0.16, "position")


@pytest.fixture(scope="module")
def around(rover):
    return reach_map(rover, 0.35, 26)


def centres(m):
    return m.grid.centres(np.arange(m.grid.count))


def test_a_planar_arm_reaches_its_ring(planar):
    arm, m = planar
    upper = 0.4
    fore = arm.home[0, 3] - upper
    p = centres(m)
    r = np.hypot(p[:, 0], p[:, 1])
    ring = (r <= upper + fore) & (r >= upper - fore) & (np.abs(p[:, 2]) < 1e-9)
    assert np.array_equal(m.counts.reshape(-1) > 0, ring)
    assert m.volume == pytest.approx(ring.sum() * 0.16**3)
    elbow = np.arccos((r[ring] ** 2 - upper**2 - fore**2) / (2 * upper * fore))
    expected = arm.manipulability(np.column_stack([0 * elbow, elbow])).yoshikawa
    assert m.manipulability.reshape(-1)[ring] == pytest.approx(expected, abs=1e-5)
    assert np.isnan(m.manipulability.reshape(-1)[~ring]).all()
    assert np.isinf(m.margin.reshape(-1)[ring]).all()


def test_slides_reach_the_box_of_their_limits():
    screws = np.hstack([joints.prismatic(axis) for axis in np.eye(3)])
    home = np.eye(4)
    home[:3, 3] = [0.1, 0.0, 0.2]
    limits = {"lower": {"a": -0.3, "b": 0.0, "c": -0.11}, "upper": {"a": 0.3, "b": 0.24, "c": 0.31}}
    arm = arm_from_screws(screws, home, joints=["a", "b", "c"], limits=limits)
    m = reach_map(arm, 0.1, [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    p = centres(m) - home[:3, 3]
    lower, upper = (np.array(list(limits[end].values())) for end in ("lower", "upper"))
    inside = ((p >= lower - 1e-6) & (p <= upper + 1e-6)).all(axis=1)
    assert np.array_equal(m.counts.reshape(-1), inside)  # one of the two directions: the tool does not turn
    margin = np.minimum(p - lower, upper - p).min(axis=1)
    assert m.margin.reshape(-1)[inside] == pytest.approx(margin[inside], abs=2e-6)


@pytest.mark.parametrize("name", ["rover_arm", "elbow", "stanford"])
def test_claims_are_those_of_inverse_kinematics(name):
    arm = load(name)
    m = reach_map(arm, 0.2, 26 if name == "elbow" else "down")
    rng = np.random.default_rng(5)
    reached = np.flatnonzero(m.counts)
    for cell in [*rng.choice(reached, 15), *rng.integers(m.grid.count, size=15)]:
        p = m.grid.centres(np.array([cell]))[0]
        verdicts = [solve_ik(arm, Approach(p, direction)).converged for direction in m.directions]
        assert m.at(p) == np.mean(verdicts), p


def test_no_configuration_leaves_the_grid(catalogue_arm):
    m = reach_map(catalogue_arm, 0.3 * catalogue_arm.reach, "position", method="fk", samples=10)
    assert (m.grid.cells(catalogue_arm.fk(catalogue_arm.random_theta(3, 20_000))[:, :3, 3]) >= 0).all()


def test_followers_and_locked_joints_count_as_the_arm_has_them(tmp_path):
    slide = '<axis xyz="{}"/><limit lower="-0.3" upper="0.3" velocity="1" effort="1"/>'
    flat = {"kind": "prismatic", "xyz": "0 0 0"}
    parts = [
        joint("a", "base", "l1", inside=slide.format("1 0 0"), **flat),
        joint("b", "l1", "l2", inside=slide.format("0 1 0") + '<mimic joint="a" multiplier="-1"/>', **flat),
        joint("c", "l2", "tool", inside=slide.format("0 0 1"), **flat),
    ]
    arm = load_arm(write(tmp_path, robot(*parts, links=("base", "l1", "l2", "tool"))), locked_joints={"c": 0.2})
    m = reach_map(arm, 0.1, "position")
    line = [[x, -x, 0.2] for x in np.arange(-3, 4) / 10]
    assert (m.at(line) == 1.0).all()
    assert m.counts.sum() == len(line)
    assert m.require(arm) is m
    with pytest.raises(InputError, match="another arm"):
        m.require(load_arm(tmp_path / "arm.urdf"))


def test_a_scene_takes_away_what_collides(rover):
    scene = Scene(rover, margin=0.01)
    scene.add_box("wall", (0.1, 3.0, 3.0), (0.55, 0.0, 0.0))
    free, m = reach_map(rover, 0.4, scene=scene), reach_map(rover, 0.4)
    assert free.counts.any()
    assert (free.counts <= m.counts).all()
    lost = np.flatnonzero(m.counts.reshape(-1) > free.counts.reshape(-1))
    assert (centres(m)[np.flatnonzero(free.counts), 0] < 0.5).all(), "nothing behind the wall"
    for cell in lost[:: max(len(lost) // 10, 1)]:
        assert not solve_ik(rover, Approach(centres(m)[cell], [0, 0, -1]), scene=scene).converged


def test_random_configurations_find_what_kinematics_finds(rover):
    exact, first = reach_map(rover, 0.2, "position"), reach_map(rover, 0.2, "position", method="fk", samples=300_000)
    assert first.grid == exact.grid
    missed = (exact.counts > 0) & (first.counts == 0)
    assert missed.sum() <= 0.01 * (exact.counts > 0).sum()
    p = rover.fk(rover.random_theta(1, 1000))[:, :3, 3]
    assert (first.at(p) > 0).mean() > 0.99


def test_lookup_and_slices_agree(around):
    p = np.array([[0.5, 0.0, 0.5], [9.0, 0.0, 0.0]])
    assert around.at(p).shape == (2,)
    assert around.at(p)[1] == 0.0
    assert around.at([0.8, 0.12, 0.6]) == around.at([0.6, -0.12, 0.8])
    x, y = around.grid.along(0), around.grid.along(1)
    at = around.at(np.stack(np.meshgrid(x, y, [0.5], indexing="ij"), axis=-1)[:, :, 0])
    assert np.array_equal(around.slice("z", 0.45), at)
    assert 0.0 < around.share.max() <= 1.0
    for wrong in (("w", 0.0), ("z", 99.0)):
        with pytest.raises(InputError):
            around.slice(*wrong)


def test_files(around, rover, tmp_path):
    path = around.save(tmp_path / "map.npz")
    again = ReachMap.load(path).require(rover)
    assert again.save(tmp_path / "again.npz").read_bytes() == path.read_bytes()
    assert (again.frame, again.grid, again.settings) == ("base_link", around.grid, around.settings)
    assert np.array_equal(again.counts, around.counts)
    pytest.importorskip("matplotlib")
    image = pytest.importorskip("PIL.Image").open(io.BytesIO(around.to_png(tmp_path / "map.png").read_bytes()))
    assert image.size == (1200, 420)
    other = io.BytesIO()
    np.savez(other, head=np.array('{"format": "a log"}'), counts=np.zeros(3))
    flat = replace(around, counts=around.counts.ravel()).save(tmp_path / "flat.npz")
    small = replace(around, margin=around.margin[1:]).save(tmp_path / "small.npz")
    above = replace(around, counts=around.counts + np.uint16(27)).save(tmp_path / "above.npz")
    whole, headless = path.read_bytes(), io.BytesIO()
    np.savez(headless, head=np.array("null"), counts=np.zeros(3))
    method = whole.index(b"PK\x01\x02") + 10
    unknown = whole[:method] + b"\x63" + whole[method + 1 :]  # a compression that zipfile does not have
    files = (file.read_bytes() for file in (flat, small, above))
    for content in (b"", b"PK\x03\x04", whole[:500], other.getvalue(), headless.getvalue(), unknown, *files):
        (tmp_path / "bad.npz").write_bytes(content)
        with pytest.raises(InputError, match="bad.npz"):
            ReachMap.load(tmp_path / "bad.npz")
    with pytest.raises(InputError):
        ReachMap.load(tmp_path / "none.npz")


def test_a_map_too_large_for_the_memory_names_the_size_that_fits(rover):
    with pytest.raises(InputError, match="memory") as said:
        reach_map(rover, 1e-4)
    fits = float(str(said.value).split()[-3])
    assert 1e-4 < fits < 1e-2
    assert 13 * Grid.about(*sphere(rover), fits).count < mapping.MOST_BYTES


@pytest.mark.parametrize(
    "wrong",
    [
        {"voxel": 0.0}, {"voxel": 50}, {"voxel": "5cm"}, {"directions": "up"}, {"directions": 27}, {"directions": []},
        {"directions": [[0, 0, 0]]}, {"directions": None}, {"method": "mc"}, {"samples": 0}, {"scene": "table"},
    ],
)  # fmt: skip
def test_unusable_arguments(rover, wrong):
    with pytest.raises(InputError) as said:
        reach_map(rover, **{"voxel": 0.3, **wrong})
    assert "\n" not in str(said.value)
