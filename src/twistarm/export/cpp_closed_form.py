"""Part of an arm's C++ header: all configurations by the closed form of the arm's family."""

from __future__ import annotations

import numpy as np

from ..arm.arm import Arm
from ..ik import AnyTarget, Approach, Pose, Position
from ..ik.closed_form.compiled import ClosedFormParameters
from ..ik.closed_form.methods import method_for
from ..support.c_text import cpp_number, cpp_numbers
from ..support.checks import Array

KEEPS = ("nothing", "point", "plane")


def cpp_closed_form(arm: Arm) -> str:
    """A `twistarm::solved_arm` per kind of target, and `solve_ik_all`. A remark says if no kind has one."""
    kinds: dict[str, AnyTarget] = {
        "pose": Pose(arm.home),
        "position": Position(arm.home[:3, 3]),
        "approach": Approach(arm.home[:3, 3], arm.home[:3, 2], arm.tool_axis),
    }
    found = [(kind, method_for(arm, target)) for kind, target in kinds.items()]
    known = [(kind, method.numbers, method.in_words(arm)) for kind, method in found if method.numbers is not None]
    if not known:
        return "// The arm's axes belong to no family: there is no closed form that finds every configuration.\n"
    families = "".join(_family(arm, kind, numbers, words) for kind, numbers, words in known)
    return families + _SOLVE.replace("CHOICES", "".join(_choice(kind) for kind, _, _ in known))


def _choice(kind: str) -> str:
    return f"if constexpr (Target::kind == twistarm::target_kind::{kind})\n        solve({kind}_family<T>);\n    else "


def _family(arm: Arm, kind: str, numbers: ClosedFormParameters, words: str) -> str:
    held = [int(i) for i in numbers.held]
    standing = f" Where theta0 has them stand: {', '.join(arm.joint_names[i] for i in held)}." if held else ""
    axes, held_axes = (", ".join(map(_axis, each)) for each in (numbers.axes, numbers.held_axes))
    joints = ", ".join(str(int(i)) for i in numbers.joint)
    idle = sum(1 << i for i in np.flatnonzero(numbers.idle).tolist())
    plane = "true" if KEEPS[numbers.keeps] == "plane" else "false"
    columns = ", ".join(cpp_numbers(column) for column in numbers.home[:3].T)
    return f"""\
/// For a {kind}: {words}.{standing}
template <class T> inline constexpr twistarm::solved_arm<T, n> {kind}_family = {{
    {{{len(numbers.axes)}, {numbers.first}, {numbers.last}, twistarm::closed_form::keeps::{KEEPS[numbers.keeps]},
     {{{axes}}},
     {{{plane}, {cpp_numbers(numbers.kept[:3])}, {cpp_number(numbers.kept[3])}}}}},
    {{{joints}}},
    {len(held)}, {{{", ".join(map(str, held))}}}, {{{held_axes}}},
    {cpp_numbers(numbers.rate)},
    {{{columns}}},
    {idle}U,
}};

"""


def _axis(numbers: Array) -> str:
    return f"{{{cpp_numbers(numbers[:3])}, {cpp_numbers(numbers[3:6])}, {'true' if numbers[6] else 'false'}}}"


_SOLVE = """\
/// Every configuration that meets the target, each verified by forward kinematics: those inside the limits first,
/// nearest to theta0 first (twistarm/closed_form/all_solutions.hpp).
///
/// `asked` is what twistarm::pose_target, position_target or approach_target returns, of a kind that has a family
/// above; the tool axis of an approach is this arm's `tool_axis`.
template <class T, class Target>
twistarm::configurations<T, n> solve_ik_all(const twistarm::ranges<T, n>& limits, const Target& asked, const T* theta0,
                                            T position_tolerance, T orientation_tolerance) {
    twistarm::configurations<T, n> all;
    all.count = all.inside = 0;
    const auto solve = [&](const twistarm::solved_arm<T, n>& family) {
        if (!twistarm::is_usable<T>(asked, theta0, n)) return;
        T held[n] = {};
        for (int h = 0; h < family.held_count; ++h) {
            const int k = family.held[h];
            held[h] = twistarm::clamped(theta0[k], limits.lower[k], limits.upper[k]);
        }
        twistarm::find_all(chain<T>, family, limits, asked, theta0, held, position_tolerance, orientation_tolerance,
                           all);
    };
    CHOICESstatic_assert(sizeof(T) == 0, "no closed form for this kind of target: solve_ik searches");
    return all;
}
"""
