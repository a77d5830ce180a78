"""The tool link of the body at a chain's end, by its name, else by its place among fingers and attachments."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

from ..tree import Description
from .limbs import Body
from .link_names import is_tool, tells_of, tool_rank


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
    ends = _ends(end)
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


def _ends(end: Body) -> list[str]:
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
