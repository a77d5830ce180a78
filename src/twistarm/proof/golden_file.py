"""Golden files: an arm frozen as numbers, and in words what has changed since."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..description.document import read_text
from ..limits.joint_limits import FIELDS
from ..model.arm import Arm, require_arm
from ..model.baking import actuators_entry, read_actuators, read_limits, reason
from ..support.checks import Array, as_floats, as_pose
from ..support.errors import ComparisonError, DescriptionError
from ..support.files import as_path, write_whole
from ..support.strict_json import parsed
from ..theory.rotations import log as rotation_log
from ..theory.screws import Screw, adjoint, hat, inverse, to_screw
from .changes import SAME_TOL, limit_changes, motor_changes, name_changes
from .crosscheck import by_exponentials

FORMAT = "twistarm golden 1"

MAX_BYTES = 10_000_000
"""Six joints have some 200 kB; 250 joints 7 MB."""

_FREEZE = "twistarm freeze writes one"
SAMPLES = 100

NO_MOTORS = "the golden file knows nothing of the motors, which were not compared: freeze the arm again"
"""Of a file that was written before motors were frozen."""

OPPOSITE = 1e-9
"""Unit vectors whose product is nearer than this to -1 are opposite: no least turn takes one to the other."""


@dataclass(frozen=True)
class Difference:
    """What has changed, one sentence each; empty for the same arm. `pose_error` and `jacobian_error` are the worst.

    `notes` say what could not be compared.
    """

    arm: str
    changes: tuple[str, ...]
    pose_error: float = 0.0
    jacobian_error: float = 0.0
    notes: tuple[str, ...] = ()

    @property
    def same(self) -> bool:
        """Nothing has changed."""
        return not self.changes

    def require(self) -> Difference:
        """Itself, or ComparisonError with every change."""
        if self.changes:
            raise ComparisonError(f"{self.arm} has changed: " + "; ".join(self.changes))
        return self


def freeze(arm: Arm, path: str | os.PathLike[str]) -> None:
    """Write the arm as numbers (JSON, SI): names, screws, home, limits, motors, and FK and Jacobians at 100 seeded
    postures.

    All of it from the product of exponentials, so that the file depends on no engine. Written whole or not at all.
    """
    write_whole(path, golden_text(arm))


def golden_text(arm: Arm) -> str:
    """What `freeze` writes."""
    theta = require_arm(arm).random_theta(0, SAMPLES)
    g, spatial, body = by_exponentials(arm, theta)
    content = {
        "format": FORMAT,
        "name": arm.name,
        "base": arm.base,
        "tip": arm.tip,
        "joints": [
            {"name": name, "type": kind, "unit": unit}
            | {field: _finite(getattr(arm.limits, field)[i]) for field in FIELDS}
            for i, (name, kind, unit) in enumerate(zip(arm.joint_names, arm.joint_types, arm.units, strict=True))
        ],
        "screws": arm.screws.tolist(),
        "home": arm.home.tolist(),
        "coupling": {"A": arm.coupling.A.tolist(), "b": arm.coupling.b.tolist()},
        "actuators": None if arm.actuators is None else actuators_entry(arm.actuators),
        "theta": theta.tolist(),
        "fk": g.tolist(),
        "spatial_jacobian": spatial.tolist(),
        "body_jacobian": body.tolist(),
    }
    return json.dumps(content, allow_nan=False) + "\n"


def compare(arm: Arm, path: str | os.PathLike[str]) -> Difference:
    """What has changed since `freeze` wrote `path`, in words; DescriptionError if the file is no golden file."""
    return _compare(require_arm(arm), _read(as_path(path)))


def _compare(arm: Arm, golden: dict[str, Any]) -> Difference:
    changes = [
        f"{role} was {golden[role]!r}, is {getattr(arm, role)!r}"
        for role in ("base", "tip")
        if golden[role] != getattr(arm, role)
    ]
    changes += _joint_changes(arm, golden)
    notes: tuple[str, ...] = ()
    if "actuators" in golden:
        changes += motor_changes(golden["actuators"], arm.actuators)
    elif arm.actuators is not None:
        notes = (NO_MOTORS,)
    then = [joint["name"] for joint in golden["joints"]]
    if then != list(arm.joint_names) or golden["screws"].shape != arm.screws.shape:
        return Difference(arm.name, tuple(changes or ["the joints that follow others are different ones"]), notes=notes)
    moved = _geometry_changes(arm, golden["screws"], golden["home"])
    if max(np.abs(golden[k] - v).max() for k, v in zip("Ab", arm.coupling, strict=True)) > SAME_TOL:
        moved.append("the coupling of mimic or locked joints is different")
    theta = golden["theta"]
    g, spatial, body = by_exponentials(arm, theta)
    pose_error = float(np.abs(g - golden["fk"]).max())
    jacobian_error = max(
        float(np.abs(spatial - golden["spatial_jacobian"]).max()),
        float(np.abs(body - golden["body_jacobian"]).max()),
    )
    if max(pose_error, jacobian_error) > 10 * SAME_TOL and not moved:
        moved.append(
            f"poses differ by up to {pose_error:.2g} and Jacobians by {jacobian_error:.2g} over {len(theta)} postures"
        )
    return Difference(arm.name, (*changes, *moved), pose_error, jacobian_error, notes)


def _finite(value: float) -> float | None:
    """JSON knows no infinity: null stands for "not given"."""
    return float(value) if np.isfinite(value) else None


def _read(path: Path) -> dict[str, Any]:
    try:
        content = parsed(read_text(path, MAX_BYTES))
    except ValueError as error:
        raise DescriptionError(f"{path}: not a golden file: {error}; {_FREEZE}") from error
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise DescriptionError(f"{path}: not a golden file of this version ({FORMAT!r}); {_FREEZE}")
    try:
        return {**content, **_checked(content)}
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise DescriptionError(
            f"{path}: a damaged golden file ({reason(error)}); write it anew with twistarm freeze"
        ) from error


def _checked(content: dict[str, Any]) -> dict[str, Any]:
    """The arrays, limits and motors of a golden file, of the shapes that its joints ask for; ValueError otherwise."""
    n, m = len(content["joints"]), len(content["coupling"]["b"])
    N = len(content["theta"])
    shapes = {
        "screws": (6, m), "home": (4, 4), "theta": (N, n), "fk": (N, 4, 4),
        "spatial_jacobian": (N, 6, n), "body_jacobian": (N, 6, n),
    }  # fmt: skip
    arrays = {name: as_floats(content[name], name) for name in shapes}
    arrays |= {"A": as_floats(content["coupling"]["A"], "A"), "b": as_floats(content["coupling"]["b"], "b")}
    for name, shape in {**shapes, "A": (m, n), "b": (m,)}.items():
        if arrays[name].shape != shape:
            raise ValueError(f"{name} has shape {arrays[name].shape} instead of {shape}")
    if not np.abs(arrays["screws"]).max(axis=0).all():
        raise ValueError("a joint whose screw is zero")
    as_pose(arrays["home"], "home")
    joints = content["joints"]
    for joint in joints:
        if not all(isinstance(joint[key], str) for key in ("name", "type")):
            raise ValueError("a joint without name or type")
    if not all(isinstance(content[key], str) for key in ("base", "tip")):
        raise ValueError("no base or no tip")
    read: dict[str, Any] = {"limits": read_limits({field: [joint[field] for joint in joints] for field in FIELDS})}
    if "actuators" in content:
        read["actuators"] = read_actuators(content["actuators"], tuple(joint["name"] for joint in joints))
    return arrays | read


def _joint_changes(arm: Arm, golden: dict[str, Any]) -> list[str]:
    then, now = [joint["name"] for joint in golden["joints"]], list(arm.joint_names)
    changes = name_changes("joint", then, now)
    for i, joint in enumerate(golden["joints"]):
        name = joint["name"]
        if name in now:
            j = now.index(name)
            if joint["type"] != arm.joint_types[j]:
                changes.append(f"joint {name} was {joint['type']}, is {arm.joint_types[j]}")
            changes += limit_changes(name, arm.units[j], golden["limits"], i, arm.limits, j)
    return changes


# -- geometry ----------------------------------------------------------------------------------------------------


def _geometry_changes(arm: Arm, screws: Array, home: Array) -> list[str]:
    """Which axes have moved, seen base to tip: what merely rides on a moved joint is not named again.

    `carried` is the rigid motion that the changes so far have given to everything beyond them.
    """
    changes = []
    carried = np.eye(4)
    for i, name in enumerate(arm.moving_names):
        before = adjoint(carried) @ screws[:, i:]
        words, motion = _axis_change(before, arm.screws[:, i:], carried @ home, arm.home)
        changes += [f"joint {name} {word}" for word in words]
        carried = motion @ carried
    if np.abs(arm.home - carried @ home).max() > SAME_TOL:
        in_all = " in all" if changes else ""
        changes += [f"tool {arm.tip} {word}" for word in _tool_words(home, arm.home, in_all)]
    return changes


def _axis_change(before: Array, now: Array, tool: Array, new_tool: Array) -> tuple[list[str], Array]:
    """How the first of the axes (6, k) has changed, in words, and the rigid motion of what lies beyond it.

    That is the least one that carries the old line to the new; for a line that has turned, the motion of the tool
    where every axis beyond has made it too. Of a turned line each point has moved by another length: told is that of
    the point nearest the tool, wherever the base is.
    """
    if np.abs(now[:, 0] - before[:, 0]).max() <= SAME_TOL:
        return [], np.eye(4)
    old, new = to_screw(before[:, 0]), to_screw(now[:, 0])
    turning = bool(np.isfinite(old.pitch) and np.isfinite(new.pitch))
    anchor = _nearest(old, tool[:3, 3]) if turning else tool[:3, 3]
    motion = new_tool @ inverse(tool)
    turned = np.abs(new.axis - old.axis).max() > SAME_TOL
    if turned and np.abs(adjoint(motion) @ before - now).max() <= SAME_TOL:
        return _motion_words(motion, anchor), motion
    reversed_axis = float(old.axis @ new.axis) < -1 + OPPOSITE
    words = ["is reversed: it turns or slides the other way"] if reversed_axis else []
    # Reversed, the line stays where it is: nothing beyond it has turned.
    turn = np.eye(3) if reversed_axis else _turn(old.axis, new.axis)
    motion = _motion(turn, anchor, _nearest(new, anchor) if turning else anchor)
    words += _motion_words(motion, anchor)
    if turning and abs(new.pitch - old.pitch) > SAME_TOL:
        words.append(f"changed its pitch from {old.pitch:.6g} to {new.pitch:.6g} m/rad")
    return words, motion


def _nearest(line: Screw, point: Array) -> Array:
    """The point of the line nearest to `point`."""
    nearest: Array = line.point + line.axis * (line.axis @ (point - line.point))
    return nearest


def _motion(turn: Array, start: Array, end: Array) -> Array:
    """The motion (4, 4) that turns and takes the point `start` to `end`."""
    motion = np.eye(4)
    motion[:3, :3] = turn
    motion[:3, 3] = end - turn @ start
    return motion


def _turn(a: Array, b: Array) -> Array:
    """The least rotation with R a = b, for unit vectors that are not opposite."""
    K = hat(np.cross(a, b))
    turn: Array = np.eye(3) + K + K @ K / (1 + float(a @ b))
    return turn


def _motion_words(motion: Array, anchor: Array) -> list[str]:
    """How a line has turned, and how far it has moved at `anchor`, its point nearest the tool."""
    turned = _turn_words(motion[:3, :3])
    moved = _shift_words(motion[:3, :3] @ anchor + motion[:3, 3] - anchor)
    return turned + [f"{word} where it is nearest the tool" if turned else word for word in moved]


def _tool_words(before: Array, now: Array, in_all: str) -> list[str]:
    """The tool's own motion in the home pose, what it rides on included."""
    words = _shift_words(now[:3, 3] - before[:3, 3]) + _turn_words(now[:3, :3] @ before[:3, :3].T)
    return [word + in_all for word in words] or ["is where it was all the same"]


def _turn_words(turn: Array) -> list[str]:
    w = rotation_log(turn)
    angle = float(np.linalg.norm(w))
    return [f"turned by {np.degrees(angle):.3g}° about {_direction(w)}"] if angle > SAME_TOL else []


def _shift_words(shift: Array) -> list[str]:
    distance = float(np.linalg.norm(shift))
    return [f"moved {distance * 1e3:.4g} mm along {_direction(shift)}"] if distance > SAME_TOL else []


def _direction(vector: Array) -> str:
    """`x`, `−z`, or the unit vector in base axes."""
    unit = vector / np.linalg.norm(vector)
    i = int(np.abs(unit).argmax())
    if abs(unit[i]) > 0.9999:
        return ("" if unit[i] > 0 else "−") + "xyz"[i]
    return "(" + ", ".join(f"{x:.2f}" for x in unit) + ")"
