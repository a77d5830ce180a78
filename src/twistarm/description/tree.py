"""A robot description as plain data: links, joints, their tree, and what companion files add."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np

from ..limits.joint_limits import slides
from ..support.checks import Array
from ..support.errors import QUOTED, UnknownNameError, closest, listed, one_line, unknown_name
from ..support.messages import Argument, Text
from ..theory.screws import exp
from .findings import Finding, Place, finding, refusal

MOST_NAMES = 6  # Names in one finding before the rest is counted.

Pair = tuple[str, str]  # Two names of links, sorted where their order means nothing.


def sorted_pair(a: str, b: str) -> Pair:
    """Two names, sorted."""
    return (a, b) if a <= b else (b, a)


@dataclass(frozen=True)
class Group:
    """A named set of joints: chains as (base_link, tip_link), joints, links (each with its parent joint), groups."""

    name: str
    chains: tuple[Pair, ...] = ()
    joints: tuple[str, ...] = ()
    links: tuple[str, ...] = ()
    subgroups: tuple[str, ...] = ()


@dataclass(frozen=True)
class EndEffector:
    """An end effector on `parent_link` with the joints of `group`. `parent_group` is the arm's group, if given."""

    name: str
    parent_link: str
    group: str
    parent_group: str = ""


@dataclass(frozen=True)
class GroupState:
    """A named configuration: {joint: value [rad or m]}, joints with several numbers left out."""

    name: str
    group: str
    values: Mapping[str, float]


@dataclass(frozen=True)
class Semantics:
    """An SRDF as read, or what an MJCF says of that. Pairs of links are sorted, `disabled` with their reasons.

    `silent_links` by default collide with nothing except in the `checked_pairs`. Virtual joints are (frame, link).
    """

    path: Path
    name: str
    groups: Mapping[str, Group] = field(default_factory=dict)
    end_effectors: tuple[EndEffector, ...] = ()
    states: tuple[GroupState, ...] = ()
    disabled: Mapping[Pair, str] = field(default_factory=dict)
    silent_links: tuple[str, ...] = ()
    checked_pairs: frozenset[Pair] = frozenset()
    passive_joints: tuple[str, ...] = ()
    virtual_joints: Mapping[str, Pair] = field(default_factory=dict)
    findings: tuple[Finding, ...] = ()

    def disabled_collisions(self, links: Iterable[str]) -> frozenset[Pair]:
        """The pairs of `links`, each sorted, that are not to be checked for collisions."""
        known = set(links)
        default = {sorted_pair(a, b) for a in self.silent_links for b in known if a in known and a != b}
        named = (default - self.checked_pairs) | self.disabled.keys()
        return frozenset(two for two in named if known.issuperset(two))


JointType = Literal["revolute", "continuous", "prismatic", "fixed", "planar", "floating"]
Shape = Literal["box", "cylinder", "sphere", "capsule", "mesh"]

# The usual acceleration of free fall [m/s²], in axes of an upright base.
GRAVITY = (0.0, 0.0, -9.81)


@dataclass(frozen=True)
class Geometry:
    """A shape on a link: `origin` (4, 4) in the link frame.

    `size`: box (x, y, z) [m]; cylinder and capsule (radius, length) along z [m]; sphere (radius,) [m]; mesh its scale.
    `mesh` is an absolute path, or None if the file was not found. `colour` is (r, g, b, a) in 0…1.
    """

    shape: Shape
    origin: Array
    size: tuple[float, ...]
    mesh: Path | None = None
    colour: tuple[float, float, float, float] | None = None


@dataclass(frozen=True)
class Link:
    """A rigid body with its visual and collision shapes."""

    name: str
    visuals: tuple[Geometry, ...] = ()
    collisions: tuple[Geometry, ...] = ()
    line: int | None = None


@dataclass(frozen=True)
class Mimic:
    """value = multiplier · (value of `joint`) + offset."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Joint:
    """A joint of the tree, with a unit vector `axis` of the written length `axis_length`.

    Limits are ∓inf if not given. `lower` and `upper` lie inside the soft limits of a `<safety_controller>`. `hard` are
    those of `<limit>` alone. `acceleration` is the smaller of acceleration and deceleration. `line` is the line in a
    file without xacro. `part_of` is the planar joint that it was split from.
    """

    name: str
    type: JointType
    parent: str
    child: str
    origin: Array
    axis: Array
    lower: float = -np.inf
    upper: float = np.inf
    hard: tuple[float, float] = (-np.inf, np.inf)
    velocity: float = np.inf
    effort: float = np.inf
    acceleration: float = np.inf
    jerk: float = np.inf
    mimic: Mimic | None = None
    axis_length: float = 1.0
    line: int | None = None
    part_of: str = ""

    @property
    def moving(self) -> bool:
        """One degree of freedom or more."""
        return self.type != "fixed"

    @property
    def scalar(self) -> bool:
        """Its motion is one number."""
        return self.type in ("revolute", "continuous", "prismatic")

    @property
    def twist(self) -> Array:
        """The joint's twist (v, w) (6,) in its own frame: unit axis, through the origin."""
        zero = np.zeros(3)
        return np.concatenate([self.axis, zero] if slides(self.type) else [zero, self.axis])


@dataclass(frozen=True, repr=False)
class Description:
    """Links and joints after all repairs, with the findings of the reading.

    `text` is the expanded description as written, for the engines of the crosscheck. `repaired` is the kinematic part
    of it with all repairs, for Pinocchio. `semantics` come from an SRDF or an MJCF, `gravity` from an MJCF: the
    acceleration of free fall (3,) [m/s²] in axes of the root.
    """

    name: str
    path: Path | None
    root: str
    links: Mapping[str, Link]
    joints: Mapping[str, Joint]
    text: str = field(repr=False)
    repaired: str = field(repr=False)
    findings: tuple[Finding, ...] = ()
    semantics: Semantics | None = field(default=None, repr=False)
    gravity: tuple[float, float, float] | None = None

    def __repr__(self) -> str:
        source = f" from {self.path.name}" if self.path else ""
        return f"Description({self.name}: {len(self.links)} links, {len(self.joints)} joints{source})"

    @property
    def leaves(self) -> tuple[str, ...]:
        """Links without children, in file order."""
        parents = {joint.parent for joint in self.joints.values()}
        return tuple(name for name in self.links if name not in parents)

    def place(self, part: Joint | Link | None = None) -> Place:
        """The place of a joint or link in the file, or the file without one."""
        file = self.path.name if self.path else self.name
        if part is None:
            return Place(file)
        return Place(file, part.line, "joint" if isinstance(part, Joint) else "link", part.name)

    def require_link(self, link: str, role: str) -> str:
        """`link` itself, or an UnknownNameError with the closest names."""
        if not isinstance(link, str) or link not in self.links:
            listing = f"{len(self.links)} links: {listed(self.links)}"
            if role in ("link", "link or obstacle"):
                raise unknown_name(role, link, self.links, within=self.name, listing=listing)
            what, given = "{given} is no link of {arm}{near} ({listing})", Argument(role, one_line(str(link), QUOTED))
            near = closest(link, self.links)
            raise UnknownNameError(Text(what, given=given, arm=self.name, near=near, listing=listing))
        return link

    @cached_property
    def joint_to(self) -> Mapping[str, Joint]:
        """The joint that moves each link but the root."""
        return {joint.child: joint for joint in self.joints.values()}

    def inward(self, link: str) -> list[str]:
        """The link and those above it, up to the root."""
        path = [link]
        while path[-1] in self.joint_to:
            path.append(self.joint_to[path[-1]].parent)
        return path

    def chain(self, base: str, tip: str) -> tuple[Joint, ...]:
        """The joints from `base` out to `tip`, in this order, fixed ones included."""
        path = self.inward(tip)
        if base not in path:
            what = f"base {base!r} is no ancestor of tip {tip!r}"
            remedy = f"a base must be one of {listed(path[1:]) if path[1:] else 'no link: the tip is the root'}"
            raise refusal("no-chain", self.place(), what, remedy)
        return tuple(self.joint_to[link] for link in reversed(path[: path.index(base)]))

    def link_poses(self, values: Mapping[str, Array | float]) -> dict[str, Array]:
        """Pose of every link in the root frame, {link: g (..., 4, 4)}; joints without a value are at 0."""
        poses: dict[str, Array] = {self.root: np.eye(4)}
        for joint in self.outward_joints():
            g = poses[joint.parent] @ joint.origin
            if joint.name in values:
                g = g @ exp(joint.twist, values[joint.name])
            poses[joint.child] = g
        return poses

    @property
    def extent(self) -> float:
        """The largest coordinate [m] of any link in the root frame, joints at 0. A scale for rounding."""
        return max(float(np.abs(g[..., :3, 3]).max()) for g in self.link_poses({}).values())

    def beyond(self, joint: str) -> frozenset[str]:
        """The links that `joint` carries, all branches included."""
        carried = {self.joints[joint].child}
        for outer in self.outward_joints():
            if outer.parent in carried:
                carried.add(outer.child)
        return frozenset(carried)

    def outward_joints(self) -> tuple[Joint, ...]:
        """Every joint, parents before children."""
        children: dict[str, list[Joint]] = {}
        for joint in self.joints.values():
            children.setdefault(joint.parent, []).append(joint)
        order: list[Joint] = []
        stack = [self.root]
        while stack:
            for joint in reversed(children.get(stack.pop(), [])):
                order.append(joint)
                stack.append(joint.child)
        return tuple(order)


def grouped(code: str, description: Description, parts: Sequence[Joint | Link], what: str, remedy: str) -> Finding:
    """One finding about several joints or links: at its place for one, else at the file with their names."""
    if len(parts) == 1:
        return finding(code, description.place(parts[0]), what, remedy)
    names = listed([part.name for part in parts], MOST_NAMES)
    return finding(code, description.place(), f"{names}: {what}", remedy)
