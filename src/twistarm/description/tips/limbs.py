"""A description as rigid bodies joined by moving joints, with wheels, fingers, heads and rods told apart."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ...limits.joint_limits import slides
from ..tree import Description, Joint
from .link_names import is_tool, tells_of

Part = Literal["limb", "locomotion", "finger", "head", "rod"]
"""The kind of a body. A `limb` may be part of an arm."""

LONGEST_FINGER = 2
"""Most joints of a finger without a finger's name."""

CARRIED = 3
"""Least joints that carry a hand without a hand's name."""

EQUAL = 0.05
"""Relative difference of the distances of two opposed fingers from their palm."""


@dataclass(eq=False)
class Body:
    """Links connected by fixed joints, beyond the moving `joint` (None for the first body).

    `links` maps each link to the one that it is fixed on, "" for the first, outer links last. `depth` counts the joints
    from the first body, a planar one once. `height` counts those beyond this body. `virtual` tells that only joints of
    a free base lie before it. `holds_tool` tells that a link of it or beyond has a tool's name. `follows` tells that
    its joint and all beyond are mimics.
    """

    joint: Joint | None
    links: dict[str, str]
    parent: Body | None
    depth: int = 0
    virtual: bool = True
    children: list[Body] = field(default_factory=list)
    height: int = 0
    holds_tool: bool = False
    follows: bool = False
    part: Part = "limb"

    @property
    def first(self) -> str:
        """The link that the moving joint carries."""
        return next(iter(self.links))

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the moving joint and of the link that it carries."""
        return (self.first,) if self.joint is None else (self.joint.name, self.first)

    def on(self, part: Part) -> list[Body]:
        """The bodies of this kind on it."""
        return [child for child in self.children if child.part == part]

    def inward(self, link: str) -> list[str]:
        """`link` and the links that it is fixed on, inward to the first."""
        path = [link]
        while on := self.links[path[-1]]:
            path.append(on)
        return path

    def fork(self, links: Iterable[str]) -> str:
        """The outermost link of the body that carries all of these, or is one of them."""
        paths = [self.inward(link) for link in links]
        shared = set(paths[0]).intersection(*paths[1:])
        return next(link for link in paths[0] if link in shared)

    def path(self) -> list[Body]:
        """From the first body to this one."""
        path = [self]
        while path[-1].parent is not None:
            path.append(path[-1].parent)
        return path[::-1]

    def beyond(self) -> list[Body]:
        """The body and all bodies that it carries."""
        found = [self]
        for body in found:
            found += body.children
        return found


def bodies(description: Description, base: str) -> list[Body]:
    """The rigid bodies from the link `base` outward, parents first, each with its kind."""
    outward: dict[str, list[Joint]] = {}
    for joint in description.joints.values():
        outward.setdefault(joint.parent, []).append(joint)
    found = [Body(None, {base: ""}, None)]
    for body in found:
        for joint in _leaving(body, outward):
            virtual = body.virtual and _is_virtual(description, joint)
            depth = body.depth + (not joint.part_of or body.joint is None or body.joint.part_of != joint.part_of)
            body.children.append(Body(joint, {joint.child: ""}, body, depth, virtual))
        found += body.children
    for body in reversed(found):
        _measure(body)
        for tell in (_tell_wheels, _tell_fingers, _tell_rods, _tell_heads):
            tell(body)
    return found


def _leaving(body: Body, outward: Mapping[str, Sequence[Joint]]) -> Iterator[Joint]:
    """The moving joints on the body. Adds the links of fixed joints to the body."""
    links = list(body.links)
    for link in links:
        for joint in outward.get(link, ()):
            if joint.moving:
                yield joint
            else:
                body.links[joint.child] = link
                links.append(joint.child)


def _is_virtual(description: Description, joint: Joint) -> bool:
    """Whether the joint models a free base: it is planar or floating, or moves a link without offset and shape."""
    link = description.links[joint.child]
    return joint.type in ("planar", "floating") or not (joint.origin[:3, 3].any() or link.visuals or link.collisions)


def _measure(body: Body) -> None:
    body.height = max((child.height + 1 for child in body.children), default=0)
    body.holds_tool = any(is_tool(link) for link in body.links) or any(child.holds_tool for child in body.children)
    mimic = body.joint is not None and body.joint.mimic is not None
    body.follows = mimic and all(child.follows for child in body.children)


def _label(found: Iterable[Body], part: Part) -> None:
    for body in found:
        body.part = part


# -- wheels and legs ---------------------------------------------------------------------------------------------------


def _tell_wheels(body: Body) -> None:
    """Label wheels and legs: ends with such names, several that spin side by side, and bodies that carry only those."""
    for child in body.children:
        only = bool(child.children) and len(child.on("locomotion")) == len(child.children)
        if only or (not child.children and tells_of("locomotion", *child.names, *child.links)):
            child.part = "locomotion"
    rolling = body.on("locomotion")
    spinning = [child for child in body.on("limb") if _spins(child)]
    several = len(spinning) > 1 and (body.depth < CARRIED or body.virtual or bool(rolling))
    if several or (rolling and len(spinning) + len(rolling) == len(body.children)):
        _label(spinning, "locomotion")


def _spins(body: Body) -> bool:
    """Whether it is an end that turns without limits, without a name of a tool or a finger."""
    endless = body.joint is not None and body.joint.type == "continuous" and not body.children
    return endless and not body.holds_tool and not tells_of("finger", *body.names)


# -- fingers -----------------------------------------------------------------------------------------------------------


def _tell_fingers(body: Body) -> None:
    """Label fingers: branches with such names, short opposed ones, or one jaw against a fixed one."""
    reach = max(LONGEST_FINGER, body.depth)
    short = [child for child in body.on("limb") if child.height < reach and not child.holds_tool]
    named = [child for child in short if tells_of("finger", *child.names)]
    hand: Sequence[Body] = ()
    if len(named) > 1 and body.depth:
        hand = named
    elif _may_be_palm(body) and (alike := _alike(short)):
        hand = short if len(alike) > LONGEST_FINGER else alike  # a thumb is longer, or shorter
    elif len(named) == 1 and body.depth and _closes(named[0], body):
        hand = named
    longest = max((child.height for child in hand), default=-1)
    _label((child for child in short if child.height <= longest), "finger")


def _may_be_palm(body: Body) -> bool:
    """Whether enough joints carry the body, or it has a tool frame."""
    carried = body.depth >= CARRIED and not body.virtual
    return carried or (body.depth > 0 and any(is_tool(link) for link in body.links))


def _alike(short: Sequence[Body]) -> Sequence[Body]:
    """The longest branches of one length and one joint type that oppose each other, or are more than two.

    A pair of fingers with more than two joints each needs a mimic between them.
    """
    for height in sorted({child.height for child in short}, reverse=True):
        for kind in ("prismatic", "revolute", "continuous"):
            alike = [child for child in short if child.height == height and child.joint and child.joint.type == kind]
            coupled = any(child.joint and child.joint.mimic for child in alike)
            pair = len(alike) > 1 and (height < LONGEST_FINGER or coupled) and _opposed(alike)
            if pair or len(alike) > LONGEST_FINGER:
                return alike
    return ()


def _opposed(fingers: Sequence[Body]) -> bool:
    """Whether one follows another, or their axes are parallel, and for turning joints equally far from the palm."""
    joints = [finger.joint for finger in fingers if finger.joint is not None]
    masters = {joint.mimic.joint for joint in joints if joint.mimic is not None}
    if masters:
        return any(body.joint is not None and body.joint.name in masters for one in fingers for body in one.beyond())
    axes = np.stack([joint.origin[:3, :3] @ joint.axis for joint in joints])
    away = np.array([np.linalg.norm(joint.origin[:3, 3]) for joint in joints])
    parallel = bool((np.abs(axes @ axes[0]) > 1 - EQUAL).all()) and len({joint.parent for joint in joints}) == 1
    return parallel and (slides(joints[0].type) or bool(np.ptp(away) <= EQUAL * away.max()))


def _closes(finger: Body, body: Body) -> bool:
    """Whether a single finger closes on the body, which has a tool frame or a fixed finger, or a hand's name."""
    fixed = body.holds_tool or any(tells_of("jaw", link) for link in list(body.links)[1:])
    jaw = tells_of("jaw", finger.first) and tells_of("hand", *body.links)
    return not finger.children and not tells_of("wrist", *finger.names) and (fixed or jaw)


# -- rods and heads ----------------------------------------------------------------------------------------------------


def _tell_rods(body: Body) -> None:
    """Label rods and cylinders beside a limb: those with such names, and shorter branches of mimics only."""
    named = [child for child in body.on("limb") if tells_of("linkage", *child.names) and not child.holds_tool]
    limbs = [child for child in body.on("limb") if child not in named]
    if limbs:
        longest = max(child.height for child in limbs)
        idle = [child for child in limbs if child.follows and child.height < longest and not child.holds_tool]
        _label([*idle, *named], "rod")


def _tell_heads(body: Body) -> None:
    """Label heads, masts and cameras: branches with only such names, beside limbs or wheels, or with a camera."""
    limbs = body.on("limb")
    named = [child for child in limbs if all(tells_of("sensor", *one.names) for one in child.beyond())]
    heads = [child for child in named if not child.holds_tool]
    beside = len(heads) < len(limbs) or bool(body.on("locomotion"))
    for child in heads:
        if beside or any(tells_of("camera", *one.names) for one in child.beyond()):
            _label(child.beyond(), "head")
