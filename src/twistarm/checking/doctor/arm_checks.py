"""Checks of an arm: its zero, home and ready configuration, its tool, axes and collisions."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np

from ...arm.abilities import ANGULAR, LINEAR, Abilities, spans
from ...arm.almost_exact import ALMOST_ANGLE, EXACT_ANGLE, almost_exact
from ...arm.arm import Arm
from ...arm.pinocchio_model import why_no_pinocchio
from ...collision import Scene
from ...collision.allowed_pairs import ALWAYS
from ...collision.survey import collision_shares
from ...description.companions.data_files import toml_key
from ...description.findings import Finding, Place, finding
from ...description.meshes import read_mesh
from ...description.source_text import SourceText
from ...description.tips import tool_rank
from ...description.tree import MOST_NAMES, Description, Geometry, Link, grouped
from ...ik import closed_form_of
from ...limits.joint_limits import slides
from ...support.checks import Array
from ...support.directions import axis_in_words, direction_in_words, length_in_words
from ...support.errors import TwistarmError, listed, one_line
from ...support.messages import Argument, Text, first_of, plural
from ...theory.manipulability import POOR, scaled_jacobian
from .description_checks import LONGEST_REACH, OTHER

# A condition number beyond which a configuration is singular in practice: one direction a thousand times slower.
SINGULAR_CONDITION = 1e3
NO_MOTION = 1e-9  # A column of the Jacobian this small [m/reach, rad] is zero but for rounding.
ROLLS = 0.98  # Cosine from which on a tool rolls about its axis: one beside the roll axis nearly does.
OUT = 0.1  # How far out [m] the tool of the snippet is, if the tip has no shape.
SIDED = 3.0  # How many times as far as to the other side the shapes of a link reach to the tool.
# Random configurations, and the share of them in which a pair collides by its drawing and not by the motion.
SAMPLES, OFTEN = 100, 0.8
MOST_BODIES = 100  # The most bodies to check: their pairs take 1 s. A robot with more is left out.
KINDS, WORDS = 4, 6  # Kinds of almost exact axes, and rounded angles, named before the rest is counted.


def place_of(arm: Arm) -> Place:
    """The description's file, or the arm's name without one."""
    return Place(arm.name) if arm.description is None else arm.description.place()


# -- reach and zero ---------------------------------------------------------------------------------------------------


def check_reach(arm: Arm) -> Iterator[Finding]:
    """Whether the arm's lengths can be metres."""
    if arm.reach > LONGEST_REACH:
        what = f"its reach is {arm.reach:.4g} m: its lengths look like another unit"
        remedy = f"write every <origin xyz> in metres: multiply by {OTHER['m'][1]:g} if they are millimetres"
        yield finding("unit-doubtful", place_of(arm), what, remedy)


def check_zero(arm: Arm) -> Iterator[Finding]:
    """Whether the zero configuration, which so many programs start from, lies inside the limits."""
    bounds = zip(arm.joint_names, arm.limits.lower, arm.limits.upper, strict=True)
    outside = [f"{name} [{lower:.4g}, {upper:.4g}]" for name, lower, upper in bounds if not lower <= 0.0 <= upper]
    if outside:
        what = f"the zero configuration is outside the limits of {first_of(outside, MOST_NAMES)}"
        yield finding("zero-outside-limits", place_of(arm), what, "do not command zeros: start from ready")


def check_postures(arm: Arm, rank: int) -> Iterator[Finding]:
    """Zero, home and ready configuration: the condition number of the `rank` directions of the arm's tool.

    A singular home that is also ready is a remark, not a warning. Most arms are delivered so.
    """
    homes = {"zero": np.zeros(arm.n)}
    if arm.named_states.get("home", homes["zero"]).any():
        homes["home"] = arm.named_states["home"]
    conditions = {name: _condition(arm, theta, rank) for name, theta in homes.items() if arm.limits.contains(theta)}
    singular = {name: number for name, number in conditions.items() if number > SINGULAR_CONDITION}
    at_ready = _condition(arm, arm.ready, rank)
    poor = at_ready > POOR
    if not (poor or singular):
        return
    best = arm.computed_ready
    at_best = _condition(arm, best, rank)
    advice = f"write in arm.toml, in rad and m (condition number {at_best:.1f}; check it in twistarm view first):"
    values = [f"{toml_key(name)} = {value:.6g}" for name, value in arm.theta_to_dict(best).items()]
    snippet = "\n".join([advice, "[poses.ready]", *values])
    if poor and at_best < at_ready / 10 and not any(np.array_equal(arm.ready, homes[name]) for name in singular):
        what = f"the ready configuration is nearly singular: condition number {_condition_words(at_ready)}"
        yield finding("ready-singular", place_of(arm), what, snippet)
    for name, number in singular.items():
        size = _condition_words(number)
        what = f"the {name} configuration is singular: condition number {size}; motions that start there stall or jump"
        fit = arm.ready_name is not None and not poor
        remedy = f"start from ready (condition number {at_ready:.1f})" if fit else snippet
        yield finding("home-singular", place_of(arm), what, remedy)


def _condition(arm: Arm, theta: Array, rank: int) -> float:
    """σ_1/σ_rank at theta (n,): the condition number with what the arm lacks everywhere left out."""
    return float(arm.manipulability(theta).condition_in(rank))


def _condition_words(value: float) -> str:
    return "∞" if value > 1e9 else f"{value:.3g}"


# -- the tool ----------------------------------------------------------------------------------------------------------


def summary(arm: Arm, able: Abilities) -> str:
    """One line: the directions of motion, of six, and how they split."""
    spare = arm.n - able.rank
    turns = f"turns it in place about {able.turning} of 3" if able.turning else "its position fixes its orientation"
    text = f"moves its tool along {able.position} of 3 axes, {turns}"
    return f"{text}; {plural(spare, 'joint')} to spare" if spare else text


def check_abilities(arm: Arm, able: Abilities) -> Iterator[Finding]:
    """The directions in which the tool's position, and its orientation, cannot change at almost every posture."""
    place = place_of(arm)
    if able.position < 3:
        what = f"moves its tool's position in {able.position} of 3 directions at any configuration"
        if len(able.immovable):
            what += f", never along {_axes(able.immovable, 'base')}"
        remedy = "ask only for positions there; solve_ik gives the nearest to any other"
        yield finding("cannot-move", place, what, remedy)
    if len(able.unrotated):
        what = f"never turns its tool about {_axes(able.unrotated, 'base')}"
        remedy = "leave these rotations free: a Position, or a TolerancedPose with inf for them"
        yield finding("cannot-turn", place, what, remedy)
    if able.turning + len(able.unrotated) < 3:
        what = f"with its position held, turns its tool about {able.turning} of 3 axes"
        always = [_axes(able.rotated_tool, "tool"), _axes(able.rotated_base, "base")]
        if any(always):
            what += f", always about {' and '.join(filter(None, always))}"
        yield finding("cannot-turn-in-place", place, what, _instead_of_a_pose(arm, able))


def _axes(axes: Array, frame: str) -> str:
    return " and ".join(axis_in_words(axis, frame) for axis in axes)


def _instead_of_a_pose(arm: Arm, able: Abilities) -> str:
    nearest = "solve_ik gives the nearest to any other target and says what is missing"
    if able.position < 3:
        return nearest
    if able.turning < 2:
        return f"ask for a Position; {nearest}"
    # Two free rotations turn the axis of an `Approach` in both directions across it, unless one is about it.
    rolls = np.median([np.linalg.norm(U.T @ arm.tool_axis) for U in spans(arm, ANGULAR, LINEAR, "tool")]) > ROLLS
    what = f"an Approach: a position and where the tool points, by {direction_in_words(arm.tool_axis, 'tool')}"
    plane = ", which must lie in the plane in which the arm bends; or for a Position" if rolls else ""
    return f"ask for {what}{plane}; {nearest}"


def check_without_effect(arm: Arm) -> Iterator[Finding]:
    """Coordinates with a zero column of the Jacobian everywhere."""
    J = scaled_jacobian(arm.body_jacobian(arm.random_theta(0, SAMPLES)), arm.prismatic, arm.reach)
    sizes = np.abs(J).max(axis=(0, 1))
    for name, size in zip(arm.joint_names, sizes, strict=True):
        if size <= NO_MOTION:
            what = f"joint {name!r} never moves the tool: other joints undo its motion"
            yield finding("joint-without-effect", place_of(arm), what, "look at the mimics behind it, or lock it")


def check_off_the_chain(arm: Arm, description: Description) -> Iterator[Finding]:
    """Independent joints that no coordinate of the arm moves: fingers, wheels, a second arm."""
    moved = {name for name, affine in arm.couplings.items() if affine.master in arm.joint_names}
    idle = [
        joint
        for joint in description.joints.values()
        if joint.moving and joint.name not in moved and joint.name not in arm.moving_names and joint.mimic is None
    ]
    if idle:
        what = f"not between {arm.base} and {arm.tip_link}, so without effect on the tool"
        remedy = Text("nothing, if that is meant; else pass {tip}", tip=Argument("tip"))
        yield grouped("off-the-chain", description, idle, what, remedy)


def check_tool(arm: Arm, description: Description) -> Iterator[Finding]:
    """A tip that is the last joint's link without a tool's name: its origin is on that joint's axis."""
    last = description.chain(arm.base, arm.tip_link)[-1]
    named = tool_rank(arm.tip_link) is not None
    if last.moving and not slides(last.type) and not named and np.array_equal(arm.tool, np.eye(4)):
        end = _end_of(description.links[arm.tip_link], arm.tool_axis)
        xyz = ", ".join(f"{value + 0.0:.6g}" for value in (end or OUT) * arm.tool_axis)
        guess = f"measure it; a tool that grips {OUT:g} m along {direction_in_words(arm.tool_axis, 'tool')} has"
        yield finding(
            "tool-frame-missing",
            description.place(description.links[arm.tip_link]),
            f"the tool is the frame of {last.name}, with its origin on that joint's axis: where it grips is unknown",
            f"write in arm.toml where the tool is, seen from {one_line(arm.tip_link)} [m, rad], "
            f"{'for the end of its shapes' if end else guess}:\n"
            f'[tool]\nname = "tool"\nxyz = [{xyz}]\nrpy = [0.0, 0.0, 0.0]',
        )


def _end_of(link: Link, axis: Array) -> float | None:
    """Where [m] the shapes of a link end along an axis (3,) through its origin. None if they reach to both sides."""
    along = [0.0]
    for shape in (*link.visuals, *link.collisions):
        along += ((_points_of(shape) @ shape.origin[:3, :3].T + shape.origin[:3, 3]) @ axis).tolist()
    low, high = min(along), max(along)
    end = high if high > -low else low
    return end if abs(end) > SIDED * min(-low, high) else None


def _points_of(shape: Geometry) -> Array:
    """Points (N, 3) on all sides of a shape, in its frame. None of an unreadable mesh."""
    if shape.shape == "mesh":
        with suppress(TwistarmError):
            pieces = read_mesh(shape.mesh or Path()).pieces
            return np.concatenate([piece.corners.reshape(-1, 3) for piece in pieces]) * shape.size
        return np.zeros((0, 3))
    wide, long = 2 * shape.size[0], shape.size[-1] if len(shape.size) > 1 else 2 * shape.size[0]
    length = long + wide if shape.shape == "capsule" else long
    size = shape.size if shape.shape == "box" else (wide, wide, length)
    return np.array(size) * (np.array([*np.ndindex(2, 2, 2)]) - 0.5)


# -- axes --------------------------------------------------------------------------------------------------------------


def check_axes(arm: Arm) -> Iterator[Finding]:
    """One finding for all axes that are almost special, and one if they just miss a closed form by rounding."""
    found = almost_exact(arm.screws, arm.home, arm.moving_names, arm.reach)
    if found:
        joints: dict[str, list[str]] = {}
        for near in found:
            joints.setdefault(near.what, []).append(near.joints)
        kinds = first_of([f"{', '.join(names)} {what}" for what, names in joints.items()], KINDS)
        off = length_in_words(sum(near.moves for near in found))
        what = f"{kinds}; exact axes would move the tool by about {off}"
        yield finding("axes-almost-exact", place_of(arm), what, _rewriting(arm))
    report = closed_form_of(arm)
    if report.nearly and not report.held:
        what = (
            f"{report.miss}: a {report.target} has no exact closed form; solve_ik_all refines the answers of the "
            "nearest exact arm, and may miss some"
        )
        remedy = f"{_rewriting(arm)}; exact axes give every configuration, and the proof that a target has none"
        yield finding("axes-almost-exact", place_of(arm), what, remedy)


def _rewriting(arm: Arm) -> str:
    """The rounded angles in the chain's origins, each once and without its sign."""
    words: list[str] = []
    if arm.description is not None:
        chain = {joint.name for joint in arm.description.chain(arm.base, arm.tip_link)}
        joints = SourceText(arm.description.text).robot.findall("joint")
        origins = [joint.find("origin") for joint in joints if joint.get("name") in chain]
        words = [
            word.lstrip("+-") for origin in origins if origin is not None for word in origin.get("rpy", "").split()
        ]
    rounded = [word for word in words if EXACT_ANGLE < abs(math.remainder(float(word), math.pi / 2)) < ALMOST_ANGLE]
    if not rounded:
        return "if the drawing says so, write the chain's origins and axes with 16 digits"
    given = first_of(list(dict.fromkeys(rounded)), WORDS)
    return f"write multiples of {math.pi / 2!r} for {given} in <origin rpy>"


# -- collisions --------------------------------------------------------------------------------------------------------


def check_collisions(arm: Arm) -> Iterator[Finding]:
    """Pairs of links by the shapes of a `Scene`. Pairs that always collide are exempt without an SRDF."""
    if arm.description is None or len(arm.description.links) > MOST_BODIES or why_no_pinocchio():
        return
    scene, exempt = Scene(arm), arm.disabled_collisions
    if len(scene.links) > MOST_BODIES:
        return
    shares = collision_shares(scene, arm.random_theta(0, SAMPLES))
    often = {pair for pair, share in shares.items() if share >= OFTEN and (exempt or share < ALWAYS)} - exempt
    at_ready = {pair for pair in collision_shares(scene, [arm.ready]) if shares.get(pair, 0.0) < OFTEN} - exempt
    allow = "if they may touch, add disable_collisions to the SRDF (twistarm collisions writes one)"
    for pairs, when, remedy in (
        (at_ready, "at the ready configuration", f"look at it with twistarm view; correct it or the shapes; {allow}"),
        (often, "in most configurations", f"correct the shapes; {allow}"),
    ):
        if pairs:
            what = f"links collide {when}: {listed(f'{a} – {b}' for a, b in sorted(pairs))}"
            yield finding("links-collide", place_of(arm), what, remedy)
