"""A description as rigid bodies, each a limb, wheel, finger, rod or head by the tree and by names of its parts."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Literal

from ..tree import Description, Joint

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
"""Names by the part that they tell of.

A flange holds a tool, a carrier is a hand or a tool by its last word, a jaw moves. Locomotion is a wheel, its carrier
or a leg. A sensor is a camera, a head or a mast. A wrist turns a hand. An ornament, such as a light or a tag, only
hangs on an arm. A linkage is a cylinder, a rod or another part that follows.
"""


@cache
def plain(name: str) -> str:
    """The name in lower case with single underscores: `px100/ee_gripperLink` is px100_ee_gripper_link."""
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower()
    return re.sub(r"[^a-z0-9]+", "_", words).strip("_")


def tells_of(part: str, *names: str) -> bool:
    """Whether one of the names is that of a `part`, a key of `PARTS`."""
    return any(PARTS[part].search(plain(name)) for name in names)


def tool_rank(name: str) -> int | None:
    """The rank of a link's name among usual names of tools, 0 the most usual, None for any other name."""
    if tells_of("ornament", name) or tells_of("jaw", name):
        return None
    return next((rank for rank, usual in enumerate(TOOLS) if usual.search(plain(name))), None)


def is_tool(name: str) -> bool:
    """Whether the name is one that only a tool has."""
    return tool_rank(name) in range(len(TOOLS) - 1)


def is_flange(name: str) -> bool:
    """Whether the name is that of a flange."""
    return tells_of("flange", name) and not tells_of("ornament", name)


Part = Literal["limb", "locomotion", "finger", "rod", "head"]
"""The kind of a body. A `limb` may be part of an arm."""

CARRIED = 3
"""Least joints that carry a hand without a hand's name."""

PARALLEL = 0.95
"""Least cosine of the angle between the axes of two opposed fingers."""


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
                    body.children.append(Body(joint, {joint.child: ""}, body, body.depth + (not of_base)))
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
        if child.children:
            if len(child.on("locomotion")) == len(child.children):
                rolling.append(child)
        elif tells_of("locomotion", *child.names, *child.links):
            rolling.append(child)
        elif child.joint and child.joint.type == "continuous" and not child.holds_tool:
            spinning += [] if tells_of("finger", *child.names) else [child]
    return [*rolling, *spinning] if rolling or (len(spinning) > 1 and body.depth < CARRIED) else ()


def _fingers(body: Body) -> Sequence[Body]:
    """Fingers: branches with such names, branches that are alike, or a single jaw; and all as short as these.

    A branch is short with one or two joints, or with fewer than carry the body.
    """
    if body.joint is None:
        return ()
    short = [child for child in body.on("limb") if child.height < max(2, body.depth) and not child.holds_tool]
    hand: Sequence[Body] = [child for child in short if tells_of("finger", *child.names)]
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
            return short  # a thumb has more joints, or fewer
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

    Beside a tool's frame that carries nothing, the only branch is one whatever its name. A branch with a finger's name
    is one if it is named like a moving jaw, or is on a body that has a tool's frame or a fixed jaw.
    """
    carrying = {link for one in body.children if one.joint for link in body.inward(one.joint.parent)}
    fixed = [link for link, on in body.links.items() if on]
    frames = [link for link in fixed if link not in carrying and (is_tool(link) or tells_of("carrier", link))]
    if frames and len(body.on("limb")) == 1:
        return all(beyond.follows for beyond in child.children)
    fingers = [one for one in body.on("limb") if not one.holds_tool and tells_of("finger", *one.names)]
    if fingers != [child] or child.children or tells_of("wrist", *child.names) or tells_of("jaw", *body.names):
        return False  # the last joint of a finger is no jaw
    return body.holds_tool or any(tells_of("jaw", link) for link in (*fixed, child.names[-1]))


def _rods(body: Body) -> Sequence[Body]:
    """Rods and cylinders beside a limb: those with such names, and shorter branches of mimics only."""
    limbs = [child for child in body.on("limb") if not child.holds_tool]
    named = [child for child in limbs if tells_of("linkage", *child.names)]
    longest = max((child.height for child in body.on("limb") if child not in named), default=-1)
    return [child for child in limbs if longest >= 0 and (child in named or (child.follows and child.height < longest))]


def _heads(body: Body) -> Sequence[Body]:
    """Heads, masts and cameras: branches with only such names, beside limbs or wheels."""
    limbs = body.on("limb")
    heads = [child for child in limbs if not child.holds_tool]
    heads = [child for child in heads if all(tells_of("sensor", *one.names) for one in child.beyond())]
    beside = len(heads) < len(limbs) or body.on("locomotion")
    return [one for child in heads for one in child.beyond()] if beside else ()


RULES: Mapping[Part, Callable[[Body], Iterable[Body]]] = {
    "locomotion": _wheels,
    "finger": _fingers,
    "rod": _rods,
    "head": _heads,
}
"""What a body carries of each kind but limbs. Each rule sees the children that the rules before it left as limbs."""
