"""`diagnose`: the findings of the reading and of all checks of the doctor."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from ...arm.abilities import Abilities, abilities_of
from ...arm.arm import Arm
from ...arm.loading.load import assemble, proven, read, specify
from ...description.chain import resolve_couplings
from ...description.findings import Finding, Place, finding
from ...description.inertias import check_inertias
from ...description.tree import Description
from ...support.errors import ComparisonError, DescriptionError, InputError, UnknownNameError
from ...support.files import as_path
from . import arm_checks, description_checks

_ORDER = ("error", "warning", "info")


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """The findings, gravest first; arm and abilities are None if the description was refused."""

    findings: tuple[Finding, ...]
    description: Description | None = None
    arm: Arm | None = None
    able: Abilities | None = None

    @property
    def worst(self) -> str | None:
        """The gravest severity found."""
        return self.findings[0].severity if self.findings else None


def diagnose(source: str | os.PathLike[str] | Arm, **load: Any) -> tuple[Finding, ...]:
    """All findings about a description: errors, then warnings, then remarks, each with its remedy.

    The doctor adds to the findings of `load_arm`. It finds limits that look like degrees, singular configurations,
    impossible inertias, meshes out of scale, a missing tool frame and idle joints. It also reports what the arm cannot
    do with its tool. It names axes that are almost exact, and the closed form that they miss. Errors of a description
    that `load_arm` refuses are findings here. The rest of it is examined as far as it can be read.

    Args:
        source: As in `load_arm`, or an `Arm`.
        **load: The options of `load_arm`.

    Returns:
        The findings, the gravest first.

    Raises:
        InputError: An argument cannot be used.
        UnknownNameError: No arm of that name.
    """
    return examine(source, **load).findings


def examine(source: str | os.PathLike[str] | Arm, **load: Any) -> Diagnosis:
    """`diagnose`, with what was read on the way."""
    if isinstance(source, Arm):
        if load:
            raise InputError(f"an Arm is loaded already and takes no {', '.join(load)}")
        return examine_arm(source)
    as_path(source)
    limits = load.pop("limits", None)
    description: Description | None = None
    try:
        specification = specify(source, **load)
        description = read(specification)
        arm = proven(assemble(description, specification, {} if limits is None else limits))
    except ComparisonError as error:
        refused = [finding("engines-disagree", Place(str(source)), str(error), "report it with the description")]
    except DescriptionError as error:
        place = Place(str(source))
        refused = list(error.findings) or [finding("companion-unusable", place, str(error), "correct it")]
    except (InputError, UnknownNameError) as error:
        # A wrong name or value in an arm.toml is a finding, the caller's is his error.
        if limits or any(load.values()) or not str(source).endswith(".toml"):
            raise
        refused = [finding("companion-unusable", Place(str(source)), str(error), "correct it there")]
    else:
        return examine_arm(arm)
    if description is None:
        return Diagnosis(_in_order(refused))
    known = [finding for finding in description.findings if finding not in refused]
    return Diagnosis(_in_order([*refused, *known, *_of_description(description, None)]), description)


def examine_arm(arm: Arm) -> Diagnosis:
    """`examine` for an arm."""
    able = abilities_of(arm)
    found = [*arm.findings, *arm_checks.check_zero(arm), *arm_checks.check_reach(arm)]
    found += [*arm_checks.check_postures(arm, able.rank), *arm_checks.check_abilities(arm, able)]
    found += [*arm_checks.check_without_effect(arm), *arm_checks.check_axes(arm)]
    if arm.description is not None:
        found += _of_description(arm.description, arm)
        found += [*arm_checks.check_tool(arm, arm.description), *arm_checks.check_off_the_chain(arm, arm.description)]
        found += arm_checks.check_collisions(arm)
    return Diagnosis(_in_order(found), arm.description, arm, able)


def _of_description(description: Description, arm: Arm | None) -> Iterator[Finding]:
    """What needs no tip."""
    yield from description_checks.check_limits(description, arm)
    try:
        couplings = arm.couplings if arm else resolve_couplings(description, {})
    except DescriptionError:  # it is what the arm was refused for
        couplings = {}
    yield from description_checks.check_mimics(description, couplings, arm.moving_names if arm else ())
    yield from check_inertias(description)
    yield from description_checks.check_meshes(description)


def _in_order(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """The gravest first, each with a remedy."""
    complete = (finding if finding.remedy else replace(finding, remedy="correct what is there") for finding in findings)
    return tuple(sorted(complete, key=lambda one: _ORDER.index(one.severity)))
