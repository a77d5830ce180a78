"""One joint in its description: its axis, its `<limit>`, and the soft limits of a controller inside it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping

import numpy as np

from ..support.checks import Array, number_in
from ..support.errors import InputError, listed
from ..support.messages import first_of
from .document import Reading, floats
from .tree import Joint

# Deviation of an axis's length from 1 that gives a finding. The rounding of CAD exports is finer.
AXIS_TOL = 1e-3
SNAP = 2e-12  # An axis so near to x, y or z is rounded to it. Pinocchio's parser rounds too, at 1e-12.
# The number for "no limit" in a URDF, whose readers refuse infinity. Read as infinity, like any more.
NO_LIMIT = 1e9

LIMIT_NAMES = ("lower", "upper", "velocity", "effort")
SOFT_NAMES = ("soft_lower_limit", "soft_upper_limit")

ROUNDED = 0.01  # [rad, m]: a limit in another file that is rounded differs by less.
MOST_SHOWN = 12  # Joints in one finding.

Bounds = tuple[float, float]


def read_axis(element: ET.Element, kind: str, reading: Reading) -> tuple[Array, float]:
    """The unit axis and its length as written. The axis is x for a joint that needs none."""
    default = np.array([1.0, 0.0, 0.0])
    axis = element.find("axis")
    if axis is None or kind in ("fixed", "floating"):
        return default, 1.0
    with reading.numbers_of(element, "its <axis> is malformed: "):
        vector = np.array(floats(axis.get("xyz", "1 0 0"), 3))
    norm = float(np.linalg.norm(vector))
    if norm < 1e-9:  # zeros, or what an export made of them
        remedy = "give the axis it moves along or about"
        raise reading.error(element, "number-malformed", "a moving joint with a zero axis", remedy)
    if abs(norm - 1.0) > AXIS_TOL:
        what = f"its axis {axis.get('xyz')} has length {norm:.4g}; only the direction counts"
        reading.note("axis-not-unit", element, what, "write a unit vector")
    unit = vector / norm
    nearest = np.round(unit)
    return (nearest if np.abs(unit - nearest).max() <= SNAP else unit), norm


def limit_numbers(element: ET.Element, reading: Reading) -> dict[str, float]:
    """The numbers that the joint's `<limit>` gives."""
    return _numbers(element, "limit", (*LIMIT_NAMES, "acceleration", "deceleration", "jerk"), reading)


def read_bounds(element: ET.Element, kind: str, given: Mapping[str, float], reading: Reading) -> Bounds:
    """(lower, upper), with a finding if one is missing. One missing bound is 0, two are infinite.

    URDF 1.0 and 1.1 have 0 for a missing bound. URDF 1.2 requires both.
    """
    if kind not in ("revolute", "prismatic"):
        return -np.inf, np.inf
    missing = [name for name in ("lower", "upper") if name not in given]
    both = len(missing) == 2
    if missing:
        what = "no <limit>" if element.find("limit") is None else f"a <limit> without {' and '.join(missing)}"
        what += "; unbounded both ways" if both else "; URDF reads it as 0"
        remedy = f"write lower and upper in the URDF, or limits.{element.get('name')} in arm.toml"
        reading.note("limit-incomplete", element, what, remedy)
    lower, upper = given.get("lower", -np.inf if both else 0.0), given.get("upper", np.inf if both else 0.0)
    if lower >= NO_LIMIT or upper <= -NO_LIMIT:
        what = f"its limits lower {lower:g}, upper {upper:g} allow no position"
        raise reading.error(element, "number-malformed", what, "give finite bounds")
    if lower > upper:
        unwritten = f"; {missing[0]} is missing, which counts as 0" if missing else ""
        what = f"its limits are swapped: lower {lower:g} > upper {upper:g}{unwritten}"
        raise reading.error(element, "limits-swapped", what, "write both" if missing else "exchange them")
    if lower == upper:
        remedy = f"give its range as limits.{element.get('name')} in arm.toml"
        reading.note("limit-incomplete", element, f"lower and upper are both {lower:g}: the joint cannot move", remedy)
    return (lower if lower > -NO_LIMIT else -np.inf), (upper if upper < NO_LIMIT else np.inf)


def softened(element: ET.Element, kind: str, hard: Bounds, reading: Reading) -> Bounds:
    """The bounds inside those of the joint's `<safety_controller>`, as in MoveIt and ros_control.

    A missing soft bound is 0. Two equal soft bounds mean "not given", also if both are missing.
    """
    if kind not in ("revolute", "prismatic"):
        return hard
    given = _numbers(element, "safety_controller", SOFT_NAMES, reading)
    soft_lower, soft_upper = (given.get(name, 0.0) for name in SOFT_NAMES)
    if soft_lower == soft_upper:
        return hard
    lower, upper = max(hard[0], soft_lower), min(hard[1], soft_upper)
    if lower < upper or (lower == upper == hard[0] == hard[1]):
        return lower, upper
    what = f"its soft limits [{soft_lower:g}, {soft_upper:g}] lie outside its limits; they are ignored"
    reading.note("outside-limits", element, what, "correct its <safety_controller>, or take it out")
    return hard


def note_softened(joints: Iterable[Joint], reading: Reading) -> None:
    """Add one finding for all joints with the range of a controller."""
    narrower = [joint for joint in joints if (joint.lower, joint.upper) != joint.hard]
    if narrower:
        ranges = [f"{joint.name} [{joint.lower:g}, {joint.upper:g}]" for joint in narrower]
        shown = first_of(ranges, MOST_SHOWN)
        what = f"the soft limits of <safety_controller> are kept, inside those of <limit>: {shown}"
        reading.note("limits-adjusted", None, what, "give lower and upper in arm.toml for other limits")


def note_commanded(robot: ET.Element, joints: Mapping[str, Joint], reading: Reading) -> None:
    """Note limits of `<ros2_control>` that are narrower than the joint's, off, or no numbers. They are not used."""
    odd: dict[str, None] = {}
    known = {name for joint in joints.values() for name in (joint.name, joint.part_of)}
    for element in robot.findall("ros2_control/joint"):
        joint = joints.get(name := element.get("name", ""))
        if name not in known:
            odd[f"{name}, which is no joint"] = None
        if joint is None or not joint.scalar:
            continue
        rates = {"velocity": joint.velocity, "effort": joint.effort}
        bounds = {"position": (joint.lower, joint.upper)} | {name: (-most, most) for name, most in rates.items()}
        if any(limits.get("enable", "").lower() in ("false", "0") for limits in element.iter("limits")):
            odd[f"{joint.name} off"] = None
        for interface in element.findall("command_interface"):
            written = {param.get("name"): (param.text or "").strip() for param in interface.findall("param")}
            lower, upper = bounds.get(name := interface.get("name", ""), (np.inf, -np.inf))
            ends = written.get("min", "-inf"), written.get("max", "inf")
            try:
                least, most = (number_in(end, name, -np.inf, np.inf) for end in ends)
                differs = least > lower + ROUNDED or most < upper - ROUNDED
            except InputError:  # an expression that no xacro has resolved
                differs = True
            if differs:
                odd[f"{joint.name} {name} [{', '.join(ends)}]"] = None
    if odd:
        what = f"<ros2_control> has other limits or names, which are not used here: {listed(odd, MOST_SHOWN)}"
        reading.note("companion-doubtful", None, what, "write the limits of the robot in <limit>, or in an arm.toml")


def rate(value: float | None) -> float:
    """A limit of a rate. Absent, zero and negative limits mean "not given"."""
    return value if value is not None and 0 < value < NO_LIMIT else np.inf


def _numbers(joint: ET.Element, tag: str, names: Iterable[str], reading: Reading) -> dict[str, float]:
    """The numbers of an element by name, infinite ones too."""
    element = joint.find(tag)
    given = {} if element is None else element.attrib
    with reading.numbers_of(joint, "", "write it in digits, with a point"):
        return {name: number_in(given[name], f"its limit {name}", -np.inf, np.inf) for name in names if name in given}
