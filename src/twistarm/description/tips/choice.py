"""The choice of base and tip if the caller names none: by the tree of moving joints, then by names and places."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from ...support.errors import DescriptionError, listed
from ...support.messages import Argument, Text
from ..findings import Finding, finding, refusal
from ..tree import Description
from .limbs import Body, bodies
from .link_names import is_tool, tells_of, tool_rank

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
    ends = _ends(found)
    main = _main(ends)
    if main is None or not _is_arm(main, found):
        raise _unclear(description, found, ends, groups)
    tip = tip_link(description, main)
    if tip.link is None:
        raise _several(description, [(link, main) for link in tip.candidates], groups)
    others = dict.fromkeys([*tip.candidates, *_candidates(description, found, [main, *ends])])
    others.pop(tip.link)
    why = f"{tip.why}, {_joints(main)} from {(base or description.root)!r}"
    return Choice(base or _standing(description, main), tip.link, why, tuple(others))


def note_choice(description: Description, choice: Choice) -> tuple[Finding, ...]:
    """A finding with the choice and its reason, if there were other candidates."""
    if not choice.others:
        return ()
    what = f"chosen as the tool, because no tip was given: {choice.why}"
    what += f"; the arm stands on {choice.base!r}" if choice.base != description.root else ""
    what += f"; other candidates: {listed(choice.others, SHOWN)}"
    place = description.place(description.links[choice.tip])
    return (finding("several-tips", place, what, Text("pass {tip} if another is meant", tip=Argument("tip"))),)


def candidates(description: Description, base: str | None = None) -> tuple[str, ...]:
    """Every link that could be the tip, the likeliest first."""
    found = bodies(description, base or description.root)
    return _candidates(description, found, _ends(found))


# -- which chain -------------------------------------------------------------------------------------------------------


def _ends(found: Sequence[Body]) -> list[Body]:
    """The bodies at the ends of chains of limbs, the longest first. Heads count if there is nothing else."""
    limbs: dict[Body, None] = {}
    for body in found:
        if body.part == "limb" and (body.parent is None or body.parent in limbs):
            limbs[body] = None
    ends = [body for body in limbs if body.joint is not None and not body.on("limb") and not _is_chassis(body)]
    if not ends and not any(body.part == "locomotion" for body in found):
        ends = [body for body in found if body.joint is not None and not body.children]
    return sorted(ends, key=lambda body: -body.depth)


def _is_chassis(body: Body) -> bool:
    return bool(body.on("locomotion")) and not body.on("finger")


def _main(ends: Sequence[Body]) -> Body | None:
    """The end of the arm: the only end, or one that outweighs all others."""
    likely = dict.fromkeys([*ends[:1], *[end for end in ends if speaks(end)][:1]])
    return next((end for end in likely if all(_outweighs(end, other) for other in ends if other is not end)), None)


def _outweighs(end: Body, other: Body) -> bool:
    """Whether the chain to `end` is clearly the arm, counted from its fork with the chain to `other`."""
    fork = max(a.depth for a, b in zip(end.path(), other.path(), strict=False) if a is b)
    mine, its = end.depth - fork, other.depth - fork
    if its > ARM or speaks(other):
        return False
    return mine >= its if speaks(end) else mine >= min(its + 2, 2 * its)


def _is_arm(end: Body, found: Sequence[Body]) -> bool:
    """Whether the chain beyond wheels or legs has the joints of an arm. True without wheels and legs."""
    if not any(body.part == "locomotion" for body in found):
        return True
    chassis = max((body.depth for body in end.path() if body.on("locomotion")), default=0)
    said = speaks(end) or tells_of("finger", *end.links)
    return end.depth - chassis >= ARM - said


# -- which base --------------------------------------------------------------------------------------------------------


def _standing(description: Description, end: Body) -> str:
    """The root, or behind wheels or legs the link that the arm begins on, if they do not begin there too."""
    path = end.path()
    chassis = next((body for body in reversed(path) if body.on("locomotion")), None)
    if chassis is None:
        return description.root
    first, *wheels = (body.joint.parent for body in (path[chassis.depth + 1], *chassis.on("locomotion")) if body.joint)
    if any(first in chassis.inward(wheel) for wheel in wheels):
        return first if chassis.joint is not None else description.root
    # KDL wants a base without mass: descriptions put a link `…_inertia` behind the one that people call the base.
    return chassis.links[first] or first if first.lower().endswith("inertia") else first


class TipLink(NamedTuple):
    """A body's tool `link`, None if several are equal, the reason, and all candidates, the likeliest first."""

    link: str | None
    why: str
    candidates: tuple[str, ...]


def tip_link(description: Description, end: Body) -> TipLink:
    """The link of the body that a person would name.

    1. The link with the most usual name. A tool's name wins over the `tool0` that carries it. Of several links with
       equal names the outermost wins, if they lie behind one another.
    2. With fingers, the frame between them, or their palm.
    3. The only end that is not an ornament, or the only one with the name of a flange or a hand.
    4. The link that carries all ends, if they have shapes.
    """
    usual = _usual(end)
    if usual:
        best = [link for link in usual if tool_rank(link) == tool_rank(usual[0])]
        outermost = len(set(best) - set(end.inward(best[0]))) == 0
        return TipLink(best[0] if outermost else None, "it has a usual name for it", tuple(usual))
    flanges = [link for link in end.links if _is_flange(link)]
    ends = _outer_links(end)
    if end.on("finger"):
        found = _in_hand(description, end, ends)
    elif len(ends) == 1:
        found = TipLink(ends[0], "it is the end of the chain", (ends[0],))
    else:
        found = _of_several(description, end, ends, flanges)
    return found._replace(candidates=tuple(dict.fromkeys([*found.candidates, *flanges])))


def speaks(end: Body) -> bool:
    """Whether fingers or a usual name show that a tool is here."""
    return bool(end.on("finger")) or any(tool_rank(link) is not None or _is_flange(link) for link in end.links)


def _usual(end: Body) -> list[str]:
    """The links with usual names: the most usual first, then the outermost. A tool0 below a tool is last."""
    carriers = {link for tool in end.links if is_tool(tool) for link in end.inward(tool)[1:] if tool_rank(link) == 0}
    ranked = [
        (link in carriers, rank, -len(end.inward(link)), link)
        for link in end.links
        if (rank := tool_rank(link)) is not None
    ]
    return [link for *_, link in sorted(ranked, key=lambda one: one[:3])]


def _outer_links(end: Body) -> list[str]:
    """The ends of the body's tree of fixed joints, without ornaments and fixed fingers."""
    carries = Counter(end.links.values())
    left = dict.fromkeys(end.links)
    outer = [link for link in left if not carries[link]]
    fingers = [link for link in outer if tells_of("finger", link) and not tells_of("carrier", link)]
    loose = [link for link in outer if tells_of("ornament", link) or (len(fingers) > 1 and link in fingers)]
    while loose:
        link = loose.pop()
        on = end.links[link]
        if not on:
            break
        del left[link]
        carries[on] -= 1
        if not carries[on] and tells_of("ornament", on):
            loose.append(on)
    return [link for link in left if not carries[link]]


def _in_hand(description: Description, end: Body, ends: list[str]) -> TipLink:
    """The only frame on the palm, else the palm, which is the link that carries all fingers."""
    palm = end.fork(finger.joint.parent for finger in end.on("finger") if finger.joint is not None)
    frames = [link for link in ends if link != palm and palm in end.inward(link) and not _shaped(description, link)]
    frames = [link for link in frames if tells_of("carrier", link) or not tells_of("finger", link)]
    if len(frames) == 1:
        return TipLink(frames[0], "it is the frame between the fingers", (frames[0], palm))
    several = len(end.on("finger")) > 1
    return TipLink(palm, f"the finger{'s' * several} move{'s' * (not several)} on it", (palm, *frames))


def _of_several(description: Description, end: Body, ends: list[str], flanges: list[str]) -> TipLink:
    named = flanges or [link for link in ends if tells_of("carrier", link)]
    if len(named) == 1:
        return TipLink(named[0], "it is named like a tool or its flange", (named[0], *ends))
    carrier = end.fork(ends)
    if all(_shaped(description, link) for link in ends):
        return TipLink(carrier, "it carries the parts at the end of the chain", (carrier, *ends))
    return TipLink(None, "", (*ends, carrier))


def _is_flange(link: str) -> bool:
    return tells_of("flange", link) and not tells_of("ornament", link)


def _shaped(description: Description, link: str) -> bool:
    return bool(description.links[link].visuals or description.links[link].collisions)


# -- what is said ------------------------------------------------------------------------------------------------------


def _candidates(description: Description, found: Sequence[Body], ends: Sequence[Body]) -> tuple[str, ...]:
    """The tips of these ends, then the other leaves of the tree, those with the most joints first."""
    likely = [link for end in dict.fromkeys(ends) for link in _likely(description, end)]
    depth = {link: body.depth for body in found for link in body.links}
    leaves = sorted((leaf for leaf in description.leaves if leaf in depth), key=lambda leaf: -depth[leaf])
    return tuple(dict.fromkeys([*likely, *leaves]))


def _unclear(
    description: Description, found: Sequence[Body], ends: Sequence[Body], groups: Iterable[str]
) -> DescriptionError:
    if len(found) == 1:
        return refusal("nothing-moves", description.place(), "no joint moves", "is it the description of an arm?")
    if len(ends) < 2:
        what = f"nothing that is an arm in it, only {'wheels, legs or heads' if not ends else 'too short a chain'}"
        likeliest = Argument("tip", _candidates(description, found, ends)[0])
        remedy = Text("to take one of its chains all the same, pass {tip}", tip=likeliest)
        return refusal("no-tip", description.place(), what, remedy)
    return _several(description, [(link, end) for end in ends for link in _likely(description, end)], groups)


def _likely(description: Description, end: Body) -> Sequence[str]:
    """The tool link at an end, or all candidates there."""
    tip = tip_link(description, end)
    return tip.candidates if tip.link is None else (tip.link,)


def _several(description: Description, pairs: Sequence[tuple[str, Body]], groups: Iterable[str]) -> DescriptionError:
    more = f", … ({len(pairs)} in all)" if len(pairs) > SHOWN else ""
    told = ", ".join(f"{listed([link])} ({_joints(end)})" for link, end in pairs[:SHOWN])
    what = f"several links could be the tip: {told}{more}"
    offered = ", ".join(groups)
    what += f"; so could the groups of its SRDF: {offered}" if offered else ""
    return refusal("no-tip", description.place(), what, Text("pass {tip}", tip=Argument("tip", pairs[0][0])))


def _joints(end: Body) -> str:
    return f"{end.depth} joint{'s' * (end.depth > 1)}"
