"""The choice of base and tip if the caller names none: by the tree of moving joints, then by names and places."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import NamedTuple

from ...support.errors import DescriptionError, listed
from ...support.messages import Argument, Text, plural
from ..findings import Finding, finding, refusal
from ..tree import Description
from .bodies import Body, bodies, is_flange, is_tool, tells_of, tool_rank

SHOWN = 6
"""Most candidates in one sentence."""

ARM = 3
"""Least joints of an arm on a robot that rolls or walks. One fewer is enough with a hand or a tool's name."""


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
    limbs = [body for body in found if body.joint is not None and all(one.part == "limb" for one in body.path())]
    ends = sorted((body for body in limbs if not body.on("limb")), key=lambda body: -body.depth)
    end = max(ends, key=lambda end: (_has_tool(end), end.depth), default=None)
    if end is None or not _is_arm(end, found) or not all(_outweighs(end, other) for other in ends if other is not end):
        raise _unclear(description, found, ends, groups)
    why, tips, others = _tips(description, end)
    if len(tips) > 1:
        raise _unclear(description, found, [end], groups)
    others = [*others, *_leaves(description, found)]
    why = f"{why}, {plural(end.depth, 'joint')} from {(base or description.root)!r}"
    return Choice(
        base or _first_link(description, end),
        tips[0],
        why,
        tuple(link for link in dict.fromkeys(others) if link != tips[0]),
    )


def note_choice(description: Description, choice: Choice) -> tuple[Finding, ...]:
    """A finding with the choice and its reason, if there were other candidates."""
    if not choice.others:
        return ()
    what = f"chosen as the tool, because no tip was given: {choice.why}"
    if choice.base != description.root:
        what += f"; the arm stands on {choice.base!r}"
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
        handles = flanges or [link for link in ends if tells_of("carrier", link)]
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
        fingers = [link for link in outer if tells_of("finger", link) and not tells_of("carrier", link)]
        loose = [link for link in outer if tells_of("ornament", link) or (len(fingers) > 1 and link in fingers)]
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
        what = f"nothing that is an arm in it, only {'too short a chain' if ends else 'wheels, legs or heads'}"
        first = next(iter([*likely, *_leaves(description, found)]))
        remedy = Text("to take one of its chains all the same, pass {tip}", tip=Argument("tip", first))
        return refusal("no-tip", description.place(), what, remedy)
    shown = [f"{listed([link])} ({plural(end.depth, 'joint')})" for link, end in likely.items()]
    what = f"several links could be the tip: {', '.join(shown[:SHOWN])}"
    if len(likely) > SHOWN:
        what += f", … ({len(likely)} in all)"
    if offered := ", ".join(groups):
        what += f"; so could the groups of its SRDF: {offered}"
    return refusal("no-tip", description.place(), what, Text("pass {tip}", tip=Argument("tip", next(iter(likely)))))
