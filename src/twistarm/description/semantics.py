"""What is said of a robot beside its kinematics: groups, end effectors, named states, pairs that need no check."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from .findings import Finding

Pair = tuple[str, str]


def pair(a: str, b: str) -> Pair:
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
    """An SRDF as read, or what an MJCF says of that. Pairs of links are sorted, virtual joints kept by name only.

    `silent_links` by default collide with nothing except in the `checked_pairs`.
    """

    path: Path
    name: str
    groups: Mapping[str, Group] = field(default_factory=dict)
    end_effectors: tuple[EndEffector, ...] = ()
    states: tuple[GroupState, ...] = ()
    disabled: frozenset[Pair] = frozenset()
    silent_links: tuple[str, ...] = ()
    checked_pairs: frozenset[Pair] = frozenset()
    passive_joints: tuple[str, ...] = ()
    virtual_joints: tuple[str, ...] = ()
    findings: tuple[Finding, ...] = ()

    def disabled_collisions(self, links: Iterable[str]) -> frozenset[Pair]:
        """The pairs of `links`, each sorted, that are not to be checked for collisions."""
        known = set(links)
        default = {pair(a, b) for a in self.silent_links for b in known if a in known and a != b}
        named = (default - self.checked_pairs) | self.disabled
        return frozenset(each for each in named if known.issuperset(each))
