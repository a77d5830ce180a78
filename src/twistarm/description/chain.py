"""The chain from base to tip, without Pinocchio: mimic and locked joints, screws, home, limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..limits.joint_limits import FIELDS, JointLimits, slides, unit_of
from ..support.checks import Array, as_number
from ..support.errors import UnknownNameError, closest, listed, unknown_name
from ..support.messages import Argument, Quantity, Text
from ..theory.lower_pairs import lower_pairs
from ..theory.screws import adjoint, exp
from .findings import Finding, finding, refusal
from .tree import Description, Joint


class Affine(NamedTuple):
    """value = multiplier · (value of the independent joint `master`) + offset. Without a master, value = offset."""

    master: str | None
    multiplier: float
    offset: float


def resolve_couplings(description: Description, locked_joints: Mapping[str, float]) -> dict[str, Affine]:
    """For every moving joint of the tree the independent joint that it follows, also through other mimics.

    Raises DescriptionError for a missing master, or for joints that mimic each other in a circle. Raises
    UnknownNameError for an unknown locked joint, InputError for a value that is not a number.
    """
    moving = {joint.name: joint for joint in description.joints.values() if joint.scalar}
    for name in locked_joints:
        if name not in moving:
            if parts := [joint.name for joint in moving.values() if joint.part_of == name]:
                what = f"joint {name!r} of {description.name} is planar"
                raise UnknownNameError(f"{what}; lock its coordinates: {listed(parts)}")
            within = Text("{robot}, for {locked}", robot=description.name, locked=Argument("locked_joints", None))
            raise unknown_name("moving joint", name, moving, within=within, listing=f"{len(moving)} moving joints")
        as_number(locked_joints[name], f"locked_joints[{name!r}]")
    return {name: _follow(description, name, locked_joints) for name in moving}


def coupling_matrix(
    couplings: Mapping[str, Affine], joints: Sequence[str], coordinates: Sequence[str]
) -> tuple[Array, Array]:
    """(A, b) with joint values = A @ theta + b. Masters outside `coordinates` count as 0."""
    A, b = np.zeros((len(joints), len(coordinates))), np.zeros(len(joints))
    column = {name: i for i, name in enumerate(coordinates)}
    for row, name in enumerate(joints):
        affine = couplings[name]
        b[row] = affine.offset
        if affine.master in column:
            A[row, column[affine.master]] = affine.multiplier
    return A, b


def _follow(description: Description, name: str, locked_joints: Mapping[str, float]) -> Affine:
    """Follow the mimic elements to a joint that is independent, locked or fixed."""
    multiplier, offset = 1.0, 0.0
    behind: dict[str, None] = {}
    while True:
        joint = description.joints[name]
        if name in locked_joints:
            return Affine(None, 0.0, multiplier * float(locked_joints[name]) + offset)
        if not joint.moving or multiplier == 0.0:  # a multiplier of 0 holds the follower still
            return Affine(None, 0.0, offset)
        if joint.mimic is None:
            if not joint.scalar:
                place = description.place(description.joints[next(iter(behind), name)])
                what = f"it mimics {name!r}, which is {joint.type}: its motion is not one number"
                raise refusal("mimic-unusable", place, what, "let it mimic another joint")
            return Affine(name, multiplier, offset)
        if name in behind:
            what = f"joints mimic each other in a circle: {', '.join(behind)}"
            raise refusal("mimic-unusable", description.place(joint), what, "let one of them move by itself")
        behind[name] = None
        offset += multiplier * joint.mimic.offset
        multiplier *= joint.mimic.multiplier
        name = joint.mimic.joint
        if name not in description.joints:
            remedy = f"correct the name{closest(name, description.joints)}"
            what = f"it mimics {name!r}, which does not exist"
            raise refusal("mimic-unusable", description.place(joint), what, remedy)


@dataclass(frozen=True)
class WalkedChain:
    """The chain from base to tip. `coordinates` are the independent joints, `moving` are all moving ones.

    `screws` (6, m) and `home` (4, 4) belong to the moving joints, with every coordinate at 0. Joint values are
    A @ theta + b with `coupling` = (A, b). `reach` [m] is the length of the path from the first turning joint to the
    tip. `couplings` covers the whole tree.
    """

    coordinates: tuple[str, ...]
    types: tuple[str, ...]
    moving: tuple[str, ...]
    screws: Array
    home: Array
    coupling: tuple[Array, Array]
    limits: JointLimits
    reach: float
    couplings: Mapping[str, Affine]
    findings: tuple[Finding, ...]


def walk_chain(description: Description, base: str, tip: str, tool: Array, locked: Mapping[str, float]) -> WalkedChain:
    """Walk from `base` to `tip`, and on by the fixed pose `tool` (4, 4) of the tool in the tip link's frame.

    Raises DescriptionError for a floating joint on the way, or if no joint moves between base and tip.
    """
    joints = description.chain(base, tip)
    for joint in joints:
        if joint.type == "floating":
            what = f"between {base!r} and {tip!r} it is floating: its motion is not one number per joint"
            remedy = Text("choose a {base} beyond it", base=Argument("base"))
            raise refusal("no-chain", description.place(joint), what, remedy)
    couplings = resolve_couplings(description, locked)
    moving = tuple(joint.name for joint in joints if joint.moving)
    coordinates = tuple(dict.fromkeys(m for name in moving if (m := couplings[name].master) is not None))
    if not coordinates:
        what = f"no joint moves between base {base!r} and tip {tip!r}"
        remedy = Text("choose another {base} or {tip}", base=Argument("base"), tip=Argument("tip"))
        raise refusal("no-chain", description.place(), what, remedy)
    A, b = coupling_matrix(couplings, moving, coordinates)
    screws, home, points = _walk(joints, dict(zip(moving, b, strict=True)))
    masters = [description.joints[name] for name in coordinates]
    helical = {moving[pair.rows[0]] for pair in lower_pairs(screws, A) if pair.kind == "helical"}
    limits = JointLimits(**{field: np.array([getattr(joint, field) for joint in masters]) for field in FIELDS})
    findings: list[Finding] = []
    followers = [name for name in moving if couplings[name].master not in (None, name)]
    for name in followers:
        limits, narrowing = _narrowed(limits, coordinates, description, name, couplings[name])
        findings += narrowing
    return WalkedChain(
        coordinates=coordinates,
        types=tuple("helical" if joint.name in helical else joint.type for joint in masters),
        moving=moving,
        screws=screws,
        home=home @ tool,
        coupling=(A, b),
        limits=limits,
        reach=float(sum(np.linalg.norm(end - start) for start, end in pairwise([*points, (home @ tool)[:3, 3]]))),
        couplings=couplings,
        findings=(*findings, *_locked_outside(description, locked)),
    )


def _walk(joints: tuple[Joint, ...], values: Mapping[str, float]) -> tuple[Array, Array, list[Array]]:
    """Space twists (6, m), the tip's pose, and the origins of the revolute joints, in the base frame."""
    g = np.eye(4)
    twists: list[Array] = []
    points: list[Array] = []
    for joint in joints:
        g = g @ joint.origin
        if not joint.moving:
            continue
        twists.append(adjoint(g) @ joint.twist)
        g = g @ exp(joint.twist, values[joint.name])
        if not slides(joint.type):
            points.append(g[:3, 3])
    return np.stack(twists, axis=1), g, points


def _narrowed(
    limits: JointLimits, coordinates: tuple[str, ...], description: Description, name: str, affine: Affine
) -> tuple[JointLimits, list[Finding]]:
    """The limits with a master's range that keeps its follower inside the follower's limits, and findings.

    A follower without a range (exports write 0, 0) narrows nothing, but gives a finding.
    """
    i, follower = coordinates.index(str(affine.master)), description.joints[name]
    ends = sorted((bound - affine.offset) / affine.multiplier for bound in (follower.lower, follower.upper))
    lower, upper = max(limits.lower[i], ends[0]), min(limits.upper[i], ends[1])
    if (lower, upper) == (limits.lower[i], limits.upper[i]):
        return limits, []
    master, kept, code = coordinates[i], "its limits are not kept", "outside-limits"
    if lower < upper:
        limits = limits.with_({"lower": {master: lower}, "upper": {master: upper}}, coordinates)
        kept, code = f"{master} is kept in [{lower:.4g}, {upper:.4g}]", "limits-adjusted"
    what = f"it follows {master} beyond its own limits [{follower.lower:g}, {follower.upper:g}]; {kept}"
    remedy = "make both joints' limits fit the mimic's multiplier and offset"
    return limits, [finding(code, description.place(follower), what, remedy)]


def _locked_outside(description: Description, locked: Mapping[str, float]) -> list[Finding]:
    found = []
    for name, value in locked.items():
        joint = description.joints[name]
        if not joint.lower <= value <= joint.upper:
            bounds = {"value": value, "lower": joint.lower, "upper": joint.upper}
            numbers = {key: Quantity(number, unit_of(joint.type)) for key, number in bounds.items()}
            what = Text("it is locked at {value}, outside its limits {lower} … {upper}", **numbers)
            found.append(finding("outside-limits", description.place(joint), what, "lock it inside its limits"))
    return found
