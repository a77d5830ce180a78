"""`bake`: the arm as one file of numbers, for Python without Pinocchio and for C++."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ...export.cpp_header import SUFFIXES, core_headers, cpp_header, namespace_of
from ...model.arm import Arm
from ...model.baking import SUFFIX, digest_of, text_of
from ..options import Json, takes_arm
from ..output import print_json, say
from ..outputs import STDOUT, Force, Format, outputs_of

Output = Annotated[
    list[str] | None,
    typer.Option("--output", "-o", metavar="FILE", help="*.json or *.hpp, by default ARM.json; repeat it for both."),
]


@takes_arm
def bake(arm: Arm, output: Output = None, form: Format = None, force: Force = False, json: Json = False) -> None:
    """Write the arm's chain as numbers: arm.json, read without Pinocchio and the description; or a C++17 header."""
    kinds = {"json": (SUFFIX,), "hpp": SUFFIXES}
    outputs = outputs_of(output or f"{Path(arm.name).name}.{form or 'json'}", kinds, form, force=force, json=json)
    include = core_headers() if any(kind == "hpp" for kind, _ in outputs.files) else None
    written = outputs.write({"json": lambda: text_of(arm._baked), "hpp": lambda: cpp_header(arm)})
    if json:
        print_json(
            {"arm": arm.name, "digest": digest_of(arm._baked), "written": written, "include": include and str(include)}
        )
        return
    for kind, name in outputs.files:
        then = "" if name == STDOUT else f"; next: twistarm info {name}"
        baked = f"{arm.name}, {arm.n} joints from {arm.base} to {arm.tip}{then}"
        header = f"{arm.name} as namespace {namespace_of(arm.name)}; compile with -std=c++17 -I {include}"
        say(f"{name}: {baked if kind == 'json' else header}", file=outputs.words)
