"""`arms` and `info`: the arms of the catalogue, and the loaded arm."""

from __future__ import annotations

import platform
import re
from dataclasses import asdict, fields
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Group

from ...arm import engine
from ...arm.arm import Arm
from ...description import catalog
from ...description.companions.arm_file import MOTOR_LIMITS
from ...ik import closed_form_of
from ...limits.actuators import Actuators
from ...limits.joint_limits import FIELDS
from ...support.path_redaction import without_places
from ..options import Json, Radians, takes_arm_or_none
from ..output import console, finding_json, literal, number, print_json, say, shown, table, units
from ..wording import words


def arms(json: Json = False) -> None:
    """List the arms that can be loaded by name."""
    own, models = catalog.own_arms(), catalog.model_arms()
    installed = catalog.models_share() is not None
    if json:
        print_json({"own": own, "models": models, "models_installed": installed})
        return
    say("twistarm's own:      " + ", ".join(own))
    note = "" if installed else "   (not installed: pip install 'twistarm[models]')"
    say("example-robot-data:  " + ", ".join(models) + note)


@takes_arm_or_none
def info(arm: Arm | None, rad: Radians = False, json: Json = False) -> None:
    """Show the loaded arm: joints, limits, base, tip, poses, findings, proof; without ARM the installation."""
    if json:
        print_json(versions_json() if arm is None else info_json(arm))
    elif arm is None:
        say(*versions_text().splitlines())
    else:
        console().print(info_view(arm, rad))


def info_json(arm: Arm) -> dict[str, Any]:
    """Everything `info` shows, for programs."""
    return {
        "name": arm.name,
        "source": without_places(arm.source, Path(arm.source)),
        "base": arm.base,
        "tip": arm.tip,
        "n": arm.n,
        "joint_names": arm.joint_names,
        "joints": [
            {"name": name, "type": kind, "unit": unit} | {field: getattr(arm.limits, field)[i] for field in FIELDS}
            for i, (name, kind, unit) in enumerate(zip(arm.joint_names, arm.joint_types, arm.units, strict=True))
        ],
        "reach": arm.reach,
        "screws": arm.screws,
        "home": arm.home,
        "ready": arm.ready,
        "named_states": dict(arm.named_states),
        "actuators": None if arm.actuators is None else actuators_json(arm.actuators),
        "disabled_collisions": sorted(arm.disabled_collisions),
        "frames": arm.frame_names,
        "proof": arm.proof._asdict() if arm.proof else None,
        "engine": engine_of(arm),
        "core": engine.instruction_set() or None,
        "all_configurations": asdict(closed_form_of(arm)),
        "findings": [finding_json(finding) for finding in arm.findings],
    }


def actuators_json(motors: Actuators) -> dict[str, Any]:
    """The motors for programs, in SI. null means that a limit is not given."""
    return {field.name: getattr(motors, field.name) for field in fields(motors)} | {
        "limits": vars(motors.limits),
        "joint_limits": vars(motors.joint_limits),
        "undriven": motors.undriven,
    }


def info_view(arm: Arm, radians: bool) -> Group:
    """The tables of `info`."""
    freedom = "1 degree" if arm.n == 1 else f"{arm.n} degrees"
    head = (
        f"[bold]{literal(arm.name)}[/bold]: {freedom} of freedom from {literal(arm.base)} to {literal(arm.tip)}, "
        f"reach {arm.reach:.3f} m ({literal(arm.source)})"
    )
    parts: list[Any] = [head, "", _joints(arm, radians), "", _poses(arm, radians), ""]
    if arm.proof is not None:
        parts.append(
            f"proof at load: screws and Pinocchio agree within {arm.proof.pose_error:.1e} (pose) and "
            f"{arm.proof.jacobian_error:.1e} (Jacobian) at {arm.proof.samples} random configurations"
        )
    why_not, report = arm._why_not_compiled, closed_form_of(arm)
    parts.append(literal(f"engine: {engine_of(arm)}" + (f"; no compiled core: {why_not}" if why_not else "")))
    a = "an" if report.target[0] in "AEIO" else "a"
    parts.append(literal(f"all configurations of {a} {report.target} (ik --all): {report}"))
    if arm.actuators is not None:
        for motors in (_actuators(arm.actuators), *_motor_limits(arm, arm.actuators, radians)):
            parts += ["", motors]
        parts.append("")
    parts += [literal(words(finding.text, radians=radians)) for finding in arm.findings]
    return Group(*parts)


def engine_of(arm: Arm) -> str:
    """The engine of this arm's kinematics."""
    if arm._compiled is not None:
        return f"compiled core ({arm._compiled.instruction_set})"
    return "product of exponentials" if arm.description is None else "Pinocchio"


def _joints(arm: Arm, radians: bool) -> Any:
    limits = arm.limits
    columns = ["joint", "type", "unit", "lower", "upper", "velocity /s", "acceleration /s²", "effort"]
    values = [shown(arm, v, radians) for v in (limits.lower, limits.upper, limits.velocity, limits.acceleration)]
    rows = [
        [name, kind, unit, *(column[i] for column in values), number(limits.effort[i])]
        for i, (name, kind, unit) in enumerate(zip(arm.joint_names, arm.joint_types, units(arm, radians), strict=True))
    ]
    return table("joints, base to tip (− = not given)", columns, rows, text=["type"])


def _actuators(motors: Actuators) -> Any:
    rows = [
        [name, *(f"{ratio:g}" for ratio in row), f"{offset:g}", unit, "−" if np.isnan(ticks) else f"{ticks:g}"]
        for name, row, offset, unit, ticks in zip(
            motors.names, motors.G, motors.offset, motors.units, motors.ticks_per_turn, strict=True
        )
    ]
    columns = ["motor", *motors.joint_names, "offset", "counts in", "ticks per turn"]
    return table("motors = G theta + o (SI; rows of G)", columns, rows, text=["counts in"])


def _motor_limits(arm: Arm, motors: Actuators, radians: bool) -> list[Any]:
    """The motors' limits and the joint limits that follow from them."""
    given = [name for name in MOTOR_LIMITS if np.isfinite(getattr(motors.limits, name)).any()]
    if not given:
        return []
    rows = [
        [name, *(number(getattr(motors.limits, limit)[i]) for limit in given)] for i, name in enumerate(motors.names)
    ]
    own = table("limits of the motors, on their side (SI)", ["motor", *given], rows)
    alone = motors.joint_limits
    columns = [shown(arm, getattr(alone, name), radians) for name in given if name != "effort"]
    columns += [[number(effort) for effort in alone.effort]] if "effort" in given else []
    rows = [list(row) for row in zip(motors.joint_names, units(arm, radians), *columns, strict=True)]
    return [own, table("what they allow each joint, moving alone", ["joint", "unit", *given], rows, text=["unit"])]


def _poses(arm: Arm, radians: bool) -> Any:
    """A column for each pose, its name as it can be typed."""
    poses = {"ready": arm.ready, **arm.named_states}
    conditions = [float(arm.manipulability(theta).condition) for theta in poses.values()]
    values = [shown(arm, theta, radians) for theta in poses.values()]
    rows = [list(row) for row in zip(arm.joint_names, units(arm, radians), *values, strict=True)]
    rows.append(["condition", "", *("singular" if np.isinf(x) else number(x, 1) for x in conditions)])
    return table("poses (typed by name: --theta ready)", ["joint", "unit", *poses], rows, text=["unit"])


def version() -> str:
    """twistarm's own."""
    return metadata.version("twistarm")


def versions_json() -> dict[str, Any]:
    """The answer of `info` without ARM, for programs. null means that a library is not installed."""
    return {
        "twistarm": version(),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "engine": f"compiled core ({engine.instruction_set()})" if engine.core() else "Pinocchio",
        "core": engine.instruction_set() or None,
        "why_no_core": engine.why_not() or None,
        "libraries": {name: _version(name) for name, _ in libraries()},
    }


def versions_text() -> str:
    """The same for people."""
    said = versions_json()
    lines = [f"twistarm {version()}, Python {said['python']}, {said['platform']}", f"engine: {said['engine']}"]
    if said["why_no_core"]:
        lines.append(f"no compiled core: {said['why_no_core']}")
    for name, extra in libraries():
        missing = f"not installed: pip install 'twistarm[{extra}]'" if extra else "not installed"
        lines.append(f"  {name:<20} {said['libraries'][name] or missing}")
    return "\n".join([*lines, "an ARM's own: twistarm info ARM; the arms there are by name: twistarm arms"])


def libraries() -> list[tuple[str, str]]:
    """Name and extra ("" for the base install) of each requirement of the package."""
    pattern = re.compile(r"([\w.-]+)[^;]*(?:;.*extra == ['\"](\w+)['\"])?")
    here = [text for text in metadata.requires("twistarm") or () if "python_version" not in text]
    found = [pattern.match(text) for text in here]
    pairs = [(match[1], match[2] or "") for match in found if match]
    return [(name, extra) for name, extra in pairs if name != "twistarm" and extra not in ("dev", "all")]


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None
