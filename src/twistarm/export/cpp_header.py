"""An arm as a C++17 header: the constants of its chain for the kernels in core/include."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..arm.arm import Arm
from ..arm.baking import digest_of
from ..control.servo import ServoSettings
from ..control.servo.settings import bounds_of
from ..ik import AnyTarget, Approach, Pose, Position
from ..ik.closed_form.methods import ClosedFormParameters, method_for
from ..support.checks import Array
from ..support.code_text import c_number, c_string, c_strings, cpp_number, cpp_numbers, filled, identifier_of
from ..support.errors import TwistarmError

TEMPLATES = Path(__file__).with_name("templates")

SUFFIXES = (".hpp", ".hh", ".hxx", ".h")

KEEPS = ("nothing", "point", "plane")  # `twistarm::closed_form::keeps`, in its order.
MOTION = ("lower", "upper", "velocity", "acceleration")  # Limits of a joint's motion.


def core_headers() -> Path:
    """The folder for a compiler's -I: in the installed package, or core/include in a checkout."""
    package = Path(__file__).resolve().parents[1]
    installed = package / "include"
    folder = installed if installed.is_dir() else package.parents[1] / "core" / "include"
    if not (folder / "twistarm" / "twistarm.hpp").is_file():
        raise TwistarmError(f"the C++ headers are missing in {installed}; install twistarm again")
    return folder


def namespace_of(name: str) -> str:
    """A C++ namespace after an arm's name."""
    return identifier_of(name, "arm")


def cpp_header(arm: Arm) -> str:
    """The header's text: the arm's constants, `solve_ik`, and `solve_ik_all` for the arm's family.

    The constants are `chain`, limits, poses, `servo_bounds` and `actuators`. The chain is that of the compiled core:
    constant transforms between joints that turn about z (core/include/twistarm/kinematics/chain.hpp). TwistarmError
    without a core.
    """
    constants: Mapping[str, Any] = arm.require_core("a C++ header").constants()
    joints, n = constants["joints"], constants["coordinates"]
    lower, upper = arm.sampling_bounds  # finite, for the random starts of the solver
    poses = {"ready": arm.ready, **arm.named_states}
    return filled(
        TEMPLATES / "arm.hpp.in",
        arm=c_string(arm.name),
        namespace=namespace_of(arm.name),
        digest=digest_of(arm),
        base=c_string(arm.base),
        tip=c_string(arm.tip),
        order=", ".join(f"{c_string(name)} [{unit}]" for name, unit in zip(arm.joint_names, arm.units, strict=True)),
        n=n,
        m=joints,
        names=c_strings(arm.joint_names),
        **{field: _doubles(getattr(arm.limits, field)) for field in (*MOTION, "effort")},
        start_lower=_doubles(lower),
        start_upper=_doubles(upper),
        reach=repr(float(arm.reach)),
        tool_axis=cpp_numbers(arm.tool_axis),
        pose_count=len(poses),
        pose_names=c_strings(poses),
        poses=_rows(map(cpp_numbers, poses.values())),
        identity=_truth(constants["identity"]),
        base_frame=_frame(constants["base"]),
        tip_frame=_frame(constants["tip"]),
        links=_rows(map(_link, constants["links"])),
        coupling=_rows(map(cpp_numbers, np.asarray(constants["coupling"]))),
        **_servo(arm),
        motors_section=_motors(arm),
        closed_form_section=_closed_form(arm),
    )


def _servo(arm: Arm) -> Mapping[str, str | int]:
    """The members of `twistarm::servo_bounds` and its `motion_limits`, with the default settings."""
    bounds = bounds_of(arm, ServoSettings())
    motion = bounds.motion
    motors = len(motion.names) - arm.n
    return {
        "motors": motors,
        "rows": len(motion.names),
        "row_names": c_strings(motion.names),
        "motor_C": "{" + ", ".join(map(cpp_numbers, motion.C[:motors])) + "}",
        "motor_c": cpp_numbers(motion.c[:motors]),
        **{f"row_{field}": cpp_numbers(getattr(motion.limits, field)) for field in MOTION},
        "unit": cpp_numbers(bounds.unit),
        "ready": cpp_numbers(bounds.ready),
        "length": cpp_number(bounds.length),
        "below": cpp_number(bounds.singularity_threshold),
        "damping": cpp_number(bounds.damping),
    }


def _motors(arm: Arm) -> str:
    """The arm's `twistarm::actuators`, or that it has none."""
    motors = arm.actuators
    if motors is None or not motors.names:
        return "// No motors are described: with [actuators] in the arm.toml, `actuators` is here.\n"
    n, k, determined = arm.n, len(motors.names), not motors.undriven
    return filled(
        TEMPLATES / "actuators.hpp.in",
        k=k,
        names=c_strings(motors.names),
        units=c_strings(motors.motor_units),
        counted=c_strings(motors.units),
        determined=_truth(determined),
        G=_rows(map(cpp_numbers, motors.G)),
        offset=cpp_numbers(motors.offset),
        P=_rows(map(cpp_numbers, motors.P if determined else np.zeros((n, k)))),
        counts=cpp_numbers(motors.counts_per_unit),
    )


def _closed_form(arm: Arm) -> str:
    """A `twistarm::solved_arm` per kind of target, and `solve_ik_all`. A remark says if no kind has one."""
    kinds: dict[str, AnyTarget] = {
        "pose": Pose(arm.home),
        "position": Position(arm.home[:3, 3]),
        "approach": Approach(arm.home[:3, 3], arm.home[:3, 2], arm.tool_axis),
    }
    families, choices = "", ""
    for kind, target in kinds.items():
        method = method_for(arm, target)
        if method.exact and method.numbers is not None:
            families += _family(arm, kind, method.numbers, method.in_words(arm))
            choices += f"if constexpr (Target::kind == twistarm::target_kind::{kind})\n        "
            choices += f"solve({kind}_family<T>);\n    else "
    if not families:
        return "// The arm's axes belong to no family: there is no closed form that finds every configuration.\n"
    return families + filled(TEMPLATES / "all_configurations.hpp.in", choices=choices)


def _family(arm: Arm, kind: str, numbers: ClosedFormParameters, words: str) -> str:
    held = [int(i) for i in numbers.held]
    held_words = f" Held at theta0: {', '.join(arm.joint_names[i] for i in held)}." if held else ""
    axes, held_axes = (
        ", ".join(f"{{{cpp_numbers(axis[:3])}, {cpp_numbers(axis[3:6])}, {_truth(axis[6])}}}" for axis in table)
        for table in (numbers.axes, numbers.held_axes)
    )
    joints = ", ".join(str(int(i)) for i in numbers.joint)
    idle = sum(1 << i for i in np.flatnonzero(numbers.idle).tolist())
    keeps = KEEPS[numbers.keeps]
    return f"""\
/// For a {kind}: {words}.{held_words}
template <class T> inline constexpr twistarm::solved_arm<T, n> {kind}_family = {{
    {{{len(numbers.axes)}, {numbers.first}, {numbers.last}, twistarm::closed_form::keeps::{keeps},
     {{{axes}}},
     {{{_truth(keeps == "plane")}, {cpp_numbers(numbers.kept[:3])}, {cpp_number(numbers.kept[3])}}}}},
    {{{joints}}},
    {len(held)}, {{{", ".join(map(str, held))}}}, {{{held_axes}}},
    {cpp_numbers(numbers.rate)},
    {_frame(numbers.home)},
    {idle}U,
}};

"""


def _doubles(values: Array) -> str:
    return ", ".join(map(c_number, values))


def _truth(value: object) -> str:
    return "true" if value else "false"


def _frame(g: Array) -> str:
    """`twistarm::frame`: the columns x, y, z and p."""
    return "{" + ", ".join(cpp_numbers(column) for column in np.asarray(g)[:3].T) + "}"


def _link(link: Mapping[str, Any]) -> str:
    """`twistarm::link`, in the order of its members."""
    numbers = ", ".join(cpp_number(link[name]) for name in ("cos_alpha", "sin_alpha", "turn", "phase", "slide"))
    return f"{{{cpp_numbers(link['offset'])}, {numbers}, {_truth(link['revolute'])}}}"


def _rows(rows: Iterable[str]) -> str:
    return "{\n" + "".join(f"        {row},\n" for row in rows) + "    }"
