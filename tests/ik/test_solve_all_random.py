"""Arms with random geometry of every family: what made a target is found, all is exact, nothing is there twice."""

import numpy as np
import pytest

from family_arms import assert_exact_and_different, joint_distance, pose_of, screws_of
from twistarm import Pose, arm_from_screws, solve_ik_all_batch, solve_ik_batch
from twistarm.ik.closed_form.methods import method_for

# Of each family; every second one has axes along x, y and z, and offsets of whole steps, many of them 0.
ARMS = 12

TARGETS = 10

pytestmark = pytest.mark.slow


class Geometry:
    """Directions and points at random: any, or as drawings have them."""

    def __init__(self, seed):
        self.rng = np.random.default_rng(seed)
        self.drawn = bool(seed[-1] % 2)

    def direction(self):
        w = self.rng.normal(size=3)
        return self.rng.choice([-1, 1]) * np.eye(3)[self.rng.integers(3)] if self.drawn else w / np.linalg.norm(w)

    def point(self):
        steps = np.where(self.rng.random(3) < 0.4, 0, self.rng.integers(-12, 13, 3))
        return 0.05 * steps if self.drawn else self.rng.uniform(-0.6, 0.6, 3)

    def some(self, kinds):
        return [[kind, self.direction(), self.point()] for kind in kinds]

    def mixed(self, count, slides=0.3):
        return self.some("P" if self.rng.random() < slides else "R" for _ in range(count))

    def spherical(self):
        """Three axes through a point, none along the next."""
        point = self.point()
        while True:
            w = [self.direction() for _ in range(3)]
            if min(np.linalg.norm(np.cross(w[i], w[i + 1])) for i in range(2)) > 0.2:
                return [["R", axis, point] for axis in w]

    def planar(self, kinds):
        """Parallel axes, and slides across them."""
        normal, group = self.direction(), []
        for kind in kinds:
            while np.linalg.norm(across := np.cross(normal, self.direction())) < 0.2:
                pass
            group.append([kind, normal if kind == "R" else across, self.point()])
        return group


def beside(group, others, at):
    return [*others[:at], *group, *others[at:]]


FAMILIES = {
    **{f"spherical at {i + 1}": (lambda g, i=i: beside(g.spherical(), g.mixed(3), i)) for i in range(4)},
    **{f"parallel at {i + 1}": (lambda g, i=i: beside(g.planar("RRR"), g.some("RRR"), i)) for i in range(4)},
    **{
        f"planar {kinds} at {i + 1}": (lambda g, i=i, kinds=kinds: beside(g.planar(kinds), g.mixed(3, 0.2), i))
        for i, kinds in enumerate(["RPR", "PRR", "RRP", "PRP"])
    },
    "five, spherical": lambda g: beside(g.spherical(), g.mixed(2), int(g.rng.integers(3))),
    "P or R, RRR, R": lambda g: beside(g.planar("RRR"), [*g.mixed(1, 0.5), *g.some("R")], 1),
    "R-RR-RR": lambda g: [*g.some("R"), *g.planar("RR"), *g.spherical()[:2]],
    "SCARA": lambda g: [*(group := g.planar("RRR")), ["P", group[0][1], g.point()]],
    "decoupled": lambda g: g.some(g.rng.permutation([*"RRRPPP"])),
    "one": lambda g: g.mixed(1),
    "two": lambda g: g.mixed(2),
    "three": lambda g: g.mixed(3),
    "four": lambda g: g.mixed(4),
}


@pytest.mark.parametrize("name", FAMILIES)
def test_all_roots_of_random_arms(name):
    whole = 0
    for k in range(ARMS):
        geometry = Geometry([len(name), ord(name[0]), k])
        rng, axes = geometry.rng, FAMILIES[name](geometry)
        turning = [kind == "R" for kind, *_ in axes]
        names = [f"joint{i + 1}" for i in range(len(axes))]
        bound = dict(zip(names, np.where(turning, np.pi, 1.0).tolist(), strict=True))
        lower = {joint: -value for joint, value in bound.items()}
        home = np.eye(4)
        home[:3, 3] = rng.uniform(-0.8, 0.8, 3)
        arm = arm_from_screws(screws_of(axes), home, joints=names, limits={"lower": lower, "upper": bound})
        method = method_for(arm, Pose(home))
        assert method.algebraic
        assert method.exact
        if method.sampled:  # drawn axes may be dependent; what is sampled is another test's
            continue
        whole += 1
        made = arm.random_theta(rng, TARGETS)
        poses = np.array([pose_of(arm, theta) for theta in made])
        for g, theta, found in zip(poses, made, solve_ik_all_batch(arm, poses), strict=True):
            assert found.complete
            assert_exact_and_different(arm, g, theta, found)
        assert_nothing_more(arm, poses[-1], found, rng)
    assert whole >= ARMS // 3


def assert_nothing_more(arm, g, found, rng):
    """Searches from many starts, where no answer belongs to a continuous family."""
    if any(found.free):
        return
    starts = arm.random_theta(rng, 30)
    batch = solve_ik_batch(arm, [Pose(g)] * 30, starts, restarts=1, position_tol=1e-10, orientation_tol=1e-10)
    everything = [*found.theta, *found.outside]
    for theta in batch.theta[batch.converged]:
        assert min(joint_distance(arm, answer, theta) for answer in everything) < 1e-4
