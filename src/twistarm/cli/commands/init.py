"""`init`: a first arm.toml from what is found."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from ...loading.arm_file_draft import draft_arm_file
from ...loading.load import load_arm
from ...support.errors import InputError
from ..options import Base, Env, PackageDir, Srdf, Tip, Without, Xacro, xacro_arguments
from ..output import say
from ..outputs import NAMED, STDOUT, Force, outputs_of

File = Annotated[str, typer.Argument(metavar="FILE", help="URDF or xacro file.")]


def init(
    file: File,
    output: Annotated[str, NAMED] = "arm.toml",
    base: Base = None,
    tip: Tip = None,
    package_dir: PackageDir = None,
    xacro: Xacro = None,
    without: Without = None,
    env: Env = None,
    srdf: Srdf = None,
    force: Force = False,
) -> int:
    """Write a commented arm.toml for FILE: base, tip, xacro arguments, limits to fill in, the ready pose."""
    outputs = outputs_of(output, {"toml": (".toml",)}, force=force, over_description=True)
    if output != STDOUT and not output.endswith(".toml"):
        raise InputError(f"an arm file is named *.toml; got {output}")
    draft = draft_arm_file(
        file,
        Path(os.path.realpath(output)).parent,
        base=base,
        tip=tip,
        package_dirs=package_dir or (),
        xacro_args=xacro_arguments(xacro or []),
        srdf=srdf,
        without=without or (),
        env=env or (),
    )
    outputs.write({"toml": lambda: draft.text})
    if draft.unclear:
        unclear = f"take the # away from one tip = in it before it loads: {draft.unclear}"
        say(f"{output}: written, but {unclear}", file=outputs.words)
        return 1
    if output != STDOUT:
        arm = load_arm(output, env=env or ())
        say(f"{output}: {arm.n} joints from {arm.base} to {arm.tip}; next: twistarm info {output}")
    return 0
