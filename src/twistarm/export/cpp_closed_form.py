"""Part of an arm's C++ header: all configurations by the closed form of the arm's family."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..arm.arm import Arm
from ..ik import AnyTarget, Approach, Pose, Position
from ..ik.closed_form.compiled import ClosedFormParameters
from ..ik.closed_form.methods import method_for
from ..support.c_text import cpp_number, cpp_numbers
from ..support.checks import Array
from ..support.templates import filled

TEMPLATE = Path(__file__).with_name("templates") / "all_configurations.hpp.in"

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
    choices = "".join(_choice(kind) for kind, _, _ in known)
    return families + filled(TEMPLATE, choices=choices)


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
