"""`bake`: the arm as a file of numbers, for Python without Pinocchio, C++, MATLAB and MoveIt, and as a URDF."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from ...arm.baking import SUFFIX, digest_of, text_of
from ...export import limits_yaml, matlab, urdf
from ...export.cpp_header import SUFFIXES, core_headers, cpp_header, namespace_of
from ...support.messages import plural
from ..options import ArmArgument, answers
from ..output import STDOUT, Outputs

KINDS = {
    "json": (SUFFIX,),
    "hpp": SUFFIXES,
    "m": (matlab.SUFFIX,),
    "yaml": limits_yaml.SUFFIXES,
    "urdf": (urdf.SUFFIX,),
}
Written = Annotated[
    Outputs,
    answers(
        "output form force json", KINDS, output="*.json, *.hpp, *.m, *.yaml or *.urdf, by default ARM.json; repeat it."
    ),
]


def bake(source: ArmArgument, outputs: Written) -> None:
    """Write the arm as numbers: arm.json, a C++17 header, a MATLAB function, joint limits, or a URDF."""
    arm = source.load()
    outputs = outputs if outputs.files else outputs.named(f"{Path(arm.name).name}.{outputs.form or 'json'}")
    include = core_headers() if any(kind == "hpp" for kind, _ in outputs.files) else None
    function = next((Path(name).name for kind, name in outputs.files if kind == "m" and name != STDOUT), None)
    folder = next((Path(name).parent for kind, name in outputs.files if kind == "urdf"), None)
    description = "" if folder is None else urdf.to_urdf(arm, folder)
    lost = [] if folder is None else urdf.lost_meshes(description, folder)
    left = f"; {plural(len(lost), 'mesh', 'meshes')} not found from there: give --package-dir" if lost else ""
    written = outputs.write(
        {
            "json": lambda: text_of(arm),
            "hpp": lambda: cpp_header(arm),
            "m": lambda: matlab.matlab_text(arm, function),
            "yaml": lambda: limits_yaml.limits_yaml(arm),
            "urdf": lambda: description,
        }
    )
    lines = []
    for kind, name in outputs.files:
        then = "" if name == STDOUT else f"; next: twistarm info {name}"
        described = {
            "json": f"{arm.name}, {arm.n} joints from {arm.base} to {arm.tip}{then}",
            "hpp": f"{arm.name} as namespace {namespace_of(arm.name)}; compile with -std=c++17 -I {include}",
            "m": f"{arm.name} as a function of MATLAB and Octave, which tests itself: arm = {Path(name).stem}(); "
            "arm.check()",
            "yaml": f"joint limits of {arm.name}, for MoveIt, ros2_control and --limits",
            "urdf": f"{arm.name} as a description; the same arm is --base {arm.base} --tip {arm.tip}{left}{then}",
        }
        lines.append(f"{name}: {described[kind]}")
    data = {"arm": arm, "digest": digest_of(arm), "include": include and str(include), "meshes_not_found": lost}
    outputs.show(data | {"written": written}, *lines)
