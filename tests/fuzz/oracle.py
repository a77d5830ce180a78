"""What must hold of every mutant: refused in one clean line, or loaded and right by every account."""

from __future__ import annotations

import contextlib
import io
import sys
import time
import traceback
import unicodedata
import warnings
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from twistarm import Arm, crosscheck, load_arm
from twistarm.support.errors import ComparisonError, TwistarmError

from . import reader

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

LONGEST = 2000  # Characters of a message: more is no line that anybody reads.

TOLERANCE = 1e-9

STEP = 1e-4  # Of the difference quotient of the potential energy [rad or m].
# A follower that turns faster, or starts further off, leaves a difference quotient too few digits.
WIDEST = 1e3
UNBOUNDED = 1e9  # Bounds beyond this are read as none.


def judged(path: Path, arguments: Mapping[str, Any], packages: Mapping[str, Path]) -> dict[str, Any]:
    """The verdict on one file: outcome, code of the refusal, problems, seconds."""
    start = time.perf_counter()
    verdict: dict[str, Any] = {"problems": [], "message": "", "code": ""}
    try:
        arm = load_arm(path, **arguments)
    except TwistarmError as error:
        verdict |= {"outcome": "refused", "error": type(error).__name__, "message": str(error), "code": _code(error)}
        verdict["problems"] = [f"message {flaw}" for flaw in flaws(str(error))] + _finding_flaws(error)
        if isinstance(error, ComparisonError):
            verdict["problems"].append(str(error))
    except BaseException:
        verdict |= {"outcome": "traceback", "problems": [traceback.format_exc()]}
    else:
        verdict |= {"outcome": "loaded", "problems": _checked(arm, path, packages, arguments)}
        verdict["findings"] = [finding.code for finding in arm.findings]
    verdict["seconds"] = time.perf_counter() - start
    return verdict


def _code(error: TwistarmError) -> str:
    findings = getattr(error, "findings", ())
    return next((finding.code for finding in findings if finding.severity == "error"), type(error).__name__)


def flaws(message: str) -> list[str]:
    """What is wrong with a text for people: empty, long, more than a line, unprintable, Python's own."""
    flaws = []
    if not message.strip():
        flaws.append("is empty")
    if len(message) > LONGEST:
        flaws.append(f"has {len(message)} characters")
    if any(unicodedata.category(character) in ("Cc", "Cs", "Zl", "Zp") for character in message):
        flaws.append(f"has control characters: {message[:300]!r}")
    if "Traceback" in message or "object at 0x" in message:
        flaws.append(f"is Python's own: {message[:300]!r}")
    return flaws


def _finding_flaws(findings_of: Any) -> list[str]:
    findings = getattr(findings_of, "findings", ())
    return [f"finding {finding.code} {flaw}" for finding in findings for flaw in flaws(str(finding))]


def _checked(arm: Arm, path: Path, packages: Mapping[str, Path], arguments: Mapping[str, Any]) -> list[str]:
    try:
        return [
            *_finding_flaws(arm),
            *_consistent(arm),
            *_crosschecked(arm),
            *_read_again(arm, path, packages, arguments),
        ]
    except BaseException:
        return [traceback.format_exc()]


def _consistent(arm: Arm) -> list[str]:
    theta = arm.random_theta(np.random.default_rng(1), 3)
    conditions = {
        "joint names repeat": len(set(arm.joint_names)) == arm.n > 0,
        "limits out of order": bool((arm.limits.lower <= arm.limits.upper).all()),
        "rates not positive": bool((arm.limits.velocity > 0).all() and (arm.limits.effort > 0).all()),
        "home or screws not finite": bool(np.isfinite(arm.home).all() and np.isfinite(arm.screws).all()),
        "fk not finite": bool(np.isfinite(arm.fk(theta)).all()),
        "ready outside the limits": bool(arm.limits.contains(arm.ready)),
        "reach not positive": bool(0 < arm.reach < np.inf),
        "no proof": arm.proof is not None,
    }
    return [what for what, holds in conditions.items() if not holds]


def _crosschecked(arm: Arm) -> list[str]:
    """Differences between engines; Pinocchio reads an `<axis/>` without numbers as none, and a finding names it."""
    unread = any(finding.code == "word-unread" and "its <axis> has no xyz" in finding.what for finding in arm.findings)
    check = crosscheck(arm, samples=3)
    return [
        f"{row.quantity} {row.engines}: {row.worst:.3g} > {row.tolerance:.3g}"
        for row in check.comparisons
        if not row.ok and not (unread and "pinocchio as written" in row.engines)
    ]


def _read_again(arm: Arm, path: Path, packages: Mapping[str, Path], arguments: Mapping[str, Any]) -> list[str]:
    """The tip's pose and the limits by the independent reader, from the file itself."""
    table = tomllib.loads(reader.decoded(path.read_bytes())) if path.suffix == ".toml" else {}
    description = path.parent / table["source"] if table else path
    robot = reader.parsed(_expanded(arm, description, {**arguments, **table}.get("xacro_args", {}), packages))
    tool = table.get("tool", {})
    g_tip_tool = reader.placed(tool.get("xyz", np.zeros(3)), tool.get("rpy", np.zeros(3)))
    problems = [] if table or "limits" in arguments else _other_bounds(arm, robot)
    wanted = reader.coordinates(robot, arm.base, arm.tip_link) - set(table.get("locked_joints", {}))
    if set(arm.joint_names) != wanted:
        problems.append(f"coordinates {sorted(arm.joint_names)} instead of {sorted(wanted)}")
    problems += _other_torques(arm, robot, table.get("locked_joints", {}))
    for theta in arm.random_theta(np.random.default_rng(2), 3):
        values = {**arm.theta_to_dict(theta), **table.get("locked_joints", {})}
        expected = reader.pose(robot, values, arm.base, arm.tip_link) @ g_tip_tool
        size = 1 + np.abs(expected[:3, 3]).max() + np.abs(arm.home[:3, 3]).max() + arm.reach
        error = np.abs(arm.fk(theta) - expected).max()
        # The reading rounds the joints' values themselves, and a follower may turn a hundred million rad.
        values_rounded = np.finfo(float).eps * (np.abs(arm.coupling.A) @ np.abs(theta) + np.abs(arm.coupling.b)).max()
        if not error <= (TOLERANCE + values_rounded) * size:
            problems.append(f"fk differs by {error:.3g} from the independent reading at {values}")
    return problems


def _other_torques(arm: Arm, robot: ET.Element, locked: Mapping[str, float]) -> list[str]:
    """Gravity torques along a random direction against the slope of the potential energy."""
    if arm.description is None or arm.base != arm.description.root:
        return []
    theta, direction = np.random.default_rng(3).normal(size=(2, arm.n))

    def values(h: float) -> dict[str, float]:
        return {**arm.theta_to_dict(theta + h * direction), **locked}

    joints = reader.named_joints(robot)
    widest = max(1.0, *(abs(reader.joint_value(name, values(h), joints)) for name in joints for h in (0.0, 1.0)))
    if widest > WIDEST:
        return []
    step = STEP / widest
    ahead, behind = (reader.potential_energy(robot, values(h), arm.base) for h in (step, -step))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # links without a mass
        slope, ours = (ahead - behind) / (2 * step), arm.inverse_dynamics(theta) @ direction
    size = 1 + abs(slope) + (abs(ahead) + abs(behind)) * 1e-9 / step
    return [] if abs(slope - ours) <= 1e-6 * size else [f"gravity torques do {ours:g} J along a slope of {slope:g} J"]


def _other_bounds(arm: Arm, robot: ET.Element) -> list[str]:
    given = reader.bounds(robot)
    return [
        f"limits of {name}: [{lower}, {upper}] instead of {given[name]}"
        for name, lower, upper in zip(arm.joint_names, arm.limits.lower, arm.limits.upper, strict=True)
        if name in given and (lower, upper) != given[name] and max(map(abs, given[name])) < UNBOUNDED
    ]


def _expanded(arm: Arm, path: Path, arguments: Mapping[str, Any], packages: Mapping[str, Path]) -> bytes:
    """The URDF as bytes; xacro is expanded by xacro itself, with nothing of twistarm around it.

    Where xacro itself refuses (it reads UTF-8 only), the text that twistarm expanded.
    """
    data = path.read_bytes()
    if path.suffix != ".xacro" and "<xacro:" not in reader.decoded(data):
        return data
    import xacro
    from xacro import substitution_args

    def find(name: str) -> str:
        return str(packages.get(name, "/nowhere"))

    own = substitution_args._eval_find
    substitution_args._eval_find = substitution_args._eval_dict["find"] = find
    mappings = {name: str(value) for name, value in arguments.items()}
    try:
        with contextlib.redirect_stderr(io.StringIO()):
            return str(xacro.process_file(str(path), mappings=mappings, verbosity=0).toxml()).encode()
    except Exception:
        assert arm.description is not None
        return arm.description.text.encode()
    finally:
        substitution_args._eval_find = substitution_args._eval_dict["find"] = own
