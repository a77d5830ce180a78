"""Base and tip if the caller names none, by the tree of moving joints, then by the names and places of links.

A description is seen as rigid bodies, each a limb, wheel, finger, rod or head by the tree and by names of its parts.
The tree decides, because names are weaker evidence: rovers have wheels, humanoids two arms, grippers several fingers.
"""

from __future__ import annotations

import re
from collections import Counter
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
    )
]
"""Names that mean "this is the tool", in order of preference, behind any prefix."""

PARTS = {
    part: re.compile(pattern)
    for part, pattern in {
        "handle": (
            r"(?:^|_)(flange|attachment|gripper|hand|claw|suction|suction_cup|vacuum|pen|nozzle|probe|magnet|scoop)"
            rf"{_ENDING}"
        ),
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

A handle is a flange, a hand or a tool by its last word. A jaw moves. Locomotion is a wheel, its carrier or a leg. A
sensor is a camera, a head or a mast. An ornament, such as a light or a tag, only hangs on an arm. A linkage is a
cylinder, a rod or another part that follows.
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
    if named_like("ornament", name):
        return None
    return next((rank for rank, usual in enumerate(TOOLS) if usual.search(plain(name))), None)


def is_tool(name: str) -> bool:
    """Whether the name is one that only a tool has."""
    return tool_rank(name) is not None


# The kind of a body. A `limb` may be part of an arm.
Part = Literal["limb", "locomotion", "finger", "rod", "head"]
CARRIED = 3  # Least joints that carry a hand without a tool's name.


@dataclass(eq=False)
class Body:
    """Links connected by fixed joints, beyond the moving `joint` (None for the first body).

    `links` maps each link to the one that it is fixed on, "" for the first, outer links last. `depth` counts the joints
    before it, `height` those of the longest chain beyond.
    """

    joint: Joint | None
    links: dict[str, str]
    parent: Body | None
    depth: int = 0
    children: list[Body] = field(default_factory=list)
    part: Part = "limb"
    height: int = 0

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the moving joint and of the link that it carries."""
        first = next(iter(self.links))
        return (first,) if self.joint is None else (self.joint.name, first)

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
                    body.children.append(Body(joint, {joint.child: ""}, body, body.depth + 1))
                else:
                    body.links[joint.child] = link
                    fixed.append(joint.child)
        found += body.children
    for body in reversed(found):
        body.height = max((child.height + 1 for child in body.children), default=0)
        for part, rule in RULES.items():
            for one in rule(body):
                one.part = part
    return found


def _wheels(body: Body) -> Iterable[Body]:
    """Wheels and legs: ends with such names, and bodies that carry only those."""
    for child in body.children:
        if child.children:
            rolls = len(child.on("locomotion")) == len(child.children)
        else:
            rolls = named_like("locomotion", *child.names, *child.links)
        if rolls:
            yield child


def _fingers(body: Body) -> Sequence[Body]:
    """Fingers: branches with such names, branches that are alike with all beside them, or a single jaw.

    A branch is short with one or two joints, or with fewer than carry the body.
    """
    if body.joint is None:
        return ()
    short = [child for child in body.on("limb") if child.height < max(2, body.depth)]
    hand = [child for child in short if named_like("finger", *child.names)]
    if len(hand) > 1:
        return hand
    if body.depth < CARRIED and not any(map(is_tool, body.links)):
        return ()
    return short if _alike(short) else [child for child in short if _is_jaw(child, body)]


def _alike(short: Sequence[Body]) -> bool:
    """Whether two branches have as many joints, the first of one type.

    A rod of a parallelogram, which follows a joint before the branches, does not count.
    """
    own = {one.names[0] for child in short for one in child.beyond()}
    joints = [(child.height, child.joint) for child in short if child.joint is not None]
    kinds = Counter((height, joint.type) for height, joint in joints if not joint.mimic or joint.mimic.joint in own)
    return any(count > 1 for count in kinds.values())


def _is_jaw(child: Body, body: Body) -> bool:
    """Whether a branch is the only jaw of the body.

    It is the only branch, by any name, beside a tool's frame that carries nothing. Or it is the only one with a
    finger's name, and its link or a fixed one is named like a jaw.
    """
    limbs, carrying = body.on("limb"), {link for on in _places(body.children) for link in body.inward(on)}
    fixed = [link for link, on in body.links.items() if on]
    if limbs == [child] and any(
        link not in carrying and (is_tool(link) or named_like("handle", link)) for link in fixed
    ):
        return True
    named = [limb for limb in limbs if named_like("finger", *limb.names)]
    return named == [child] and any(named_like("jaw", link) for link in (*fixed, child.names[-1]))


def _places(carried: Iterable[Body]) -> list[str]:
    """The links that carry these bodies."""
    return [body.joint.parent for body in carried if body.joint is not None]


def _rods(body: Body) -> Sequence[Body]:
    """Rods and cylinders beside a limb: those with such names, and shorter branches of mimics only."""
    limbs = body.on("limb")
    named = [child for child in limbs if named_like("linkage", *child.names)]
    longest = max((child.height for child in limbs if child not in named), default=None)
    if longest is None:
        return ()
    following = [child for child in limbs if all(one.joint and one.joint.mimic for one in child.beyond())]
    return [*named, *(child for child in following if child.height < longest)]


def _heads(body: Body) -> Sequence[Body]:
    """Heads, masts and cameras: branches with only such names, beside limbs or wheels."""
    limbs = body.on("limb")
    heads = [child for child in limbs if all(named_like("sensor", *link.names) for link in child.beyond())]
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
LEAST = 2  # Least joints of an arm on a robot that rolls or walks.
# The most joints of a branch beside the arm, and how many more an arm without a tool's name must have.
BESIDE, MORE = 3, 2


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
    ends = sorted((body for body in limbs if not body.on("limb")), key=lambda body: (not _has_tool(body), -body.depth))
    least = LEAST if any(body.part == "locomotion" for body in found) else 1
    if not ends or ends[0].depth < least or not all(_outweighs(ends[0], other) for other in ends[1:]):
        raise _unclear(description, found, ends, groups)
    end = ends[0]
    why, tips = _tips(description, end)
    if len(tips) > 1:
        raise _unclear(description, found, [end], groups)
    why = f"{why}, {plural(end.depth, 'joint')} from {(base or description.root)!r}"
    others = dict.fromkeys([*filter(is_tool, end.links), *_leaves(description, found)])
    return Choice(
        base or _first_link(description, end), tips[0], why, tuple(link for link in others if link != tips[0])
    )


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


def _has_tool(end: Body) -> bool:
    return any(map(is_tool, end.links))


def _outweighs(end: Body, other: Body) -> bool:
    """Whether the chain to `end` is clearly the arm, counted from its fork with the chain to `other`."""
    fork = max(a.depth for a, b in zip(end.path(), other.path(), strict=False) if a is b)
    more = 0 if _has_tool(end) and not _has_tool(other) else MORE
    return other.depth - fork <= BESIDE and end.depth >= other.depth + more


def _first_link(description: Description, end: Body) -> str:
    """The root, or behind wheels or legs the link that the arm begins on."""
    for body, outer in reversed(list(pairwise(end.path()))):
        if body.on("locomotion") and outer.joint is not None:
            first = outer.joint.parent
            # KDL wants a base without mass: descriptions put a link `…_inertia` behind the one people call the base.
            return body.links[first] or first if first.lower().endswith("inertia") else first
    return description.root


def _tips(description: Description, end: Body) -> tuple[str, list[str]]:
    """Why, and the link of the body that a person would name, or several that are equal.

    It is the first of a table of reasons that has one. Of several links with equal names the outermost wins, if they
    lie behind one another. A tool's name wins over the `tool0` that carries the tool.
    """
    carriers = {link for tool in end.links if is_tool(tool) for link in end.inward(tool)[1:] if tool_rank(link) == 0}
    ranks = {link: (link in carriers, rank) for link in end.links if (rank := tool_rank(link)) is not None}
    ends = _outer_links(end)
    if ranks:
        usual = [link for link in ranks if ranks[link] == min(ranks.values())]
        reasons = [("it has a usual name for it", sorted(usual, key=lambda link: -len(end.inward(link))))]
    elif fingers := _places(end.on("finger")):
        palm = end.fork(fingers)
        frames = [link for link in ends if link != palm and palm in end.inward(link)]
        reasons = [("it is the frame between the fingers", frames if len(frames) == 1 else [])]
        reasons += [("the fingers move on it" if len(fingers) > 1 else "the finger moves on it", [palm])]
    else:
        shaped = {link for link in end.links if description.links[link].visuals or description.links[link].collisions}
        fork, handles = end.fork(ends), [link for link in ends if named_like("handle", link)]
        reasons = [
            ("it is the end of the chain", ends if len(ends) == 1 else []),
            ("it is named like a tool or its flange", handles if len(handles) == 1 else []),
            ("it carries the parts at the end of the chain", [fork] if shaped.issuperset(ends) else []),
            ("", [*ends, fork]),
        ]
    why, best = next(reason for reason in reasons if reason[1])
    return why, best[:1] if set(best) <= set(end.inward(best[0])) else best


def _outer_links(end: Body) -> list[str]:
    """The ends of the body's tree of fixed joints, without ornaments and pairs of fixed fingers."""
    left = dict(end.links)
    while True:
        outer = [link for link in left if link not in left.values()]
        fingers = [link for link in outer if named_like("finger", link) and not named_like("handle", link)]
        loose = [link for link in outer if named_like("ornament", link) or (len(fingers) > 1 and link in fingers)]
        if not loose or not left[loose[0]]:
            return outer
        for link in loose:
            del left[link]


def _leaves(description: Description, found: Sequence[Body]) -> list[str]:
    """The leaves of the tree, those with the most joints first."""
    outer = set(description.leaves)
    return [link for body in sorted(found, key=lambda body: -body.depth) for link in body.links if link in outer]


def _unclear(
    description: Description, found: Sequence[Body], ends: Sequence[Body], groups: Iterable[str]
) -> DescriptionError:
    if len(found) == 1:
        return refusal("no-chain", description.place(), "no joint moves", "is it the description of an arm?")
    likely = {link: end for end in ends for link in _tips(description, end)[1]}
    if len(likely) < 2:
        what, some = "it has no arm, only wheels, legs, heads or a short chain", [*likely, *_leaves(description, found)]
        remedy = Text("to use one of its chains anyway, pass {tip}", tip=Argument("tip", *some[:1]))
        return refusal("no-tip", description.place(), what, remedy)
    candidates = [f"{listed([link])} ({plural(end.depth, 'joint')})" for link, end in likely.items()]
    what = f"several links could be the tip: {first_of(candidates, SHOWN)}"
    if offered := ", ".join(groups):
        what += f"; so could the groups of its SRDF: {offered}"
    remedy = Text("pass {tip}, or another of them", tip=Argument("tip", next(iter(likely))))
    return refusal("no-tip", description.place(), what, remedy)
