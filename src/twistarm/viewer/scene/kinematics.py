"""The products of exponentials by which the page places every node."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...description.tree import Description
from ...support.checks import Array
from ...theory.screws import transform_twist
from .drawing import link_path, rod_path, screw_path

TOOL = "/frames/tool"


def kinematics(arm: Arm, others: Sequence[str]) -> dict[str, Any]:
    """Joints and nodes in base coordinates at theta = 0, for core.js and carriers.js.

    Coordinates x are theta, then the joints beside the chain named `others`. Joint j has the next joint toward the root
    as `parent` (or null). It maps to space E_j = E_parent · exp(ξ_j c·x). `terms` [i, c_i] hold the nonzero c, and the
    space twist `screw` is ξ_j (MLS §3.2). The pose of node k is E_base⁻¹ · E_j · `rest` (by columns) with j its
    `joint`. E_base belongs to the joint `base`, and is 1 if no joint carries the base. `parents` has each link's parent
    (or null), where the arm has links.
    """
    if arm.description is None:
        return _chain(arm)
    return _Tree(arm, arm.description, (*arm.joint_names, *others)).described()


def _chain(arm: Arm) -> dict[str, Any]:
    """Of an arm without links: the moving joints one after the other."""
    A = arm.coupling.A
    joints = [
        {"parent": i - 1 if i else None, "screw": screw.tolist(), "terms": _terms(row)}
        for i, (screw, row) in enumerate(zip(arm.screws.T, A, strict=True))
    ]
    m = len(joints)
    nodes = {path(i): _node(i, np.eye(4)) for i in range(m) for path in (screw_path, rod_path)}
    return {"base": None, "joints": joints, "nodes": nodes | {TOOL: _node(m - 1 if m else None, arm.home)}}


class _Tree:
    def __init__(self, arm: Arm, description: Description, coordinates: Sequence[str]) -> None:
        self._arm, self._description = arm, description
        self._rest = arm.poses(np.zeros(arm.n))
        self._column = {name: i for i, name in enumerate(coordinates)}
        self._carrier = {joint.child: joint for joint in description.joints.values()}
        scalar = [joint for joint in description.joints.values() if joint.scalar]
        self._order = {
            joint.name: i for i, joint in enumerate(sorted(scalar, key=lambda joint: len([*self._way(joint.child)])))
        }

    def described(self) -> dict[str, Any]:
        arm, links = self._arm, self._description.links
        screws = [_node(self._order[name], np.eye(4)) for name in arm.moving_names]
        return {
            "base": self._above(arm.base),
            "parents": {name: self._carrier[name].parent if name in self._carrier else None for name in links},
            "joints": [self._joint(name) for name in self._order],
            "nodes": {
                **{link_path(name): _node(self._above(name), self._rest[name]) for name in links},
                **{screw_path(i): node for i, node in enumerate(screws)},
                TOOL: _node(self._above(arm.tip_link), self._rest[arm.tip]),
            },
        }

    def _joint(self, name: str) -> dict[str, Any]:
        joint = self._description.joints[name]
        affine, row = self._arm.couplings[name], np.zeros(len(self._column))
        if affine.master in self._column:
            row[self._column[affine.master]] = affine.multiplier
        screw = transform_twist(self._rest[joint.child], joint.twist)
        return {"parent": self._above(joint.parent), "screw": screw.tolist(), "terms": _terms(row)}

    def _above(self, link: str) -> int | None:
        """The joint that moves `link`: the nearest on the way to the root."""
        return next((self._order[joint] for joint in self._way(link) if joint in self._order), None)

    def _way(self, link: str) -> Iterator[str]:
        while (joint := self._carrier.get(link)) is not None:
            yield joint.name
            link = joint.parent


def _terms(row: Array) -> list[list[float]]:
    return [[int(i), float(row[i])] for i in np.flatnonzero(row)]


def _node(joint: int | None, rest: Array) -> dict[str, Any]:
    return {"joint": joint, "rest": rest.T.ravel().tolist()}
