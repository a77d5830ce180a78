"""Base and tip if the caller names none, by the tree of moving joints, then by the names and places of links.

A description is seen as rigid bodies, each a limb, wheel, finger, rod or head by the tree and by names of its parts.
The tree decides, because names are weaker evidence: rovers have wheels, humanoids two arms, grippers several fingers.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise
from typing import Literal, NamedTuple

from ..support.errors import DescriptionError, listed
from ..support.messages import Argument, Text, first_of, plural
from .findings import Finding, finding, refusal
from .tree import Description, Joint

_ENDING = r"(_(link|frame|point|site))*(_\d+)?$"

TOOLS = [
    re.compile(rf"(?:^|_)(?:{tool}){_ENDING}")
    for tool in (
        "tool0",
        "tcp|tool_cent(er|re)(_point)?",
        "grasp(ing)?(_?(target|cent(er|re)))?|gripper_?(frame|cent(er|re)|tip)|ee_gripper|pinch",
        r"tool(_?tip)?\d*",
        r"ee\d*|eef|end_?effector\d*",
        "end_?effector_.*|end",
    )
]
"""Names that mean "this is the tool", in order of preference, behind any prefix. The last may mean other links too."""

PARTS = {
    part: re.compile(pattern)
    for part, pattern in {
        "flange": rf"(?:^|_)(flange|attachment){_ENDING}",
        "carrier": rf"(?:^|_)(gripper|hand|claw|suction|suction_cup|vacuum|pen|nozzle|probe|magnet|scoop){_ENDING}",
        "finger": (
            r"finger|knuckle|thumb|claw|jaw|grip|grab|palm|pinc|clamp|tong|"
            r"(?:^|_)(hand|pad|prong|mors|mover|moving)(?:_|\d|$)"
        ),
        "jaw": r"finger|knuckle|thumb|jaw|(?:^|_)(mover|moving|movable)(?:_|\d|$)",
        "locomotion": (
            r"wheel|cast[eo]r|rocker|bogie|suspension|steer|tyre|propell|thigh|calf|shank|ankle|coxa|femur|tibia|"
            r"(?:^|_)(tires?|track|axle|diff|differential|leg|hip|knee|foot|feet|toe)(?:_|\d|$)"
        ),
        "sensor": (
            r"camera|lidar|gimbal|kinect|"
            r"(?:^|_)(cam|eyes?|radar|ptz|antenna|head|neck|pan|tilt|mast|screen|laser)(?:_|\d|$)"
        ),
        "wrist": r"wrist|twist|rotat|(?:^|_)(roll|yaw|pitch)(?:_|\d|$)",
        "ornament": (
            r"camera|lidar|gimbal|kinect|realsense|optical|sensor|motor|servo|marker|aruco|april_?tag|microphone|speaker|"
            r"visual|collision|inertia|antenna|accelero|display|calib|bearing|screw|cable|cover|ft_frame|"
            r"(?:^|_)(mast|cam|laser|screen|lights?|leds?|lamp|imu|tags?|sc|com|itb|zed|d4\d5i?|range|sonar|gyro|depth|rgb|"
            r"button|wire|dummy)(?:_|\d|$)"
        ),
        "linkage": (
            r"cylinder|piston|hydraulic|linear_?actuator|parallel_?(link|rod|bar)|"
            r"(?:^|_)(cyl|rod|ram|strut|spring)(?:_|\d|$)"
        ),
    }.items()
}
"""Patterns of names by the part that they name.

A flange holds a tool, a carrier is a hand or a tool by its last word, a jaw moves. Locomotion is a wheel, its carrier
or a leg. A sensor is a camera, a head or a mast. A wrist turns a hand. An ornament, such as a light or a tag, only
hangs on an arm. A linkage is a cylinder, a rod or another part that follows.
"""


@cache
def plain(name: str) -> str:
    """The name in lower case with single underscores: `px100/ee_gripperLink` is px100_ee_gripper_link."""
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower()
    return re.sub(r"[^a-z0-9]+", "_", words).strip("_")


def named_like(part: str, *names: str) -> bool:
    """Whether one of the names is that of a `part`, a key of `PARTS`."""
    return any(PARTS[part].search(plain(name)) for name in names)


def tool_rank(name: str) -> int | None:
    """The rank of a link's name among usual names of tools, 0 the most usual, None for any other name."""
    if named_like("ornament", name) or named_like("jaw", name):
        return None
    return next((rank for rank, usual in enumerate(TOOLS) if usual.search(plain(name))), None)


def is_tool(name: str) -> bool:
    """Whether the name is one that only a tool has."""
    rank = tool_rank(name)
    return rank is not None and rank < len(TOOLS) - 1


def is_flange(name: str) -> bool:
    """Whether the name is that of a flange."""
    return named_like("flange", name) and not named_like("ornament", name)


# The kind of a body. A `limb` may be part of an arm.
Part = Literal["limb", "locomotion", "finger", "rod", "head"]
CARRIED = 3  # Least joints that carry a hand without a hand's name.
PARALLEL = 0.95  # Least cosine of the angle between the axes of two opposed fingers.


@dataclass(eq=False)
class Body:
    """Links connected by fixed joints, beyond the moving `joint` (None for the first body).

    `links` maps each link to the one that it is fixed on, "" for the first, outer links last. `depth` counts the joints
    before it, but none of a free base. `height` is the longest chain of joints beyond. A body that
    `holds_tool` has a link with a tool's name, or carries one. The joint of a body that `follows` is a mimic, and so
    are all beyond.
    """

    joint: Joint | None
    links: dict[str, str]
    parent: Body | None
    depth: int = 0
    children: list[Body] = field(default_factory=list)
    part: Part = "limb"
    height: int = 0
    holds_tool: bool = False
    follows: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the moving joint and of the link that it carries."""
        first = next(iter(self.links))
        return (first,) if self.joint is None else (self.joint.name, first)

    def on(self, part: Part) -> list[Body]:
        """The bodies of this kind on it."""
        return [child for child in self.children if child.part == part]

    def places_of(self, part: Part) -> list[str]:
        """The links of the body that carry bodies of this kind."""
        return [child.joint.parent for child in self.on(part) if child.joint is not None]

    def inward(self, link: str) -> list[str]:
        """`link` and the links that it is fixed on, inward to the first."""
        path = [link]
        while on := self.links[path[-1]]:
            path.append(on)
        return path

    def fork(self, links: Iterable[str]) -> str:
        """The outermost link of the body that carries all of these, or is one of them."""
        first, *rest = (self.inward(link) for link in links)
        shared = set(first).intersection(*rest)
        return next(link for link in first if link in shared)

    def path(self) -> list[Body]:
        """From the first body to this one."""
        return [*(self.parent.path() if self.parent else ()), self]

    def beyond(self) -> Iterator[Body]:
        """The body and all bodies that it carries."""
        yield self
        for child in self.children:
            yield from child.beyond()


def bodies(description: Description, base: str) -> list[Body]:
    """The rigid bodies from the link `base` outward, parents first, each with its kind."""
    outward: dict[str, list[Joint]] = {}
    for joint in description.joints.values():
        outward.setdefault(joint.parent, []).append(joint)
    found = [Body(None, {base: ""}, None)]
    for body in found:
        fixed = list(body.links)
        for link in fixed:
            for joint in outward.get(link, ()):
                if joint.moving:
                    child = description.links[joint.child]
                    in_place = not (joint.origin[:3, 3].any() or child.visuals or child.collisions)
                    of_base = body.depth == 0 and (in_place or joint.type in ("planar", "floating"))
                    depth = body.depth if of_base else body.depth + 1
                    body.children.append(Body(joint, {joint.child: ""}, body, depth))
                else:
                    body.links[joint.child] = link
                    fixed.append(joint.child)
        found += body.children
    for body in reversed(found):
        body.height = max((child.height + 1 for child in body.children), default=0)
        body.holds_tool = any(map(is_tool, body.links)) or any(child.holds_tool for child in body.children)
        body.follows = bool(body.joint and body.joint.mimic) and all(child.follows for child in body.children)
        for part, rule in RULES.items():
            for one in rule(body):
                one.part = part
    return found


def _wheels(body: Body) -> Sequence[Body]:
    """Wheels and legs: ends with such names, bodies that carry only those, and ends that spin beside another."""
    rolling, spinning = [], []
    for child in body.children:
        spins = child.joint is not None and child.joint.type == "continuous" and not child.holds_tool
        if child.children:
            if len(child.on("locomotion")) == len(child.children):
                rolling.append(child)
        elif named_like("locomotion", *child.names, *child.links):
            rolling.append(child)
        elif spins and not named_like("finger", *child.names):
            spinning.append(child)
    return [*rolling, *spinning] if rolling or (len(spinning) > 1 and body.depth < CARRIED) else ()


def _fingers(body: Body) -> Sequence[Body]:
    """Fingers: branches with such names, branches that are alike, or a single jaw; and all as short as these.

    A branch is short with one or two joints, or with fewer than carry the body.
    """
    if body.joint is None:
        return ()
    short = [child for child in body.on("limb") if child.height < max(2, body.depth) and not child.holds_tool]
    hand: Sequence[Body] = [child for child in short if named_like("finger", *child.names)]
    if len(hand) < 2:
        hand = _alike(short) if body.depth >= CARRIED or any(map(is_tool, body.links)) else ()
        hand = hand or [child for child in short if _is_jaw(child, body)]
    longest = max((child.height for child in hand), default=-1)
    return [child for child in short if child.height <= longest]


def _alike(short: Sequence[Body]) -> Sequence[Body]:
    """Branches with as many joints of one type: more than two, or two that close on each other.

    Two close if one follows the other, or if their axes are parallel and they have at most two joints each.
    """
    joints = {child: child.joint for child in short if child.joint is not None}
    for height, kind in sorted({(child.height, joint.type) for child, joint in joints.items()}, reverse=True):
        alike = [child for child in short if child.height == height and joints[child].type == kind]
        if len(alike) > 2:
            return short  # the others are thumbs, which may have another number of joints
        if len(alike) == 2:
            one, other = (joints[child] for child in alike)
            followed = {joint.mimic.joint for joint in (one, other) if joint.mimic is not None}
            cosine = (one.origin[:3, :3] @ one.axis) @ (other.origin[:3, :3] @ other.axis)
            if followed:  # a rod of a parallelogram follows a joint before both
                close = any(body.names[0] in followed for child in alike for body in child.beyond())
            else:
                close = height < 2 and bool(abs(cosine) > PARALLEL)
            if close:
                return alike
    return ()


def _is_jaw(child: Body, body: Body) -> bool:
    """Whether a branch is the only jaw of the body.

    Beside a tool's frame that carries nothing, the only branch is one by any name. A branch with a finger's name is one
    if it is named like a moving jaw. It is one too on a body that has a tool's frame or a fixed jaw.
    """
    carrying = {link for child in body.children if child.joint for link in body.inward(child.joint.parent)}
    fixed = [link for link, on in body.links.items() if on]
    frames = [link for link in fixed if link not in carrying and (is_tool(link) or named_like("carrier", link))]
    if frames and len(body.on("limb")) == 1:
        return all(beyond.follows for beyond in child.children)
    fingers = [child for child in body.on("limb") if not child.holds_tool and named_like("finger", *child.names)]
    if fingers != [child] or child.children or named_like("wrist", *child.names) or named_like("jaw", *body.names):
        return False  # the last joint of a finger is no jaw
    return body.holds_tool or any(named_like("jaw", link) for link in (*fixed, child.names[-1]))


def _rods(body: Body) -> Sequence[Body]:
    """Rods and cylinders beside a limb: those with such names, and shorter branches of mimics only."""
    limbs = [child for child in body.on("limb") if not child.holds_tool]
    named = [child for child in limbs if named_like("linkage", *child.names)]
    longest = max((child.height for child in body.on("limb") if child not in named), default=-1)
    return [child for child in limbs if longest >= 0 and (child in named or (child.follows and child.height < longest))]


def _heads(body: Body) -> Sequence[Body]:
    """Heads, masts and cameras: branches with only such names, beside limbs or wheels."""
    limbs = body.on("limb")
    heads = [child for child in limbs if not child.holds_tool]
    heads = [child for child in heads if all(named_like("sensor", *link.names) for link in child.beyond())]
    beside = len(heads) < len(limbs) or body.on("locomotion")
    return [link for child in heads for link in child.beyond()] if beside else ()


RULES: Mapping[Part, Callable[[Body], Iterable[Body]]] = {
    "locomotion": _wheels,
    "finger": _fingers,
    "rod": _rods,
    "head": _heads,
}
"""What a body carries of each kind but limbs. Each rule sees the children that the rules before it left as limbs."""


SHOWN = 6  # Most candidates in one sentence.
# Least joints of an arm on a robot that rolls or walks. One fewer is enough with a hand or a tool's name.
ARM = 3


class Choice(NamedTuple):
    """Base and tip of the arm, the reason for the tip, and other candidates, the likeliest first."""

    base: str
    tip: str
    why: str
    others: tuple[str, ...]


def choose_ends(description: Description, base: str | None = None, groups: Iterable[str] = ()) -> Choice:
    """Base and tip as a person would name them. With `base`, only the links beyond it are candidates.

    Wheels, legs, heads, rods and fingers do not count. The rest must be one chain, or have one that is clearly the
    longest. The base is the root. On a robot that rolls or walks it is the arm's first link. Raises DescriptionError
    if the choice is not clear. The error lists the candidates, the likeliest first, and the `groups` of an SRDF.
    """
    found = bodies(description, base or description.root)
    limbs = [body for body in found if body.joint is not None and all(other.part == "limb" for other in body.path())]
    ends = sorted((body for body in limbs if not body.on("limb")), key=lambda body: -body.depth)
    end = max(ends, key=lambda end: (_has_tool(end), end.depth), default=None)
    if end is None or not _is_arm(end, found) or not all(_outweighs(end, other) for other in ends if other is not end):
        raise _unclear(description, found, ends, groups)
    why, tips, others = _tips(description, end)
    if len(tips) > 1:
        raise _unclear(description, found, [end], groups)
    why = f"{why}, {plural(end.depth, 'joint')} from {(base or description.root)!r}"
    others = [link for link in dict.fromkeys([*others, *_leaves(description, found)]) if link != tips[0]]
    return Choice(base or _first_link(description, end), tips[0], why, tuple(others))


def note_choice(description: Description, choice: Choice) -> tuple[Finding, ...]:
    """A finding with the choice and its reason, if there were other candidates."""
    if not choice.others:
        return ()
    what = f"chosen as the tool, because no tip was given: {choice.why}"
    if choice.base != description.root:
        what += f"; the arm begins at {choice.base!r}"
    what += f"; other candidates: {listed(choice.others, SHOWN)}"
    place = description.place(description.links[choice.tip])
    return (finding("several-tips", place, what, Text("pass {tip} if another is meant", tip=Argument("tip"))),)


# -- which chain -------------------------------------------------------------------------------------------------------


def _has_tool(end: Body) -> bool:
    """Whether fingers or a usual name show that a tool is here."""
    return bool(end.on("finger")) or any(tool_rank(link) is not None or is_flange(link) for link in end.links)


def _outweighs(end: Body, other: Body) -> bool:
    """Whether the chain to `end` is clearly the arm, counted from its fork with the chain to `other`."""
    fork = max(a.depth for a, b in zip(end.path(), other.path(), strict=False) if a is b)
    mine, its = end.depth - fork, other.depth - fork
    return its <= ARM and not _has_tool(other) and mine >= (its if _has_tool(end) else its + 2)


def _is_arm(end: Body, found: Sequence[Body]) -> bool:
    """Whether the chain beyond wheels or legs has the joints of an arm. True without wheels and legs."""
    if not any(body.part == "locomotion" for body in found):
        return True
    chassis = max((body.depth for body in end.path() if body.on("locomotion")), default=0)
    return end.depth - chassis >= (ARM - 1 if _has_tool(end) else ARM)


def _first_link(description: Description, end: Body) -> str:
    """The root, or behind wheels or legs the link that the arm begins on, if they do not begin there too."""
    for body, outer in reversed(list(pairwise(end.path()))):
        if body.on("locomotion") and outer.joint is not None:
            first = outer.joint.parent
            if any(first in body.inward(link) for link in body.places_of("locomotion")):
                return first if body.joint is not None else description.root
            # KDL wants a base without mass: descriptions put a link `…_inertia` behind the one people call the base.
            return body.links[first] or first if first.lower().endswith("inertia") else first
    return description.root


# -- which link --------------------------------------------------------------------------------------------------------


def _tips(description: Description, end: Body) -> tuple[str, list[str], list[str]]:
    """Why, the link of the body that a person would name, or several that are equal, and other candidates.

    It is the first of a table of reasons that has one. Of several links with equal names the outermost wins, if they
    lie behind one another. A tool's name wins over the `tool0` that carries the tool.
    """
    shaped = {link for link in end.links if description.links[link].visuals or description.links[link].collisions}
    carriers = {link for tool in end.links if is_tool(tool) for link in end.inward(tool)[1:] if tool_rank(link) == 0}
    ranks = {link: (link in carriers, rank) for link in end.links if (rank := tool_rank(link)) is not None}
    flanges = [link for link in end.links if is_flange(link)]
    ends = _outer_links(end)
    if ranks:
        others = sorted(ranks, key=lambda link: (ranks[link], -len(end.inward(link))))
        reasons = [("it has a usual name for it", [link for link in others if ranks[link] == ranks[others[0]]])]
    elif fingers := end.places_of("finger"):
        palm = end.fork(fingers)
        frames = [link for link in ends if link != palm and palm in end.inward(link) and link not in shaped]
        others = [palm, *frames, *flanges]
        reasons = [("it is the frame between the fingers", frames if len(frames) == 1 else [])]
        reasons += [("the fingers move on it" if len(fingers) > 1 else "the finger moves on it", [palm])]
    else:
        fork = end.fork(ends)
        handles = flanges or [link for link in ends if named_like("carrier", link)]
        others = [*ends, *flanges]
        reasons = [
            ("it is the end of the chain", ends if len(ends) == 1 else []),
            ("it is named like a tool or its flange", handles if len(handles) == 1 else []),
            ("it carries the parts at the end of the chain", [fork] if shaped.issuperset(ends) else []),
            ("", [*ends, fork]),
        ]
    why, best = next(reason for reason in reasons if reason[1])
    in_line = set(best) <= set(end.inward(best[0]))
    return why, best[:1] if in_line else best, [*best, *others]


def _outer_links(end: Body) -> list[str]:
    """The ends of the body's tree of fixed joints, without ornaments and pairs of fixed fingers."""
    left = dict(end.links)
    while True:
        outer = [link for link in left if link not in left.values()]
        fingers = [link for link in outer if named_like("finger", link) and not named_like("carrier", link)]
        loose = [link for link in outer if named_like("ornament", link) or (len(fingers) > 1 and link in fingers)]
        if not loose or not left[loose[0]]:
            return outer
        for link in loose:
            del left[link]


def _leaves(description: Description, found: Sequence[Body]) -> dict[str, Body]:
    """The leaves of the tree, those with the most joints first."""
    outer = set(description.leaves)
    leaves = {link: body for body in found for link in body.links if link in outer}
    return dict(sorted(leaves.items(), key=lambda leaf: -leaf[1].depth))


def _unclear(
    description: Description, found: Sequence[Body], ends: Sequence[Body], groups: Iterable[str]
) -> DescriptionError:
    if len(found) == 1:
        return refusal("no-chain", description.place(), "no joint moves", "is it the description of an arm?")
    likely = {link: end for end in ends for link in _tips(description, end)[1]}
    if len(likely) < 2:
        what = f"it has no arm, only {'too short a chain' if ends else 'wheels, legs or heads'}"
        moved = (link for link, body in _leaves(description, found).items() if body.joint and body.part != "locomotion")
        remedy = Text("to use one of its chains anyway, pass {tip}", tip=Argument("tip", *[*likely, *moved][:1]))
        return refusal("no-tip", description.place(), what, remedy)
    candidates = [f"{listed([link])} ({plural(end.depth, 'joint')})" for link, end in likely.items()]
    what = f"several links could be the tip: {first_of(candidates, SHOWN)}"
    if offered := ", ".join(groups):
        what += f"; so could the groups of its SRDF: {offered}"
    remedy = Text("pass {tip}, or another of them", tip=Argument("tip", next(iter(likely))))
    return refusal("no-tip", description.place(), what, remedy)
