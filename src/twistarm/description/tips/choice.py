"""The choice of base and tip if the caller names none: first by the tree of moving joints, then by names."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from ...support.caller_words import argument
from ...support.errors import DescriptionError, listed
from ..findings import Finding, finding, refusal
from ..tree import Description
from .limbs import Body, bodies
from .link_names import tells_of
from .tip_link import speaks, tip_link

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
    return (finding("several-tips", place, what, f"pass {argument('tip')} if another is meant"),)


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
        likeliest = _candidates(description, found, ends)[0]
        return refusal(
            "no-tip",
            description.place(),
            what,
            f"to take one of its chains all the same, pass {argument('tip', likeliest)}",
        )
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
    return refusal("no-tip", description.place(), what, f"pass {argument('tip', pairs[0][0])}")


def _joints(end: Body) -> str:
    return f"{end.depth} joint{'s' * (end.depth > 1)}"
