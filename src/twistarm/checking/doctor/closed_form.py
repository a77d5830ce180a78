"""Arms that almost have a closed form of inverse kinematics, off by rounding."""

from __future__ import annotations

from collections.abc import Iterator

from ...arm.arm import Arm
from ...description.findings import Finding, finding
from ...ik import closed_form_of
from .axes import rewriting
from .wording import place_of


def check_closed_form(arm: Arm) -> Iterator[Finding]:
    """One finding if the axes narrowly miss a family; none for arms of another build."""
    report = closed_form_of(arm)
    if not report.nearly or report.held:
        return
    yield finding(
        "closed-form-missed",
        place_of(arm.description, arm.name),
        f"{report.miss}: a {report.target} has no exact closed form; solve_ik_all corrects the answers of the nearest "
        "exact arm, and cannot say whether these are all",
        f"{rewriting(arm, apart=False)}; exact axes give every configuration, and the proof that a target has none",
    )
