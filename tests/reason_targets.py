"""Targets whose reason is known by construction, each with its proof; nothing here asks a solver.

A builder draws one target for an arm and returns it as a pose g (4, 4), or None where the draw proves nothing. Poses
and distances come from Pinocchio (`ik_targets.pinocchio_fk`, its joint placements), optima from SciPy.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import islice
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from scipy.optimize import minimize, minimize_scalar
from scipy.spatial.transform import Rotation

from catalogue import load
from ik_targets import at_some_limits, pinocchio_fk
from twistarm import available_arms
from twistarm.ik import StopReason

MARGIN = 0.01  # How far [m, rad] a proof must hold beyond its bound; the solver's tolerance is 1e-6.
BEYOND = (1.002, 3.0)  # Times the farthest reach at which targets out of reach lie.
SINGULAR = 1e-7  # A singular value below this, of those of the Jacobian in m and rad, is none.
SLANT = 1e-4  # How far the axes of a drawing may be from square [rad]: files round.
MOST_DRAWS = 1000  # For each target.
BOX = 0.05  # Half the width [rad, m] of the limits that shut an arm in.


# inside the limits: CONVERGED ---------------------------------------------------------------------------------


def inside(arm, rng):
    """A random configuration's pose: it is met there."""
    return pinocchio_fk(arm, arm.random_theta(rng))


def at_limits(arm, rng):
    """Each joint at a bound with probability 1/2: met there."""
    return pinocchio_fk(arm, at_some_limits(arm, rng, 1)[0])


def singular(arm, rng):
    """A configuration where the Jacobian has lost rank: at quarter turns, or where a random line meets such a place.

    A redundant arm's are too few for a line to meet them: two conditions, not one.
    """
    for place in (at_quarter_turns, on_a_line)[: 2 if arm.n <= 6 else 1]:
        theta = place(arm, rng)
        if least_singular_value(arm, theta) < SINGULAR:
            return pinocchio_fk(arm, theta)
    return None


def at_quarter_turns(arm, rng):
    """Joints at multiples of a quarter turn, all but a random few."""
    theta = arm.random_theta(rng)
    straight = rng.random(arm.n) < 0.7
    quarter = np.clip(np.round(theta / (np.pi / 2)) * (np.pi / 2), arm.limits.lower, arm.limits.upper)
    return np.where(straight, quarter, theta)


def on_a_line(arm, rng):
    """Where, between two random configurations, the least singular value is smallest."""
    first, last = arm.random_theta(rng, 2)

    def value(t):
        return least_singular_value(arm, first + t * (last - first))

    t = min(np.linspace(0, 1, 65), key=value)
    near = minimize_scalar(value, bounds=(max(t - 1 / 64, 0), min(t + 1 / 64, 1)), options={"xatol": 1e-12})
    return first + near.x * (last - first)


def least_singular_value(arm, theta):
    """Of those of Pinocchio's Jacobian that are not 0 almost everywhere."""
    J = arm.pinocchio.kinematics(np.atleast_2d(theta), arm.base, arm.tip_link)[2][0]
    return np.linalg.svd(J, compute_uv=False)[min(6, arm.n) - 1]


# farther than the arm is long: OUT_OF_REACH -------------------------------------------------------------------


@cache
def placements(arm):
    """Of each moving joint from base to tip: its placement on the one before (4, 4), and at last the tool's."""
    model, frame = arm.pinocchio.model, arm.pinocchio.model.frames[arm.pinocchio.frame_id(arm.tip_link)]
    base = model.frames[arm.pinocchio.frame_id(arm.base)]
    assert base.parentJoint == 0, "the base must stand still"
    assert np.array_equal(arm.coupling.A, np.eye(arm.n)), "each coordinate must be one joint"
    path = [joint for joint in model.supports[frame.parentJoint] if joint > 0]
    steps = [model.jointPlacements[joint].homogeneous for joint in path]
    steps[0] = base.placement.inverse().homogeneous @ steps[0]
    return [*steps, frame.placement.homogeneous @ arm.tool]


def slides(arm):
    return np.array([kind == "prismatic" for kind in arm.joint_types])


def free_direction(arm):
    """The direction (3,) in base axes along which a slide moves the tool at every configuration; zeros without slides.

    It stands still if all joints before the slide turn about it. None where a slide's direction changes.
    """
    directions = np.zeros(3)
    for i in np.flatnonzero(slides(arm)):
        columns = [hybrid(arm, theta)[:3, i] for theta in arm.random_theta(np.random.default_rng(1), 8)]
        if np.ptp(columns, axis=0).max() > 1e-9 or directions.any():
            return None
        directions = columns[0]
    return directions


def hybrid(arm, theta):
    """Pinocchio's Jacobian (6, n) in base axes, at the tool's frame."""
    (g,), _, (J,) = arm.pinocchio.kinematics(np.atleast_2d(theta), arm.base, arm.tip_link)
    return np.vstack([g[:3, :3] @ J[:3], g[:3, :3] @ J[3:]])


@cache
def longest(arm):
    """A bound [m] of how far the tool gets from the first joint's origin: all links in one line, and no slide."""
    return float(sum(np.linalg.norm(step[:3, 3]) for step in placements(arm)[1:]))


@cache
def farthest(arm):
    """How far [m] the tool gets from the first joint's origin, across `free_direction`: the best of SciPy's ascents.

    Without limits; the slides, which add nothing across their direction, stand still.
    """
    still, origin = slides(arm), placements(arm)[0][:3, 3]
    across = np.eye(3) - np.outer(free_direction(arm), free_direction(arm))

    def negative(theta):
        offset = across @ (pinocchio_fk(arm, theta)[:3, 3] - origin)
        slope = hybrid(arm, theta)[:3].T @ offset
        return -0.5 * offset @ offset, -np.where(still, 0.0, slope)

    starts = np.where(still, 0.0, np.random.default_rng(2).uniform(-np.pi, np.pi, (40, arm.n)))
    best = min(minimize(negative, start, jac=True, method="BFGS").fun for start in starts)
    reach = float(np.sqrt(-2 * best))
    assert reach <= longest(arm) + 1e-9
    return reach


def out_of_reach(arm, rng):
    """Beyond `farthest` from the first joint's origin, in a random orientation: no theta, limits or not, gets there."""
    direction = free_direction(arm)
    if direction is None:
        return None
    away = rng.normal(size=3)
    away -= direction * (direction @ away)
    g = np.eye(4)
    g[:3, :3] = Rotation.random(random_state=rng.integers(2**31)).as_matrix()
    g[:3, 3] = placements(arm)[0][:3, 3] + rng.uniform(*BEYOND) * farthest(arm) * away / np.linalg.norm(away)
    g[:3, 3] += direction * rng.uniform(-0.3, 0.3)
    return g


# arms of fewer than six joints: IMPOSSIBLE_DIRECTION ----------------------------------------------------------


def impossible_direction(arm, rng):
    """A reachable position with the tool's approach where no joint turns it: see the proof for each kind of arm."""
    special = {"rr_planar": tilted, "scara": tilted, "rover_arm": out_of_the_plane}
    return special.get(arm.name, beside_the_plane)(arm, rng)


def tilted(arm, rng):
    """Every joint turns about the vertical or slides along it, so the tool's z is the vertical one at every theta."""
    assert np.ptp([pinocchio_fk(arm, theta)[:3, 2] for theta in arm.random_theta(rng, 4)], axis=0).max() < 1e-9
    g = inside(arm, rng)
    angle, heading = rng.uniform(0.05, 3.0), rng.uniform(0, 2 * np.pi)
    g[:3, :3] = g[:3, :3] @ Rotation.from_rotvec(angle * np.array([np.cos(heading), np.sin(heading), 0])).as_matrix()
    return g


@cache
def tool_roll_axis(arm):
    """The last joint's axis (3,) in tool axes, in which it stands still."""
    J = arm.pinocchio.kinematics(np.zeros((1, arm.n)), arm.base, arm.tip_link)[2][0]
    return J[3:, -1] / np.linalg.norm(J[3:, -1])


def roll_axis(arm, g):
    """The last joint's axis (3,) in base axes."""
    return g[:3, :3] @ tool_roll_axis(arm)


def out_of_the_plane(arm, rng):
    """Slide, pitch, pitch, pitch, roll: the roll axis is square to the pitch axis, which stands still in the base.

    It is tilted out of that plane by an angle, which no configuration can miss by less, and one misses by no more.
    """
    normals = np.array([hybrid(arm, theta)[3:, [1, 2, 3]].T for theta in arm.random_theta(rng, 4)]).reshape(-1, 3)
    assert np.ptp(normals, axis=0).max() < 1e-9
    g = inside(arm, rng)
    a = roll_axis(arm, g)
    assert abs(normals[0] @ a) < 1e-9
    g[:3, :3] = Rotation.from_rotvec(rng.uniform(0.1, 1.5) * np.cross(a, normals[0])).as_matrix() @ g[:3, :3]
    return g


@cache
def plane_offsets(arm):
    """Pan, pitch, pitch, pitch, roll: (least, greatest) distance [m] of the tool from the vertical plane of the pan.

    With n(θ₁) the pitch joints' common axis: n is square to the pan axis and to the roll axis, and the distance
    n · (p − o), o on the pan axis, hangs on θ₅ alone, because pan and pitch leave it: it is a sine of θ₅.
    """
    rng, origin = np.random.default_rng(3), placements(arm)[0][:3, 3]
    distances = []
    for theta in arm.random_theta(rng, 200):
        g, J = pinocchio_fk(arm, theta), hybrid(arm, theta)
        n = J[3:, 1]
        assert np.abs(np.cross(J[3:, [1, 2, 3]].T, n)).max() < SLANT, "the pitch axes must be parallel"
        assert max(abs(n @ J[3:, 0]), abs(n @ roll_axis(arm, g))) < SLANT, "and square to pan and roll"
        distances.append(n @ (g[:3, 3] - origin))
    middle, radius = np.mean([min(distances), max(distances)]), np.ptp(distances) / 2
    return middle - 1.1 * radius - SLANT, middle + 1.1 * radius + SLANT


def beside_the_plane(arm, rng):
    """A pose turned about the vertical: where its roll axis is to point, the arm's plane misses its position.

    Pointing the roll axis a along w asks for n square to w and to the pan axis z, so n = ± z × w / ‖z × w‖, whatever
    theta is. Then n · (p − o) would have to lie among `plane_offsets`, on either side, and lies outside by the margin.
    """
    g, z = inside(arm, rng), hybrid(arm, np.zeros(arm.n))[3:, 0]
    g[:3, :3] = Rotation.from_rotvec(rng.uniform(0.1, 1.5) * rng.choice([-1, 1]) * z).as_matrix() @ g[:3, :3]
    n = np.cross(z, roll_axis(arm, g))
    if np.linalg.norm(n) < 0.2:
        return None
    distance = n @ (g[:3, 3] - placements(arm)[0][:3, 3]) / np.linalg.norm(n)
    least, greatest = plane_offsets(arm)
    missed = min(max(least - side * distance, side * distance - greatest) for side in (-1, 1))
    return g if missed > MARGIN else None


# met only outside the limits: BLOCKED_BY_LIMITS ---------------------------------------------------------------


@cache
def shut_in(name, k):
    """The arm with its limits narrowed to a box of half width `BOX` about a random configuration, the k-th."""
    arm = load(name)
    lower, upper = arm.sampling_bounds
    middle = np.random.default_rng([5, k]).uniform(np.minimum(lower + BOX, upper - BOX), upper - BOX)
    limits = replace(arm.limits, lower=middle - BOX, upper=middle + BOX)
    return replace(arm, limits=limits, named_states={})


@cache
def box_bounds(arm):
    """How far [m] and [rad] the tool gets from where it is in the middle of its box.

    A joint that turns by dθ moves the tool by at most r dθ and turns it by at most dθ, a slide moves it by dθ. r is at
    most the length of all that follows the joint, the slides as far as their range lets them.
    """
    half = (arm.limits.upper - arm.limits.lower) / 2
    extended = [np.linalg.norm(step[:3, 3]) for step in placements(arm)[1:]]
    drawn = np.where(slides(arm), np.maximum(np.abs(arm.limits.lower), np.abs(arm.limits.upper)), 0.0)
    radius = [sum(extended[i:]) + drawn[i + 1 :].sum() for i in range(arm.n)]
    position = np.where(slides(arm), 1.0, radius) @ half
    return float(position), float(half[~slides(arm)].sum())


def outside_the_box(arm, rng):
    """A pose of a configuration outside the box, farther from the box's middle than anything in it.

    It is met without limits, where it was made; it is not met inside, by `box_bounds`.
    """
    g = pinocchio_fk(arm, load(arm.name).random_theta(rng))
    centre = pinocchio_fk(arm, (arm.limits.lower + arm.limits.upper) / 2)
    position, angle = box_bounds(arm)
    moved = np.linalg.norm(g[:3, 3] - centre[:3, 3])
    turned = np.linalg.norm(pin.log3(centre[:3, :3].T @ g[:3, :3]))
    return g if moved > position + MARGIN or turned > angle + MARGIN else None


# all of them --------------------------------------------------------------------------------------------------


class Case(NamedTuple):
    """Which targets, what must be said of them, and of which arms of the catalogue they are made."""

    name: str
    builder: Callable[..., np.ndarray | None]
    stop: StopReason
    arms: tuple[str, ...]


EVERY = available_arms()
SHORT = ("rr_planar", "scara", "rover_arm", "so100", "so101")  # Arms of fewer than six joints.

CASES = (
    Case("inside", inside, StopReason.CONVERGED, EVERY),
    Case("at limits", at_limits, StopReason.CONVERGED, EVERY),
    # The Jacobian of rr_planar has rank 2 everywhere.
    Case("singular", singular, StopReason.CONVERGED, tuple(name for name in EVERY if name != "rr_planar")),
    # The slide of stanford, drawn out far enough, reaches everything.
    Case("out of reach", out_of_reach, StopReason.OUT_OF_REACH, tuple(name for name in EVERY if name != "stanford")),
    Case("impossible direction", impossible_direction, StopReason.IMPOSSIBLE_DIRECTION, SHORT),
    Case("outside the box", outside_the_box, StopReason.BLOCKED_BY_LIMITS, EVERY),
)


def arms_of(case, name, count):
    """The arms among which `count` targets are shared: the catalogue's, or several boxes of it."""
    return [shut_in(name, k) for k in range(count)] if case.builder is outside_the_box else [load(name)]


def draw(builder, arm, rng, count):
    """`count` poses of a builder (count, 4, 4), redrawn where one proves nothing."""
    drawn = (builder(arm, rng) for _ in range(MOST_DRAWS * count))
    poses = list(islice((g for g in drawn if g is not None), count))
    assert len(poses) == count, f"{builder.__name__} proves only {len(poses)} of {count} for {arm.name}"
    return np.array(poses)
