"""From a file or a catalogue name to an arm: base and tip chosen, limits applied, the two accounts proven equal."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from . import poe
from .arm import Arm, Coupling, Proof
from .checks import Array
from .description import catalog
from .description.arm_file import ArmSpecification, Tool, read_arm_file
from .description.chain import walk_chain
from .description.tree import Description
from .description.urdf import read_description
from .errors import ComparisonError, DescriptionError, InputError, UnknownNameError, closest, listed
from .files import is_file
from .limits import JointLimits
from .screws import adjoint

PROOF_SAMPLES = 5
PROOF_TOL = 1e-9
"""Both accounts are double precision: beyond this, relative to the arm's size, they describe different arms."""

TIP_PATTERNS = (
    "tool0",
    "tcp",
    ".*_tcp",
    "gripper_frame_link",
    "tool_frame",
    "ee_link",
    "end_effector.*",
    ".*_end_effector",
)
"""Names that mean "this is the tool", in order of preference, looked for among all links."""

_GRIPPER = re.compile("grip|finger|jaw|claw|hand", re.IGNORECASE)

Folders = Iterable[str | os.PathLike[str]]


def load_arm(
    source: str | os.PathLike[str],
    *,
    base: str | None = None,
    tip: str | None = None,
    package_dirs: Folders = (),
    xacro_args: Mapping[str, object] | None = None,
    limits: JointLimits | Mapping[str, Any] | None = None,
    locked: Mapping[str, float] | None = None,
) -> Arm:
    """Load an arm from a URDF or xacro file, an arm.toml, or by its name in the catalogue (`available_arms()`).

    `base` is the root link unless given; `tip` is found by its name (`tool0`, `tcp`, …) or as the only leaf that is
    no gripper. `limits`: {"velocity": 1.0} for every joint or {"velocity": {"elbow": 1.0}}; `locked`: {joint: value
    [rad or m]} joints that stand still. `package_dirs`: folders with packages, beside those found around the file.
    What the caller gives wins over the arm.toml.

    Screws and home come from our own walk of the description; Pinocchio's model is built beside it, and both are
    compared at five random configurations (`arm.proof`).

    Raises DescriptionError (file, element, remedy), UnknownNameError with the closest names, ComparisonError if the
    two accounts disagree.
    """
    for name, value in {"base": base, "tip": tip}.items():
        if value is not None and not isinstance(value, str):
            raise InputError(f"{name} must be the name of a link; got {value!r}")
    specification = _specification(source)
    specification = replace(
        specification,
        base=base or specification.base,
        tip=tip or specification.tip,
        tool=None if tip else specification.tool,
        package_dirs=(*_folders(package_dirs), *specification.package_dirs),
        xacro_args={**specification.xacro_args, **(xacro_args or {})},
        locked={**specification.locked, **(locked or {})},
    )
    description = read_description(
        specification.description, package_dirs=specification.package_dirs, xacro_args=specification.xacro_args
    )
    arm = _assemble(description, specification, {} if limits is None else limits)
    return replace(arm, proof=prove(arm))


def available_arms() -> tuple[str, ...]:
    """Names that `load_arm` knows: our own arms, and those of the example-robot-data wheel (`models` extra)."""
    return (*catalog.own_arms(), *catalog.model_arms())


def prove(arm: Arm) -> Proof:
    """Product of exponentials against Pinocchio at five seeded configurations; ComparisonError if they differ."""
    theta = arm.random_theta(np.random.default_rng(0), PROOF_SAMPLES)
    x = theta @ arm.coupling.A.T
    J = poe.spatial_jacobian(arm.screws, x) @ arm.coupling.A
    g = poe.fk(arm.screws, arm.home, x)
    reference = arm.fk(theta)
    proof = Proof(
        pose_error=float(np.abs(g - reference).max()),
        jacobian_error=float(np.abs(J - adjoint(reference) @ arm.body_jacobian(theta)).max()),
        samples=PROOF_SAMPLES,
    )
    size = 1.0 + float(np.abs(reference[..., :3, 3]).max())
    if not max(proof.pose_error, proof.jacobian_error) <= PROOF_TOL * size**2:
        raise ComparisonError(
            f"{arm.name}: product of exponentials and Pinocchio disagree by {proof.pose_error:.2g} (pose) and "
            f"{proof.jacobian_error:.2g} (Jacobian); please report it with the description"
        )
    return proof


def _specification(source: str | os.PathLike[str]) -> ArmSpecification:
    """A path wins over a catalogue name, so that a local file is never shadowed."""
    if not isinstance(source, (str, os.PathLike)):
        raise InputError(f"source must be a path or a name; got {source!r}")
    text = str(os.fspath(source))
    path = Path(text).expanduser()
    if is_file(path):
        return read_arm_file(path) if path.suffix == ".toml" else ArmSpecification(path, text)
    own = catalog.own_arm_file(text)
    if own is not None:
        return replace(read_arm_file(own), source=text)
    entry = catalog.model_entry(text)
    if entry is not None:
        file, (_, base, tip) = entry
        share = file.parents[len(Path(entry[1].file).parts) + 1]
        return ArmSpecification(file, text, name=text, base=base, tip=tip, package_dirs=(share,))
    kind = _kind(path)
    if kind or path.suffix or len(path.parts) > 1:
        raise DescriptionError(
            f"{text[:200]}: {kind or 'no such file'}; give a URDF or xacro file, an arm.toml or one of "
            f"{listed(available_arms(), 20)}"
        )
    names = available_arms()
    raise UnknownNameError(
        f"no arm {text!r} in the catalogue, nor a file of that name{closest(text, names)} (arms: {', '.join(names)})"
    )


def _kind(path: Path) -> str:
    """What stands at `path` instead of a file; empty if nothing does."""
    try:
        return "a folder" if path.is_dir() else "not a regular file" if path.exists() else ""
    except (OSError, ValueError) as error:
        return f"no usable path ({getattr(error, 'strerror', None) or error})"


def _folders(package_dirs: Folders) -> tuple[str | os.PathLike[str], ...]:
    return (package_dirs,) if isinstance(package_dirs, (str, os.PathLike)) else tuple(package_dirs)


def _assemble(
    description: Description, specification: ArmSpecification, changes: JointLimits | Mapping[str, Any]
) -> Arm:
    base = description.require_link(specification.base, "base") if specification.base else description.root
    tip = description.require_link(specification.tip, "tip") if specification.tip else find_tip(description)
    if specification.tool and specification.tool.name in description.links:
        raise DescriptionError(
            f"{specification.source}: tool.name {specification.tool.name!r} is a link already; name it otherwise"
        )
    tool = specification.tool or Tool(tip, np.eye(4))
    chain = walk_chain(description, base, tip, tool.g_tip_tool, specification.locked)
    limits = _limits(chain.limits, specification, changes, chain.coordinates)
    arm = Arm(
        name=specification.name or description.name,
        source=specification.source,
        base=base,
        tip=tool.name,
        joint_names=chain.coordinates,
        joint_types=chain.types,
        screws=chain.screws,
        home=chain.home,
        coupling=Coupling(*chain.coupling),
        limits=limits,
        reach=chain.reach or 1.0,
        findings=(*description.findings, *chain.findings),
        description=description,
        couplings=chain.couplings,
        tool=tool.g_tip_tool,
        tip_link=tip,
    )
    return replace(arm, named_states=_named_states(arm, specification))


def _limits(
    limits: JointLimits,
    specification: ArmSpecification,
    changes: JointLimits | Mapping[str, Any],
    names: tuple[str, ...],
) -> JointLimits:
    """The description's limits, then the arm.toml's (joint by joint), then the caller's (kind by kind, or all)."""
    by_kind: dict[str, dict[str, float]] = {}
    for joint, values in specification.limits.items():
        for kind, value in values.items():
            if joint not in specification.locked:
                by_kind.setdefault(kind, {})[joint] = value
    try:
        limits = limits.with_(by_kind, names)
    except (ValueError, LookupError) as error:
        raise DescriptionError(f"{specification.source}: {error}") from error
    if not isinstance(changes, JointLimits):
        return limits.with_(changes, names)
    if changes.lower.size != len(names):
        raise InputError(f"limits must be those of {len(names)} joints ({', '.join(names)}); got {changes.lower.size}")
    return changes


def _named_states(arm: Arm, specification: ArmSpecification) -> dict[str, Array]:
    """The arm.toml's poses, checked: every joint given, inside the limits."""
    states: dict[str, Array] = {}
    for name, values in specification.poses.items():
        try:
            theta = arm.theta_from(values)
        except (ValueError, LookupError) as error:
            raise DescriptionError(f"{specification.source}: poses.{name}: {error}") from error
        if not arm.limits.contains(theta):
            raise DescriptionError(
                f"{specification.source}: poses.{name} lies outside the limits; correct it or the limits"
            )
        states[name] = theta
    return states


def find_tip(description: Description) -> str:
    """The tool's link: by an ordered list of usual names among all links, else the only leaf that is no gripper.

    Never a silent guess: DescriptionError lists the candidates.
    """
    for pattern in TIP_PATTERNS:
        found = [link for link in description.links if re.fullmatch(pattern, link, re.IGNORECASE)]
        if len(found) == 1:
            return found[0]
        if found:
            raise DescriptionError(f"{description.path}: several links could be the tip: {listed(found)}; pass tip=")
    leaves = description.leaves
    if len(leaves) == 1 and not _is_gripper(description, leaves[0]):
        return leaves[0]
    candidates = listed(leaves)
    why = "its only leaf looks like a gripper" if len(leaves) == 1 else "several links could be the tip"
    raise DescriptionError(f"{description.path}: {why}: {candidates}; pass tip= (a link: {listed(description.links)})")


def _is_gripper(description: Description, leaf: str) -> bool:
    """Whether the last moving joint before the leaf, or the leaf itself, is named like a gripper's part."""
    moving = [joint for joint in description.chain(description.root, leaf) if joint.moving]
    names = [leaf, *(name for joint in moving[-1:] for name in (joint.name, joint.child))]
    return any(_GRIPPER.search(name) for name in names)
