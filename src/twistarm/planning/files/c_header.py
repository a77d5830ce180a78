"""A trajectory as a C99 and C++17 header: a table and functions that evaluate it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ...limits.actuators import Actuators
from ...support.c_text import c_number, c_string, c_strings, identifier_of
from ...support.checks import Array, as_flag
from .motor_values import counted, motors_of, require_motors

if TYPE_CHECKING:
    from ..trajectory import Trajectory

SUFFIXES = (".h", ".hpp", ".hh", ".hxx")


def header_text(
    trajectory: Trajectory, file: str = "motion.h", actuators: Actuators | None = None, *, counts: bool = False
) -> str:
    """Return the text that `Trajectory.to_header` writes. Every name in it begins with that of the file."""
    name = identifier_of(Path(file).stem, "motion")
    if as_flag(counts, "counts"):
        trajectory = counted(trajectory, require_motors(motors_of(trajectory, actuators)))
    columns = zip(trajectory.joint_names, trajectory.units, strict=True)
    return _TEMPLATE.format(
        name=name,
        file=c_string(Path(file).name),
        guard=f"TWISTARM_MOTION_{name.upper()}_H",
        order=", ".join(f"{c_string(joint)} [{unit}]" for joint, unit in columns),
        n=trajectory.n,
        pieces=len(trajectory.breakpoints) - 1,
        degree=len(trajectory.coefficients) - 1,
        seconds=f"{trajectory.duration:.6g}",
        duration=c_number(trajectory.duration),
        joint_names=c_strings(trajectory.joint_names),
        units=c_strings(trajectory.units),
        breakpoints=_numbers(trajectory.breakpoints[:-1]),
        coefficients=",\n    ".join(map(_piece, trajectory.coefficients.transpose(1, 2, 0))),
        labels=_labels(trajectory, name),
    )


def _piece(coefficients: Array) -> str:
    return "{" + ",\n     ".join(f"{{{_numbers(row)}}}" for row in coefficients) + "}"


def _numbers(values: Array) -> str:
    return ", ".join(map(c_number, values))


def _labels(trajectory: Trajectory, name: str) -> str:
    if not trajectory.labels:
        return ""
    rows = ",\n    ".join(f"{{{c_number(time)}, {c_string(text)}}}" for time, text in trajectory.labels)
    return _LABELS.format(name=name, count=len(trajectory.labels), rows=rows)


_LABELS = """
/* What else happens on the way, in the order of time [s]. */
enum {{ {name}_label_count = {count} }};
typedef struct {{
    TWISTARM_REAL time;
    const char *text;
}} {name}_label;
static const {name}_label {name}_labels[{name}_label_count] = {{
    {rows}}};
"""

_TEMPLATE = """\
/* A motion of {seconds} s, written by twistarm; plan it again and write this again.
 *
 * C99 and C++17, without heap, state or a library:
 *
 *     #define TWISTARM_REAL float   (before the first such header, where double is not wanted)
 *     #include {file}
 *
 *     TWISTARM_REAL theta[{name}_joints];
 *     {name}_theta(t, theta);       (t in seconds; and {name}_velocity, {name}_acceleration)
 *
 * theta: {order}.
 */
#ifndef {guard}
#define {guard}

#ifndef TWISTARM_REAL
#define TWISTARM_REAL double
#endif

enum {{ {name}_joints = {n}, {name}_pieces = {pieces}, {name}_degree = {degree} }};

static const char *const {name}_joint_names[{name}_joints] = {{{joint_names}}};
static const char *const {name}_units[{name}_joints] = {{{units}}};

static const TWISTARM_REAL {name}_duration = (TWISTARM_REAL){duration};
{labels}
/* When each piece begins [s]. */
static const TWISTARM_REAL {name}_breakpoints[{name}_pieces] = {{{breakpoints}}};

/* Of each piece and joint a polynomial in the time since the piece began, highest power first. */
static const TWISTARM_REAL {name}_coefficients[{name}_pieces][{name}_joints][{name}_degree + 1] = {{
    {coefficients}}};

/* The derivative of that order; at t outside [0, duration] that of the end. */
static inline void {name}_derivative(TWISTARM_REAL t, int order, TWISTARM_REAL *out) {{
    int low = 0, high = {name}_pieces - 1, joint, power, factor;
    TWISTARM_REAL tau;
    if (!(t > 0)) t = 0;
    if (t > {name}_duration) t = {name}_duration;
    while (low < high) {{
        const int middle = (low + high + 1) / 2;
        if ({name}_breakpoints[middle] <= t)
            low = middle;
        else
            high = middle - 1;
    }}
    tau = t - {name}_breakpoints[low];
    for (joint = 0; joint < {name}_joints; ++joint) {{
        TWISTARM_REAL value = 0;
        for (power = {name}_degree; power >= order; --power) {{
            TWISTARM_REAL term = {name}_coefficients[low][joint][{name}_degree - power];
            for (factor = power; factor > power - order; --factor) term *= (TWISTARM_REAL)factor;
            value = value * tau + term;
        }}
        out[joint] = value;
    }}
}}

static inline void {name}_zero(TWISTARM_REAL *out) {{
    int joint;
    for (joint = 0; joint < {name}_joints; ++joint) out[joint] = 0;
}}

/* theta at t [s]; before 0 and for what is no number the start, after the duration the end. */
static inline void {name}_theta(TWISTARM_REAL t, TWISTARM_REAL *theta) {{ {name}_derivative(t, 0, theta); }}

/* The velocity at t [s]: zero at both ends and outside. */
static inline void {name}_velocity(TWISTARM_REAL t, TWISTARM_REAL *theta_dot) {{
    if (t > 0 && t < {name}_duration)
        {name}_derivative(t, 1, theta_dot);
    else
        {name}_zero(theta_dot);
}}

/* The acceleration at t [s]: at the ends from inside, zero outside. */
static inline void {name}_acceleration(TWISTARM_REAL t, TWISTARM_REAL *theta_ddot) {{
    if (t >= 0 && t <= {name}_duration)
        {name}_derivative(t, 2, theta_ddot);
    else
        {name}_zero(theta_ddot);
}}

#endif
"""
