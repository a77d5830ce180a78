"""`bake`: the arm as numbers, for Python without Pinocchio, C++, MATLAB and MoveIt, and as a URDF; `dh`: its table."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from ...arm.baking import SUFFIX, digest_of, text_of
from ...arm.loading.from_dh import PARALLEL, dh_csv, dh_rows, to_dh
from ...description.dh import PARAMETERS
from ...export import limits_yaml, matlab, urdf
from ...export.cpp_header import SUFFIXES, core_headers, cpp_header, namespace_of
from ...support.errors import InputError
from ...support.messages import plural
from ..numbers import option, quantity
from ..options import ArmArgument, CsvAnswer, answers
from ..output import STDOUT, Outputs, entries
from ..tables import Column, Table

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
        "output form force json", KINDS, True, output="*.json, *.hpp, *.m, *.yaml, *.urdf; default ARM.json; repeat it."
    ),
]


def bake(source: ArmArgument, outputs: Written) -> None:
    """Write the arm as numbers: arm.json, a C++17 header, a MATLAB function, joint limits, or a URDF."""
    arm = source.load()
    outputs = outputs if outputs.files else outputs.named(f"{Path(arm.name).name}.{outputs.form or 'json'}")
    if wrong := next((n for kind, n in outputs.files if kind == "yaml" and Path(n).stem.endswith("controllers")), None):
        raise InputError(f"{wrong} is a name for controllers, and bake writes joint limits: name it joint_limits.yaml")
    include = core_headers() if any(kind == "hpp" for kind, _ in outputs.files) else None
    function = next((Path(name).name for kind, name in outputs.files if kind == "m" and name != STDOUT), None)
    # Meshes of a URDF are relative to its folder, so the text depends on where it goes.
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


ROWS = {"standard": "R_z(θ) T_z(d) T_x(a) R_x(α)", "modified": "R_x(α) T_x(a) R_z(θ) T_z(d)"}

Convention = Annotated[str, option("standard|modified", "That of Paul, Spong and Siciliano, or of Craig.")]
Parallel = Annotated[
    float | None,
    quantity("rad", "Axes within this count as parallel; others meet far away [°, or rad with --rad]; 1e-7 rad."),
]


def dh(source: ArmArgument, out: CsvAnswer, convention: Convention = "standard", parallel: Parallel = None) -> None:
    """Show the arm's Denavit–Hartenberg table, or write it as a *.csv that is an ARM too."""
    arm = source.load()
    found = to_dh(arm, convention, PARALLEL if parallel is None else parallel)
    rows = dh_rows(found)
    columns = [
        Column("joint", [row["joint"] for row in rows]),
        Column("type", [row["type"] for row in rows]),
        *(Column(name, [row[name] for row in rows], unit, digits=6, key=name) for name, unit in PARAMETERS.items()),
    ]
    caption = f"a row is {ROWS[found.convention]}; a joint adds its coordinate to theta, or to d if it is prismatic"
    out.show(
        {"arm": arm, **entries(found, "convention base tool residual")},
        Table(f"{arm.name}: {found.convention} convention", columns, "rows"),
        caption,
        f"the table differs from the arm by {found.residual:.1g} m or rad at most",
        files={"csv": lambda: dh_csv(found)},
    )
