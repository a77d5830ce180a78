"""`bake`: the arm as one file of numbers, for Python without Pinocchio and for C++."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..arm import Arm
from ..baking import digest_of
from ..cpp_header import core_headers, namespace_of, write_cpp_header
from ..errors import InputError
from .options import Json, takes_arm
from .output import print_json

File = Annotated[
    Path | None, typer.Argument(metavar="FILE", help="Where to write it, *.json; by default the arm's name.")
]
Cpp = Annotated[Path | None, typer.Option(metavar="FILE", help="Write a C++17 header, *.hpp; the arm.json if named.")]
Force = Annotated[bool, typer.Option("--force", help="Replace files that are there.")]


@takes_arm
def bake(arm: Arm, file: File = None, cpp: Cpp = None, force: Force = False, json: Json = False) -> None:
    """Write the arm's chain as numbers: an arm.json, read without Pinocchio and the description; or a C++ header."""
    baked = Path(f"{Path(arm.name).name}.json") if file is None and cpp is None else file
    for path in (baked, cpp):
        if path is not None and path.exists() and not force:
            raise InputError(f"{path} exists; --force replaces it, another name writes elsewhere")
    include = None if cpp is None else core_headers()
    if cpp is not None:
        write_cpp_header(arm, cpp)
    if baked is not None:
        arm.bake(baked)
    if json:
        answer = {"arm": arm.name, "digest": digest_of(arm.kept), "file": baked, "cpp": cpp, "include": include}
        print_json({key: str(value) if isinstance(value, Path) else value for key, value in answer.items()})
        return
    if baked is not None:
        print(f"{baked}: {arm.name}, {arm.n} joints from {arm.base} to {arm.tip}; next: twistarm info {baked}")
    if cpp is not None:
        print(f"{cpp}: {arm.name} as namespace {namespace_of(arm.name)}; compile with -std=c++17 -I {include}")
