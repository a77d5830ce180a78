"""Golden files and the difference of two arms in words: names, limits, motors, masses, axes and the tool."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arm.arm import Arm, require_arm
from ..arm.baking import BAKED, SUFFIX, Kind, content_of, sealed, unsealed
from ..arm.loading.load import arm_of, load_arm
from ..description.geometry import INERTIA, Body, bodies
from ..limits.joint_limits import RATES, JointLimits
from ..support.checks import Array, pose_of
from ..support.errors import ComparisonError, InputError
from ..support.files import as_path, write_whole
from ..theory.lines import least_turn, nearest_on_line
from ..theory.rotations import exp as rotation_exp
from ..theory.rotations import log as rotation_log
from ..theory.screws import adjoint, inverse, to_screw

GOLDEN = Kind("twistarm golden", "golden file", "twistarm freeze ARM -o FILE")

NOT_COVERED = (
    "shapes and meshes",
    "named configurations and the SRDF",
    "limits of joints beside the chain",
    "damping and friction",
)
"""What is not compared with a golden file."""

# Smaller differences, below 1 µm and 1e-6 rad, come from rounding in an export, not from a changed description.
SAME_TOL = 1e-6
# Unit vectors whose product is nearer than this to -1 are opposite: no least turn takes one to the other.
OPPOSITE = 1e-9
# Relative: ratios and ticks are written by hand, and a ratio of 1e-4 m per rad is a usual one.
SAME_RATIO_TOL = 1e-9
SAME_MASS_TOL = 1e-5  # Relative, of masses and inertias: exports write six digits.
SAMPLES = 100  # Random configurations at which poses and Jacobians are compared.

NO_MASSES = "masses were not compared: the reference has none. A new golden file has them"


@dataclass(frozen=True)
class Difference:
    """What has changed, one sentence each. Empty for the same arm. `pose_error` and `jacobian_error` are the worst.

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
    """Write the arm as numbers (JSON, SI): what `bake` keeps, and each link's mass, centre and inertia.

    `compare` lists the changes since. The file lists what it does not cover. These are shapes, named configurations,
    the SRDF, damping and friction, and limits of joints beside the chain. A digest covers every number, so an edited
    file is refused. The file is written whole or not at all.

    Args:
        arm: The arm.
        path: The file to write. An existing golden file is replaced.

    Raises:
        InputError: The file cannot be written.
    """
    write_whole(path, golden_text(arm))


def golden_text(arm: Arm) -> str:
    """What `freeze` writes."""
    written = {
        link: {"mass": body.mass, "centre": body.centre.tolist(), "inertia": body.inertia.tolist()}
        for link, body in (_bodies_of(require_arm(arm)) or {}).items()
    }
    kept = {"bodies": written if arm.description else None, "not_covered": list(NOT_COVERED)}
    return sealed(GOLDEN, content_of(arm) | kept)


def compare(arm: Arm, against: Arm | str | os.PathLike[str]) -> Difference:
    """The differences between an arm and another one in words: first the other one's value, then the arm's.

    Args:
        arm: The arm as it is now.
        against: A golden file that `freeze` wrote, a baked arm.json, or another arm: an `Arm` or anything that
            `load_arm` takes. A description is loaded without options.

    Returns:
        The `Difference`: names, types, limits, motors, axes, tool, and the mass, centre and inertia of each link.
        Shapes, named configurations and the SRDF are not compared. Differences below 1 µm, 1e-6 rad or 1e-5 of a mass
        do not count: an export rounds that much.

    Raises:
        DescriptionError: `against` cannot be read, or is no golden file, no baked arm and no description.
    """
    then, masses = _other(require_arm(arm), against)
    now = _bodies_of(arm)
    notes = (NO_MASSES,) if masses is None and now else ()
    with_masses = masses is not None and now is not None
    changes = _changes(_facts(then, masses if with_masses else None), _facts(arm, now if with_masses else None))
    for kind, was, names in (
        ("joints", then.joint_names, arm.joint_names),
        ("motors", *(() if side.actuators is None else side.actuators.names for side in (then, arm))),
    ):
        if was != names and sorted(was) == sorted(names):
            changes.append(f"order of the {kind}: {', '.join(was)} to {', '.join(names)}")
    if then.joint_names != arm.joint_names or then.screws.shape != arm.screws.shape:
        return Difference(arm.name, tuple(changes or ["other joints are followers"]), notes=notes)
    changes += geometry_changes(arm, then.screws, then.home)
    if max(np.abs(was - now).max() for was, now in zip(then.coupling, arm.coupling, strict=True)) > SAME_TOL:
        changes.append("the coupling of mimic or locked joints is different")
    theta = then.random_theta(0, SAMPLES)
    g, spatial, body = (
        float(np.abs(was - now).max())
        for was, now in zip(then.by_exponentials(theta), arm.by_exponentials(theta), strict=True)
    )
    return Difference(arm.name, tuple(changes), g, max(spatial, body), notes)


def _other(arm: Arm, against: Arm | str | os.PathLike[str]) -> tuple[Arm, Mapping[str, Body] | None]:
    """The arm to compare with, and the masses of its links where they are known."""
    if not isinstance(against, (Arm, str, os.PathLike)):
        raise InputError(f"against must be an Arm, a file or a name that load_arm takes; got {type(against).__name__}")
    if isinstance(against, Arm):
        return against, _bodies_of(against)
    path = as_path(str(os.fspath(against)))
    if path.suffix != SUFFIX:
        other = load_arm(against)
        return other, _bodies_of(other)
    content = unsealed(path, GOLDEN, BAKED)
    written = content.get("bodies")
    masses = written and {
        link: Body(body["mass"], np.array(body["centre"]), np.array(body["inertia"])) for link, body in written.items()
    }
    return arm_of(content), masses


def _bodies_of(arm: Arm) -> Mapping[str, Body] | None:
    """The mass of each link. None for an arm without a description."""
    return None if arm.description is None else bodies(arm.description)


# -- names and numbers -------------------------------------------------------------------------------------------------


class Fact(NamedTuple):
    """A text or numbers of an arm, and the difference that is none. Infinity and NaN mean "not given"."""

    value: str | Array
    tolerance: float = SAME_TOL
    unit: str = ""


Facts = Mapping[str, Mapping[str, Fact]]  # The facts of each joint, motor and link.


def _facts(arm: Arm, masses: Mapping[str, Body] | None) -> Facts:
    facts = {"the arm": {"base": Fact(arm.base), "tip": Fact(arm.tip)}}
    for i, name in enumerate(arm.joint_names):
        facts[f"joint {name}"] = {"type": Fact(arm.joint_types[i]), **_limit_facts(arm.limits, i, arm.units[i])}
    motors = arm.actuators
    for i, name in enumerate(motors.names if motors else ()):
        assert motors is not None
        ratios = {f"ratio to joint {joint}": _number(motors.G[i, k]) for k, joint in enumerate(motors.joint_names)}
        facts[f"motor {name}"] = ratios | {
            "ticks per turn": _number(motors.ticks_per_turn[i]),
            "offset": _number(motors.offset[i]),
            "unit": Fact(motors.units[i]),
            **_limit_facts(motors.limits, i, motors.motor_units[i]),
        }
    for link, body in (masses or {}).items():
        moments = body.inertia[np.triu_indices(3)]
        facts[f"the body of link {link}"] = {
            "mass": Fact(np.array([body.mass]), SAME_MASS_TOL * body.mass, "kg"),
            "centre": Fact(body.centre, unit="m"),
            f"inertia ({', '.join(INERTIA)})": Fact(moments, SAME_MASS_TOL * float(np.abs(moments).max()), "kg m²"),
        }
    return facts


def _limit_facts(limits: JointLimits, i: int, unit: str) -> dict[str, Fact]:
    rates = {f"{rate} limit": Fact(np.array([getattr(limits, rate)[i]])) for rate in RATES}
    return {"limits": Fact(np.array([limits.lower[i], limits.upper[i]]), unit=unit), **rates}


def _number(value: float) -> Fact:
    """A number that is written by hand."""
    return Fact(np.array([value]), SAME_RATIO_TOL * float(np.nan_to_num(abs(value))))


def _changes(before: Facts, after: Facts) -> list[str]:
    """What is gone or new, then what differs."""
    changes = [f"{owner} is gone" for owner in before if owner not in after]
    changes += [f"{owner} is new" for owner in after if owner not in before]
    for owner, facts in before.items():
        for part, then in facts.items():
            now = after.get(owner, {}).get(part)
            if now is None:
                continue
            if isinstance(then.value, str) or isinstance(now.value, str):
                same = then.value == now.value
            else:
                tolerance = max(then.tolerance, now.tolerance)
                same = np.allclose(then.value, now.value, rtol=0.0, atol=tolerance, equal_nan=True)
            if not same:  # with the fewest digits, six at least, in which the values differ
                pairs = ((_digits(then.value, digits), _digits(now.value, digits)) for digits in (6, 9, 12, 17))
                was, is_ = next((pair for pair in pairs if pair[0] != pair[1]), ("", ""))
                changes.append(f"{part} of {owner}: {was} to {is_} {now.unit}".rstrip())
    return changes


def _digits(value: str | Array, digits: int) -> str:
    if isinstance(value, str):
        return value
    numbers = [f"{x:.{digits}g}" if np.isfinite(x) else "not given" for x in value]
    return f"[{', '.join(numbers)}]" if len(numbers) > 1 else numbers[0]


# -- axes and tool -----------------------------------------------------------------------------------------------------


def geometry_changes(arm: Arm, screws: Array, home: Array) -> list[str]:
    """The moved axes from base to tip, without those that a moved joint only carries.

    `carried` is the rigid motion that the changes so far give to everything beyond.
    """
    changes = []
    carried = np.eye(4)
    for i, name in enumerate(arm.moving_names):
        before = adjoint(carried) @ screws[:, i:]
        words, motion = _axis_change(before, arm.screws[:, i:], carried @ home, arm.home)
        changes += [f"joint {name} {word}" for word in words]
        carried = motion @ carried
    if np.abs(arm.home - carried @ home).max() > SAME_TOL:
        # The tool's own motion in the home pose, that of what it rides on included.
        words = _shift_words(arm.home[:3, 3] - home[:3, 3]) + _turn_words(arm.home[:3, :3] @ home[:3, :3].T)
        in_all = " in all" if changes else ""
        words = [word + in_all for word in words] or ["has the same pose"]
        changes += [f"tool {arm.tip} {word}" for word in words]
    return changes


def _axis_change(before: Array, now: Array, tool: Array, new_tool: Array) -> tuple[list[str], Array]:
    """The change of the first of the axes (6, k) in words, and the rigid motion of what is beyond it.

    It is the least motion that carries the old line to the new. For a line that has turned, it is the tool's motion if
    every axis beyond has made it too. The points of a turned line have moved by different lengths. The words give that
    of the point nearest the tool, independent of the base.
    """
    if np.abs(now[:, 0] - before[:, 0]).max() <= SAME_TOL:
        return [], np.eye(4)
    old, new = to_screw(before[:, 0]), to_screw(now[:, 0])
    turning = bool(np.isfinite(old.pitch) and np.isfinite(new.pitch))
    anchor = nearest_on_line(old.axis, old.point, tool[:3, 3]) if turning else tool[:3, 3]
    motion = new_tool @ inverse(tool)
    rotated = np.abs(new.axis - old.axis).max() > SAME_TOL
    if rotated and np.abs(adjoint(motion) @ before - now).max() <= SAME_TOL:
        return _motion_words(motion, anchor), motion
    words, turn = [], np.eye(3)
    if old.axis @ new.axis < -1 + OPPOSITE:  # the line stays where it is: nothing beyond it has turned
        words.append("is reversed: it turns or slides the other way")
    else:  # the least rotation from one axis to the other
        turn = rotation_exp(least_turn(old.axis, new.axis))
    there = nearest_on_line(new.axis, new.point, anchor) if turning else anchor
    motion = pose_of(turn, there - turn @ anchor)
    words += _motion_words(motion, anchor)
    if turning and abs(new.pitch - old.pitch) > SAME_TOL:
        words.append(f"changed its pitch from {old.pitch:.6g} to {new.pitch:.6g} m/rad")
    return words, motion


def _motion_words(motion: Array, anchor: Array) -> list[str]:
    """The turn of a line, and its motion at `anchor`, the point nearest to the tool."""
    rotated = _turn_words(motion[:3, :3])
    moved = _shift_words(motion[:3, :3] @ anchor + motion[:3, 3] - anchor)
    return rotated + [f"{word} where it is nearest the tool" if rotated else word for word in moved]


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
    if abs(unit[i]) > 0.9999:  # within 0.8° of the axis
        return ("" if unit[i] > 0 else "−") + "xyz"[i]
    return "(" + ", ".join(f"{x:.2f}" for x in unit) + ")"
