"""`init`: a first arm.toml from what is found."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from ...loading.arm_file_draft import draft_arm_file
from ...loading.load import load_arm
from ...planning.motion_file_draft import draft_motion_file
from ...support.errors import InputError
from ..options import Base, Env, PackageDir, Srdf, Tip, Without, Xacro, xacro_arguments
from ..output import say
from ..outputs import NAMED, STDOUT, Force, outputs_of

Motion = Annotated[
    bool,
    typer.Option("--motion", help="Write a first motion.toml for the arm, as plan takes it."),
]
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
    motion: Motion = False,
) -> int:
    """Write a commented arm.toml for FILE (base, tip, limits to fill in, the ready pose), or a first motion.toml."""
    if motion:
        return _motion(file, "motion.toml" if output == "arm.toml" else output, env or (), force)
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


def _motion(source: str, output: str, env: Sequence[str], force: bool) -> int:
    """A first motion.toml for an arm: a description, an arm.toml or a name."""
    outputs = outputs_of(output, {"toml": (".toml",)}, force=force)
    arm = load_arm(source, env=env)
    outputs.write({"toml": lambda: draft_motion_file(arm)})
    if output != STDOUT:
        say(f"{output}: a motion with every kind of segment; next: twistarm plan {source} {output}")
    return 0
