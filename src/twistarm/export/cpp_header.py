"""An arm as a C++17 header: the constants of its chain for the kernels in core/include."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..arm.arm import Arm
from ..arm.baking import digest_of
from ..control.servo import ServoSettings
from ..control.servo.bounds import bounds_of
from ..support.c_text import c_number, c_string, c_strings, cpp_number, cpp_numbers, identifier_of
from ..support.checks import Array
from ..support.errors import TwistarmError
from .cpp_closed_form import cpp_closed_form

SUFFIXES = (".hpp", ".hh", ".hxx", ".h")


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
    constants: Mapping[str, Any] = arm._core("a C++ header").constants()
    joints, n = constants["joints"], constants["coordinates"]
    lower, upper = arm.sampling_bounds
    poses = {"ready": arm.ready, **arm.named_states}
    return _TEMPLATE.format(
        arm=c_string(arm.name),
        namespace=namespace_of(arm.name),
        digest=digest_of(arm),
        base=c_string(arm.base),
        tip=c_string(arm.tip),
        order=", ".join(f"{c_string(name)} [{unit}]" for name, unit in zip(arm.joint_names, arm.units, strict=True)),
        n=n,
        m=joints,
        names=c_strings(arm.joint_names),
        lower=_doubles(arm.limits.lower),
        upper=_doubles(arm.limits.upper),
        start_lower=_doubles(lower),
        start_upper=_doubles(upper),
        velocity=_doubles(arm.limits.velocity),
        acceleration=_doubles(arm.limits.acceleration),
        effort=_doubles(arm.limits.effort),
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
        closed_form_section=cpp_closed_form(arm),
    )


def _servo(arm: Arm) -> Mapping[str, str | int]:
    """The members of `twistarm::servo_bounds` and its `motion_limits`, with the default settings."""
    bounds = bounds_of(arm, ServoSettings())
    motion = bounds.motion
    motors = len(motion.names) - bounds.n
    return {
        "motors": motors,
        "rows": len(motion.names),
        "row_names": c_strings(motion.names),
        "motor_C": "{" + ", ".join(map(cpp_numbers, motion.C[:motors])) + "}",
        "motor_c": cpp_numbers(motion.c[:motors]),
        **{
            f"row_{name}": cpp_numbers(getattr(motion.limits, name))
            for name in ("lower", "upper", "velocity", "acceleration")
        },
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
        return "// No motors are described: with [actuators] in the arm.toml, `actuators` stands here.\n"
    n, k, determined = arm.n, len(motors.names), not motors.undriven
    return _MOTORS.format(
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


# -- numbers and texts as C++ writes them ------------------------------------------------------------------------


def _doubles(values: Array) -> str:
    return ", ".join(map(c_number, values))


def _truth(value: bool) -> str:
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


_MOTORS = """\
/// Motors, what their positions are in, and what their drives count.
inline constexpr int motors = {k};
inline constexpr const char* motor_names[motors] = {{{names}}};
inline constexpr const char* motor_units[motors] = {{{units}}};
inline constexpr const char* count_units[motors] = {{{counted}}};

/// From joints to motors and to what their drives count, and back (twistarm/kinematics/actuators.hpp):
///
///     T motor[motors], counts[motors];
///     actuators<T>.to_motor(theta, motor);    // and to_theta; velocity_to_motor, velocity_to_theta
///     actuators<T>.to_counts(motor, counts);  // and from_counts; not rounded
template <class T> inline constexpr twistarm::actuators<T, n, motors, {determined}> actuators = {{
    {G},
    {offset},
    {P},
    {counts},
}};
"""

_TEMPLATE = """\
// The arm {arm} from {base} to {tip}, written by twistarm; change the arm and write this again.
//
// C++17 without heap, exceptions or run-time types, for T = float or double:
//
//     g++ -std=c++17 -O2 -I FOLDER program.cpp        (FOLDER is what `twistarm bake -o FILE.hpp` names)
//
//     double theta[{namespace}::n] = {{}};
//     const auto g = twistarm::forward({namespace}::chain<double>, theta);
//     twistarm::column<double> J[{namespace}::n];
//     twistarm::forward_with_body_jacobian({namespace}::chain<double>, theta, J);
//     const auto ranges = {namespace}::ranges<double>();
//     const auto found = {namespace}::solve_ik(ranges, twistarm::pose_target(g), {namespace}::poses<double>[0]);
//     if (found.converged) use(found.theta);
//
//     twistarm::servo_state<double, {namespace}::n> state{{}};  // and state.theta as measured
//     twistarm::servo_command<double, {namespace}::n> command{{}};
//     command.kind = twistarm::servo_kind::twist;
//     command.twist[0] = 0.05;  // m/s along the tool's x; more in twistarm/servo/servo.hpp
//     twistarm::servo_output<double> out;
//     auto bounds = {namespace}::servo_bounds<double>;
//     bounds.stops = true;  // where the arm cannot follow it stops on its course; false: it slides along
//     twistarm::servo_step({namespace}::chain<double>, bounds, command, 0.01, state, out);
#pragma once

#include <cstdint>
#include <type_traits>

#include <twistarm/twistarm.hpp>

namespace {namespace} {{

/// theta: {order}; SI.
inline constexpr int n = {n};
/// Joints of the chain: neighbours that move as one are one, followers count.
inline constexpr int m = {m};

/// Of the arm.json that `twistarm bake` writes of the same arm.
inline constexpr char digest[] = "{digest}";

inline constexpr const char* joint_names[n] = {{{names}}};

inline constexpr double infinite = __builtin_inf();

/// Limits [rad or m, and per s, s²; N m or N]; infinite where none is given.
inline constexpr double lower[n] = {{{lower}}};
inline constexpr double upper[n] = {{{upper}}};
inline constexpr double velocity[n] = {{{velocity}}};
inline constexpr double acceleration[n] = {{{acceleration}}};
inline constexpr double effort[n] = {{{effort}}};

/// Where random starts of inverse kinematics are drawn from.
inline constexpr double start_lower[n] = {{{start_lower}}};
inline constexpr double start_upper[n] = {{{start_upper}}};

/// Named poses; the first is well conditioned and inside the limits, a place to start from.
inline constexpr int pose_count = {pose_count};
inline constexpr const char* pose_names[pose_count] = {{{pose_names}}};
template <class T> inline constexpr T poses[pose_count][n] = {poses};

/// base · J₁ · L₂ J₂ ⋯ J_m · tip; the members are explained in twistarm/kinematics/chain.hpp.
template <class T> inline constexpr twistarm::chain<T, n, m> chain = {{
    n, m, {identity},
    {base_frame},
    {tip_frame},
    {links},
    {coupling},
}};

/// Name of `servo_output::row`, motors first; for a singularity, row counts `joint_names`.
inline constexpr const char* row_names[{rows}] = {{{row_names}}};

/// What `servo_step` needs beside the chain: the limits of those rows, unit, ready, length (the reach [m]), below,
/// damping and stops, which may be true in a copy (Python's `ServoSettings(on_unreachable="stop")`); explained in
/// twistarm/kinematics/motion_limits.hpp and servo/resolved_rates.hpp.
template <class T> inline constexpr twistarm::servo_bounds<T, n> servo_bounds = {{
    {{
        {motors}, n,
        {motor_C},
        {motor_c},
        {row_lower},
        {row_upper},
        {row_velocity},
        {row_acceleration},
    }},
    {unit},
    {ready},
    {length}, {below}, {damping}, false,
}};

{motors_section}
/// The limits as `solve_ik` takes them; make them once.
template <class T> twistarm::ranges<T, n> ranges() {{
    return twistarm::ranges_of(chain<T>, lower, upper, start_lower, start_upper);
}}

/// The tool's own axis, about which the last joint rolls it: what an approach points where no other is meant.
template <class T> inline constexpr T tool_axis[3] = {tool_axis};

/// Inverse kinematics inside the limits: from theta0 (n,), then from random starts of `seed`, settings.searches in all.
///
/// `asked` is what twistarm::pose_target(g), position_target(p), approach_target(p, direction, tool_axis) or
/// task_target(g, tolerance, base_axes) returns (twistarm/ik/target.hpp). Where its kind is known only when the program
/// runs, a twistarm::target<T>, the solvers of all four kinds are compiled.
///
/// These are the searches of Python's solve_ik, with the same answer where one of them meets the target; where none
/// does, the end of the one that came nearest, not converged. twistarm::answer_to (twistarm/ik/answer.hpp) goes on to
/// the nearest configuration and the reason, and keeps to the branch of theta0, as Python does, for twenty times the
/// code.
///
/// A target or a theta0 that is not finite is not searched for: the answer is theta0, not converged, its errors
/// infinite, its restarts 0.
///
/// `Lanes` searches (2, 4 or 8) run side by side; their number changes speed, code and stack, not the answer. The stack
/// holds the ends of 96 searches beside them, 96 n numbers.
template <int Lanes = 0, class T, class Target>
twistarm::solution<T, n> solve_ik(const twistarm::ranges<T, n>& limits, const Target& asked, const T* theta0,
                                  const twistarm::search_settings<T>& settings = {{}}, std::uint64_t seed = 0) {{
    constexpr bool is_target = std::is_base_of_v<twistarm::target<T>, Target>;
    constexpr bool fits = Lanes == 0 || Lanes == 2 || Lanes == 4 || Lanes == 8;
    static_assert(is_target, "solve_ik takes what twistarm::pose_target, position_target, approach_target or "
                             "task_target makes of numbers of the type that the ranges have");
    static_assert(fits, "solve_ik<Lanes>: 2, 4 or 8 searches run side by side; without <Lanes> as many as suit");
    twistarm::solution<T, n> found{{}};
    if constexpr (is_target && fits) {{
        if (twistarm::is_usable<T>(asked, theta0, n))
            twistarm::search_all<Lanes>(chain<T>, limits, settings, asked, theta0, seed, found);
        else
            twistarm::find_nothing(theta0, n, found);
    }}
    return found;
}}

/// The same where the kind of the target is named: what asks for another does not compile.
template <twistarm::target_kind Kind, int Lanes = 0, class T, class Target>
twistarm::solution<T, n> solve_ik(const twistarm::ranges<T, n>& limits, const Target& asked, const T* theta0,
                                  const twistarm::search_settings<T>& settings = {{}}, std::uint64_t seed = 0) {{
    static_assert(twistarm::may_be<Kind, Target>, "solve_ik<Kind> is asked for a target of another kind: leave out "
                                                  "<Kind>, the target knows its own");
    return solve_ik<Lanes>(limits, asked, theta0, settings, seed);
}}

{closed_form_section}
}}  // namespace {namespace}
"""
